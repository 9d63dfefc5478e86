#include "sinew/sim/cube_world.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/units.h"

namespace sinew::sim {
namespace {

constexpr double kStep = 1e-3;      // m that a hand moves at once
constexpr double kArm = 0.06;       // m from the tip to what moves when a hand turns
constexpr double kStepsMax = 2000;  // a hand that jumps further than this does so in larger steps
constexpr double kNear = 0.12;      // m from the tip to all that a hand may touch

double steps_between(const HandTruth& from, const HandTruth& to) {
  double way = norm(to.X_WT.p - from.X_WT.p) + kArm * angle_between(from.X_WT.R, to.X_WT.R);
  if (const auto* jaws = std::get_if<JawTruth>(&to.grip)) {
    way += std::abs(jaws->width - std::get<JawTruth>(from.grip).width);
  }
  return std::clamp(std::ceil(way / kStep), 1.0, kStepsMax);
}

}  // namespace

std::string_view name(CubeEvent::Kind kind) {
  constexpr std::array<std::string_view, 9> kNames{
      "grasped", "released", "slipped", "pushed", "dropped", "tipped", "thrown", "crash", "fell"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::array<Block, 5> blocks_of(const Basket& basket) {
  const double t = basket.wall / 2;
  const auto [x, y] = basket.half;
  const double h = basket.height / 2;
  const auto block = [&](const Vec3& p_KX, const Vec3& half) {
    return Block{{basket.X_WK.R, basket.X_WK * p_KX}, half};
  };
  return {block({0, 0, t}, {x, y, t}), block({x + t, 0, h}, {t, y + 2 * t, h}),
          block({-x - t, 0, h}, {t, y + 2 * t, h}), block({0, y + t, h}, {x, t, h}),
          block({0, -y - t, h}, {x, t, h})};
}

CubeWorld::CubeWorld(const CubeWorldSettings& settings)
    : settings_(settings), random_(settings.seed) {
  build_fixtures();
}

void CubeWorld::build_fixtures() {
  fixtures_.clear();
  fixture_shapes_.clear();
  for (const Basket& basket : settings_.baskets) {
    SINEW_ASSERT(basket.X_WK.R.z.z > 1 - 1e-9);
    for (const Block& block : blocks_of(basket)) {
      fixtures_.push_back(block);
      fixture_shapes_.push_back(slab_of(block, heights_of(block)));
    }
  }
}

std::size_t CubeWorld::add(const NewCube& cube) {
  SINEW_ASSERT(cube.edge > 0);
  CubeState state;
  state.edge = cube.edge;
  state.color = cube.color;
  cubes_.push_back(state);
  bodies_.emplace_back();
  for (Hand& hand : hands_) {
    hand.contacts.push_back(Contact::kNone);
    hand.of_held.push_back(Contact::kNone);
  }
  const std::size_t i = cubes_.size() - 1;
  put(i, cube.at, cube.yaw, cube.bottom);
  return i;
}

void CubeWorld::put(std::size_t cube, PlanPoint at, double turn, double low) {
  SINEW_ASSERT(cube < cubes_.size());
  cubes_[cube].where = CubePlace::kTable;
  cubes_[cube].on.reset();
  bodies_[cube] = {};
  for (Hand& hand : hands_) {
    hand.contacts[cube] = Contact::kNone;
    hand.of_held[cube] = Contact::kNone;
  }
  place(cube, at, turn, low);
  const std::size_t told = events_.size();
  fall(cube);
  calm();
  events_.resize(told);
}

std::optional<std::size_t> CubeWorld::add_somewhere(double edge, int color,
                                                    PlanPoint middle_of_area, PlanPoint half,
                                                    double gap) {
  constexpr int kTries = 200;
  for (int tries = 0; tries < kTries; ++tries) {
    const PlanPoint at = middle_of_area + PlanPoint{random_.uniform(-half.x, half.x),
                                                    random_.uniform(-half.y, half.y)};
    const double turn = random_.uniform(-kPi / 4, kPi / 4);
    const double room = edge / 2 + gap;
    const PlanShape square = rectangle(at, turn, {room, room});
    const auto is_hit = [&](const PlanShape& other) { return step_out(other, square).has_value(); };
    bool free = std::ranges::none_of(fixture_shapes_, is_hit);
    for (std::size_t i = 0; free && i < cubes_.size(); ++i) {
      free = cubes_[i].where == CubePlace::kGone || !is_hit(square_of(i));
    }
    if (free) return add({edge, color, at, turn, 0});
  }
  return std::nullopt;
}

void CubeWorld::take_away(std::size_t cube) {
  SINEW_ASSERT(cube < cubes_.size());
  cubes_[cube].where = CubePlace::kGone;
  cubes_[cube].on.reset();
  bodies_[cube].hold.reset();
  calm();
}

void CubeWorld::advance(Instant now, const HandTruth& truth, std::size_t which) {
  SINEW_ASSERT(which < kHandsMax);
  while (hands_.size() <= which) {
    hands_.emplace_back();
    hands_.back().contacts.resize(cubes_.size(), Contact::kNone);
    hands_.back().of_held.resize(cubes_.size(), Contact::kNone);
  }
  Hand& hand = hands_[which];
  SINEW_ASSERT(!hand.truth || now >= hand.time);
  const Instant begin = hand.truth ? hand.time : now;
  const HandTruth from = hand.truth.value_or(truth);
  const double seconds = to_seconds(now - begin);
  hand.velocity = {};
  if (seconds > 0) {
    hand.velocity = 1 / seconds * seen_from_above(truth.X_WT.p - from.X_WT.p);
  }
  const bool rests = hand.truth == truth && !moved_;
  const double steps = rests ? 0 : steps_between(from, truth);
  for (double i = 1; i <= steps; ++i) {
    hand.truth = between(from, truth, i / steps);
    now_ = std::max(now_, begin + from_seconds(seconds * i / steps));
    step(hand, which);
  }
  hand.truth = truth;
  hand.time = now;
  now_ = std::max(now_, now);
}

void CubeWorld::lift_hand(std::size_t which) {
  if (which >= hands_.size()) return;
  Hand& hand = hands_[which];
  hand.velocity = {};
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (is_held(i, which)) release(hand, i);
    hand.contacts[i] = Contact::kNone;
    hand.of_held[i] = Contact::kNone;
  }
  hand.truth.reset();
  hand.presses = false;
  calm();
}

void CubeWorld::step(Hand& hand, std::size_t which) {
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (is_held(i, which)) carry(hand, i);
  }
  const Vec3 tip = hand.truth->X_WT.p;
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (!is_free(i)) continue;
    if (norm(cubes_[i].X_WO.p - tip) > kNear + cubes_[i].edge) {
      hand.contacts[i] = Contact::kNone;
      continue;
    }
    touch(hand, which, i);
  }
  press(hand, which, softness(*hand.truth));
  if (moved_) calm();
}

void CubeWorld::note(CubeEvent::Kind kind, std::optional<std::size_t> cube, double amount) {
  events_.push_back({now_, kind, cube, amount});
}

bool CubeWorld::is_free(std::size_t cube) const {
  return cubes_[cube].where != CubePlace::kHeld && cubes_[cube].where != CubePlace::kGone;
}

bool CubeWorld::is_held(std::size_t cube, std::size_t which) const {
  return bodies_[cube].hold && bodies_[cube].hold->hand == which;
}

double CubeWorld::mass_of(std::size_t cube) const {
  const double edge = cubes_[cube].edge;
  return settings_.density * edge * edge * edge;
}

double CubeWorld::held_mass(std::size_t which) const {
  double sum = 0;
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (is_held(i, which)) sum += mass_of(i);
  }
  return sum;
}

Block CubeWorld::block_of(std::size_t cube) const {
  const double half = cubes_[cube].edge / 2;
  return {relabel<frame::World, frame::Box>(cubes_[cube].X_WO), {half, half, half}};
}

PlanShape CubeWorld::square_of(std::size_t cube) const {
  if (!is_free(cube)) {
    const Block block = block_of(cube);
    return slab_of(block, heights_of(block));
  }
  const double half = cubes_[cube].edge / 2;
  return rectangle(middle(cube), yaw(cube), {half, half});
}

double CubeWorld::bottom(std::size_t cube) const {
  return is_free(cube) ? cubes_[cube].X_WO.p.z - cubes_[cube].edge / 2
                       : heights_of(block_of(cube)).low;
}

double CubeWorld::yaw(std::size_t cube) const {
  const Vec3 x = cubes_[cube].X_WO.R.x;
  return std::atan2(x.y, x.x);
}

void CubeWorld::place(std::size_t cube, PlanPoint at, double turn, double low) {
  cubes_[cube].X_WO = {rotation_z(turn), {at.x, at.y, low + cubes_[cube].edge / 2}};
}

}  // namespace sinew::sim
