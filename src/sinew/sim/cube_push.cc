#include <algorithm>
#include <cmath>

#include "sinew/sim/cube_world.h"

/// Cubes that are pushed, and what is driven into them.
namespace sinew::sim {
namespace {

constexpr double kTouching = 1e-3;  // m: things that overlap by less in height pass each other
constexpr double kSame = 1e-7;      // m, of rounding
constexpr double kGives = 5e-3;     // m: driven deeper into a cube, a hand pushes it aside
constexpr double kPushTold = 5e-4;  // m
constexpr double kCrashTold = 1e-3;
constexpr double kHeldSinks = 2e-3;
constexpr Duration kStill = std::chrono::milliseconds(500);

bool are_far(const Block& a, const Block& b) {
  return norm(a.X_WX.p - b.X_WX.p) > norm(a.half) + norm(b.half);
}

bool share_heights(HeightRange a, HeightRange b, double least) {
  return std::min(a.high, b.high) - std::max(a.low, b.low) > least;
}

}  // namespace

void CubeWorld::move(std::size_t cube, PlanPoint step) {
  Vec3& p = cubes_[cube].X_WO.p;
  p = p + Vec3{step.x, step.y, 0};
  moved_ = true;
}

void CubeWorld::keep_out_of_walls(std::size_t cube) {
  const HeightRange heights = heights_of(block_of(cube));
  for (std::size_t k = 0; k < fixtures_.size(); ++k) {
    if (!share_heights(heights_of(fixtures_[k]), heights, kTouching)) continue;
    if (const auto out = step_out(fixture_shapes_[k], square_of(cube))) move(cube, *out);
  }
}

void CubeWorld::push(std::size_t cube, PlanPoint step, int depth) {
  Body& body = bodies_[cube];
  if (now_ - body.last_push > kStill) body.push = 0;
  const bool was_told = body.push > kPushTold;
  body.push += length(step);
  body.last_push = now_;
  if (!was_told && body.push > kPushTold) note(CubeEvent::Kind::kPushed, cube, body.push);
  displace(cube, step, depth);
}

void CubeWorld::displace(std::size_t cube, PlanPoint step, int depth) {
  constexpr int kChain = 8;
  move(cube, step);
  if (depth >= kChain) return;
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (i == cube || cubes_[i].where == CubePlace::kGone) continue;
    if (!share_heights(heights_of(block_of(cube)), heights_of(block_of(i)), kTouching)) continue;
    const auto out = step_out(square_of(cube), square_of(i));
    if (!out || length(*out) < kSame) continue;
    if (is_free(i)) push(i, *out, depth + 1);
    // It may be stopped by what is behind it.
    if (const auto back = step_out(square_of(i), square_of(cube))) move(cube, *back);
  }
  keep_out_of_walls(cube);
}

/// Whether they were apart already.
bool CubeWorld::part_cubes() {
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    bool parted = true;
    for (std::size_t i = 0; i < cubes_.size(); ++i) {
      for (std::size_t k = i + 1; k < cubes_.size(); ++k) {
        if (!is_free(i) || !is_free(k)) continue;
        if (norm(cubes_[i].X_WO.p - cubes_[k].X_WO.p) > cubes_[i].edge + cubes_[k].edge) continue;
        if (!share_heights(heights_of(block_of(i)), heights_of(block_of(k)), kTouching)) continue;
        const auto out = step_out(square_of(i), square_of(k));
        if (!out || length(*out) < kSame) continue;
        parted = false;
        move(i, -0.5 * *out);
        move(k, 0.5 * *out);
      }
      if (is_free(i)) keep_out_of_walls(i);
    }
    if (parted) return round == 0;
  }
  return false;
}

CubeWorld::Touch CubeWorld::drive(const Block& block, std::size_t cube, Contact& contact,
                                  double soft) {
  if (are_far(block, block_of(cube))) return Touch::kNone;
  const HeightRange mine = heights_of(block_of(cube));
  const HeightRange its = heights_of(block);
  if (its.low >= mine.high || its.high <= mine.low) return Touch::kNone;
  const auto out = step_out(slab_of(block, mine), square_of(cube));
  if (!out || length(*out) < kSame) return Touch::kNone;
  const double aside = length(*out);
  const double from_above = mine.high - std::max(its.low, mine.low);
  const double from_below = its.high - mine.low;
  if (its.low < mine.low && from_below < std::min(aside, kGives)) {
    moved_ = true;  // it lifts the cube
    return Touch::kRests;
  }
  if (from_above >= std::min(aside, soft + kGives) || its.high < mine.high) {
    push(cube, *out);
    return Touch::kPushes;
  }
  if (from_above > soft + kCrashTold && contact != Contact::kAbove) {
    contact = Contact::kAbove;
    note(CubeEvent::Kind::kCrash, cube, from_above);
  }
  return Touch::kRests;
}

double CubeWorld::depth_in_fixtures(const Block& block) const {
  const HeightRange its = heights_of(block);
  double deepest = -its.low;  // in the table
  for (std::size_t k = 0; k < fixtures_.size(); ++k) {
    if (are_far(block, fixtures_[k])) continue;
    const HeightRange wall = heights_of(fixtures_[k]);
    const double in = std::min(its.high, wall.high) - its.low;
    if (in <= deepest) continue;
    const auto out = step_out(fixture_shapes_[k], slab_of(block, wall));
    if (out) deepest = std::max(deepest, std::min(in, length(*out)));
  }
  return deepest;
}

void CubeWorld::press(Hand& hand, std::size_t which, double soft) {
  double deepest = 0;
  std::optional<std::size_t> cube;
  for (const Block& block : blocks_of(*hand.truth)) {
    deepest = std::max(deepest, depth_in_fixtures(block) - soft);
  }
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (!is_held(i, which)) continue;
    const double depth = depth_in_fixtures(block_of(i)) - std::max(soft, kHeldSinks);
    if (depth <= deepest) continue;
    deepest = depth;
    cube = i;
  }
  if (deepest > 0 && !hand.presses) note(CubeEvent::Kind::kCrash, cube, deepest + soft);
  hand.presses = deepest > 0;
}

}  // namespace sinew::sim
