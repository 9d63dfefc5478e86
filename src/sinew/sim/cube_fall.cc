#include <algorithm>
#include <cmath>
#include <numeric>

#include "sinew/core/units.h"
#include "sinew/sim/cube_world.h"

/// Cubes that lose their support: they fall, tip, bounce and come to rest.
namespace sinew::sim {
namespace {

constexpr double kReach = 1.5e-3;      // m above a cube's bottom that still lifts it
constexpr double kSameHeight = 5e-4;   // m: supports that carry together
constexpr double kAreaLeast = 1e-8;    // m^2
constexpr double kUnsupported = 2e-4;  // m of air below a cube
constexpr double kDropTold = 3e-3;     // m
constexpr double kBounces = 0.06;      // m; lower falls end where they land
constexpr double kBounceMost = 0.06;   // m aside
constexpr double kClear = 3e-4;        // m beside what it slid off
constexpr double kTipTurn = 0.3;       // rad that tipping may turn it
constexpr int kTriesMost = 12;
constexpr std::size_t kBlocks = 5;  // of one basket

}  // namespace

std::optional<std::size_t> CubeWorld::basket_below(PlanPoint p) const {
  for (std::size_t i = 0; i < settings_.baskets.size(); ++i) {
    const Basket& basket = settings_.baskets[i];
    const Vec3 p_K = basket.X_WK.inverse() * Vec3{p.x, p.y, 0};
    if (std::abs(p_K.x) < basket.half.x && std::abs(p_K.y) < basket.half.y) return i;
  }
  return std::nullopt;
}

void CubeWorld::move_basket(std::size_t basket, const Pose<frame::World, frame::Basket>& X_WK) {
  SINEW_ASSERT(basket < settings_.baskets.size());
  constexpr double kAbove = 5e-3;  // m, over the rim
  const Basket before = settings_.baskets[basket];
  std::vector<bool> inside;
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    inside.push_back(cubes_[i].where == CubePlace::kBasket && basket_below(middle(i)) == basket);
  }
  settings_.baskets[basket].X_WK = X_WK;
  build_fixtures();
  const auto carried = X_WK * before.X_WK.inverse();
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (inside[i]) cubes_[i].X_WO = carried * cubes_[i].X_WO;
  }
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    const bool lies = cubes_[i].where != CubePlace::kGone && cubes_[i].where != CubePlace::kHeld;
    if (!lies || inside[i] || !is_crowded(i)) continue;
    put(i, middle(i), yaw(i), before.height + kAbove);
  }
}

/// The highest ones below a cube; none: the table.
std::vector<CubeWorld::Support> CubeWorld::supports_of(std::size_t cube) const {
  std::vector<Support> found;
  const PlanShape square = square_of(cube);
  const double low = bottom(cube);
  const auto look_at = [&](Support support) {
    if (support.top > low + kReach || support.top <= 0) return;
    if (area_of(common_part(square, support.shape)) > kAreaLeast)
      found.push_back(std::move(support));
  };
  for (std::size_t k = 0; k < fixtures_.size(); ++k) {
    const auto kind = k % kBlocks == 0 ? Support::Kind::kFloor : Support::Kind::kRim;
    look_at({kind, fixture_shapes_[k], heights_of(fixtures_[k]).high, std::nullopt});
  }
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (i == cube || cubes_[i].where == CubePlace::kGone) continue;
    const double apart = length(middle(i) - middle(cube));
    if (apart > cubes_[i].edge + cubes_[cube].edge) continue;
    look_at({Support::Kind::kCube, square_of(i), heights_of(block_of(i)).high, i});
  }
  double top = 0;
  for (const Support& support : found) top = std::max(top, support.top);
  std::erase_if(found, [&](const Support& support) { return support.top < top - kSameHeight; });
  return found;
}

bool CubeWorld::rests(std::size_t cube, std::span<const Support> supports) const {
  if (supports.empty()) return true;
  std::vector<PlanPoint> carried;
  bool on_rim = false;
  for (const Support& support : supports) {
    on_rim = on_rim || support.kind == Support::Kind::kRim;
    const PlanShape part = common_part(square_of(cube), support.shape);
    carried.insert(carried.end(), part.begin(), part.end());
  }
  // A wall is too thin to stand on.
  if (on_rim && supports.size() == 1) return false;
  return contains(hull_of(std::move(carried)), middle(cube));
}

void CubeWorld::set_place(std::size_t cube, std::span<const Support> supports) {
  CubeState& state = cubes_[cube];
  state.on.reset();
  for (const Support& support : supports) {
    if (support.cube) state.on = support.cube;
  }
  const PlanPoint at = middle(cube);
  const PlanPoint off = at - settings_.table_middle;
  if (basket_below(at)) {
    state.where = CubePlace::kBasket;
  } else if (state.on) {
    state.where = CubePlace::kOnCube;
  } else if (std::abs(off.x) > settings_.table_half.x || std::abs(off.y) > settings_.table_half.y) {
    state.where = CubePlace::kGone;
    note(CubeEvent::Kind::kFell, cube);
  } else {
    state.where = CubePlace::kTable;
  }
}

bool CubeWorld::is_crowded(std::size_t cube) const {
  const HeightRange mine = heights_of(block_of(cube));
  const PlanShape square = square_of(cube);
  const auto hits = [&](HeightRange its, const PlanShape& shape) {
    return its.high > mine.low + kReach && its.low < mine.high - kReach &&
           step_out(shape, square).has_value();
  };
  for (std::size_t k = 0; k < fixtures_.size(); ++k) {
    if (hits(heights_of(fixtures_[k]), fixture_shapes_[k])) return true;
  }
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (i == cube || cubes_[i].where == CubePlace::kGone) continue;
    if (hits(heights_of(block_of(i)), square_of(i))) return true;
  }
  return false;
}

/// Aside, away from what carries it on one side only.
void CubeWorld::slide_off(std::size_t cube, std::span<const Support> supports) {
  std::vector<PlanPoint> carried;
  for (const Support& support : supports) {
    const PlanShape part = common_part(square_of(cube), support.shape);
    carried.insert(carried.end(), part.begin(), part.end());
  }
  const PlanPoint at = middle(cube);
  PlanPoint toward = at - middle_of(carried);
  if (length(toward) < kClear) {
    const double turn = random_.uniform(-kPi, kPi);
    toward = {std::cos(turn), std::sin(turn)};
  }
  const double low = bottom(cube);
  place(cube, at, yaw(cube) + random_.uniform(-kTipTurn, kTipTurn), low);
  toward = direction_of(toward);
  double way = 0;
  for (const Support& support : supports) {
    way = std::max(way, slide_out(support.shape, square_of(cube), toward));
  }
  move(cube, (way + kClear) * toward);
  keep_out_of_walls(cube);
}

void CubeWorld::bounce(std::size_t cube, double height) {
  const PlanPoint from = middle(cube);
  for (int tries = 0; tries < kTriesMost; ++tries) {
    const double turn = random_.uniform(-kPi, kPi);
    const double way = random_.uniform(0.2, 1) * std::min(kBounceMost, height / 2);
    place(cube, from + way * PlanPoint{std::cos(turn), std::sin(turn)},
          random_.uniform(-kPi / 4, kPi / 4), 0);
    if (!is_crowded(cube)) return;
  }
}

void CubeWorld::fall(std::size_t cube) {
  const double begin = bottom(cube);
  bool tipped = false;
  bool stands = false;
  std::vector<Support> supports;
  for (int tries = 0; tries < kTriesMost; ++tries) {
    supports = supports_of(cube);
    const double top = supports.empty() ? 0 : supports.front().top;
    const double height = begin - top;
    place(cube, middle(cube), yaw(cube), top);
    if (supports.empty() && height > kBounces) {
      bounce(cube, height);
      stands = true;
      break;
    }
    const bool from_high = supports.size() == 1 && supports[0].cube && height > kBounces;
    stands = rests(cube, supports) && (!from_high || tipped);
    if (stands) break;
    if (!tipped) note(CubeEvent::Kind::kTipped, cube);
    tipped = true;
    slide_off(cube, supports);
  }
  bodies_[cube].wedged.reset();
  if (!stands) bodies_[cube].wedged = cubes_[cube].X_WO.p;
  moved_ = true;
  const double height = begin - bottom(cube);
  if (height > kDropTold) note(CubeEvent::Kind::kDropped, cube, height);
  set_place(cube, supports);
}

bool CubeWorld::settle(std::size_t cube) {
  if (bodies_[cube].wedged == cubes_[cube].X_WO.p) return false;
  const double low = bottom(cube);
  if (low == 0) {  // nothing that carries a cube is lower than the table
    set_place(cube, {});
    return false;
  }
  const std::vector<Support> supports = supports_of(cube);
  const double top = supports.empty() ? 0 : supports.front().top;
  if (low < top + kUnsupported && rests(cube, supports)) {
    place(cube, middle(cube), yaw(cube), top);
    set_place(cube, supports);
    return false;
  }
  fall(cube);
  return true;
}

bool CubeWorld::settle() {
  bool any = false;
  // Each fall may draw the support from under another cube, which lies higher.
  for (std::size_t round = 0; round <= cubes_.size(); ++round) {
    moved_ = false;
    std::vector<std::size_t> order(cubes_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
      const double low = bottom(a), other = bottom(b);
      return low < other || (low == other && a < b);
    });
    bool fell = false;
    for (const std::size_t cube : order) {
      if (is_free(cube)) fell = settle(cube) || fell;
    }
    any = any || fell;
    if (!fell) break;
  }
  return any;
}

void CubeWorld::calm() {
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    const bool apart = part_cubes();
    if (!settle() && apart) break;
  }
  moved_ = false;
}

}  // namespace sinew::sim
