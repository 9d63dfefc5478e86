#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"
#include "sinew/sim/cube_world.h"

/// Jaws and cups: what they touch, take, carry and release.
namespace sinew::sim {
namespace {

constexpr double kTouch = 2e-4;             // m: a gap that is none
constexpr double kOpened = 5e-4;            // m: jaws that are wider than this no longer hold
constexpr double kFaceLeast = 4e-3;         // m of finger on the cube, along and across the finger
constexpr double kTurnMost = from_deg(30);  // friction lets corners jam beyond
constexpr double kLevelMost = 0.24;         // sine of 14 deg: soft finger tips
constexpr double kCupTilt = from_deg(5);
constexpr double kCupGap = 2e-3;  // m that a cup draws a cube up
constexpr double kThrown = 0.25;  // m/s
constexpr double kGravity = 9.81;
constexpr double kFriction = 0.4;  // of wood on a table, assumed
constexpr double kFlightMost = 1;  // m

/// The turn of a cube in jaws of this width: both corners touch. rad, 0 to pi/4
double turn_in(double room, double edge) {
  if (room <= edge) return 0;
  return std::asin(std::min(1.0, room / (edge * std::sqrt(2.0)))) - kPi / 4;
}

double overlap(double low, double high, double other_low, double other_high) {
  return std::min(high, other_high) - std::max(low, other_low);
}

/// The nearest orientation with one face up.
Rotation flat(const Rotation& R) {
  const bool x_up = std::abs(R.x.z) >= std::max(std::abs(R.y.z), std::abs(R.z.z));
  const Vec3 level = x_up ? R.y : R.x;
  const Vec3 other = std::abs(R.y.z) >= std::max(std::abs(R.x.z), std::abs(R.z.z)) ? R.x : level;
  return rotation_z(std::atan2(other.y, other.x));
}

}  // namespace

CubeWorld::Fit CubeWorld::fit_of(const Hand& hand, std::size_t cube) const {
  const auto& jaws = std::get<JawTruth>(hand.truth->grip);
  const CubeState& state = cubes_[cube];
  const auto X_TO = hand.truth->X_WT.inverse() * state.X_WO;
  const Vec3 y_W = hand.truth->X_WT.R.y;
  Fit fit;
  fit.p_TO = X_TO.p;
  fit.across = direction_of(seen_from_above(y_W));
  fit.turn = std::remainder(yaw(cube) - std::atan2(fit.across.y, fit.across.x), kPi / 2);
  fit.extent = state.edge * (std::cos(fit.turn) + std::sin(std::abs(fit.turn)));
  const double half = state.edge / 2;
  fit.face = overlap(fit.p_TO.x - half, fit.p_TO.x + half, -jaws.finger_half.x, jaws.finger_half.x);
  const double high =
      half * std::max({std::abs(X_TO.R.x.z), std::abs(X_TO.R.y.z), std::abs(X_TO.R.z.z)});
  fit.deep = overlap(fit.p_TO.z - high, fit.p_TO.z + high, -2 * jaws.finger_half.z, 0);
  fit.is_level = std::abs(y_W.z) < kLevelMost;
  return fit;
}

void CubeWorld::count_neighbours(const Hand& hand, std::size_t cube, Fit& fit) const {
  const auto X_TW = hand.truth->X_WT.inverse();
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (i == cube || hand.contacts[i] != Contact::kBetween) continue;
    if (cubes_[i].where == CubePlace::kGone) continue;
    const Vec3 p = X_TW * cubes_[i].X_WO.p - fit.p_TO;
    const double reach = (cubes_[i].edge + cubes_[cube].edge) / 2 - kFaceLeast;
    if (std::abs(p.x) > reach || std::abs(p.z) > reach) continue;
    (p.y < 0 ? fit.before : fit.behind) += cubes_[i].edge;
  }
}

void CubeWorld::touch(Hand& hand, std::size_t which, std::size_t cube) {
  Contact& contact = hand.contacts[cube];
  const auto* jaws = std::get_if<JawTruth>(&hand.truth->grip);
  Fit fit;
  if (jaws != nullptr) {
    fit = fit_of(hand, cube);
    const bool inside = fit.face > 0 && fit.deep > 0;
    if (contact == Contact::kBetween && !inside) contact = Contact::kNone;
    const bool fits = std::abs(fit.p_TO.y) + fit.extent / 2 <= jaws->width / 2 + kTouch;
    if (contact == Contact::kNone && inside && fits) contact = Contact::kBetween;
    if (contact == Contact::kBetween) {
      count_neighbours(hand, cube, fit);
      squeeze(hand, which, cube, fit);
      return;
    }
  }
  const double soft = jaws != nullptr ? 0 : softness(*hand.truth);
  int resting = 0;
  int pushing = 0;
  for (const Block& block : blocks_of(*hand.truth)) {
    const Touch met = drive(block, cube, contact, soft);
    if (met == Touch::kRests) ++resting;
    if (met == Touch::kPushes) ++pushing;
  }
  if (resting == 0) contact = Contact::kNone;
  if (jaws == nullptr) {
    suck(hand, which, cube);
  } else if (pushing == 2) {
    slip_out(hand, cube, fit);
  }
}

void CubeWorld::squeeze(Hand& hand, std::size_t which, std::size_t cube, const Fit& fit) {
  const double half = std::get<JawTruth>(hand.truth->grip).width / 2;
  const double room = 2 * half - fit.before - fit.behind;
  const double edge = cubes_[cube].edge;
  if (room >= fit.extent + kTouch) {
    const double y = std::clamp(fit.p_TO.y, -half + fit.before + fit.extent / 2,
                                half - fit.behind - fit.extent / 2);
    if (y != fit.p_TO.y) displace(cube, (y - fit.p_TO.y) * fit.across);
    return;
  }
  if (fit.face < kFaceLeast || std::abs(fit.turn) > kTurnMost || !fit.is_level) {
    slip_out(hand, cube, fit);
    return;
  }
  const double turn = std::copysign(std::min(std::abs(fit.turn), turn_in(room, edge)), fit.turn);
  const PlanPoint at = middle(cube);
  place(cube, at, yaw(cube) + turn - fit.turn, bottom(cube));
  displace(cube, ((fit.before - fit.behind) / 2 - fit.p_TO.y) * fit.across);
  if (room <= edge + kTouch && fit.deep >= kFaceLeast) hold(hand, which, cube);
}

void CubeWorld::slip_out(Hand& hand, std::size_t cube, const Fit& fit) {
  const HeightRange heights = heights_of(block_of(cube));
  std::vector<PlanPoint> corners;
  for (const Block& block : blocks_of(*hand.truth)) {
    const PlanShape shape = slab_of(block, heights);
    corners.insert(corners.end(), shape.begin(), shape.end());
  }
  const bool forward = std::abs(fit.p_TO.x) > kOpened ? fit.p_TO.x > 0 : random_.uniform(-1, 1) > 0;
  const PlanPoint x = direction_of(seen_from_above(hand.truth->X_WT.R.x));
  const PlanPoint toward = forward ? x : -1 * x;
  const double way = slide_out(hull_of(std::move(corners)), square_of(cube), toward) + kOpened;
  hand.contacts[cube] = Contact::kNone;
  note(CubeEvent::Kind::kSlipped, cube, way);
  displace(cube, way * toward);
}

void CubeWorld::suck(Hand& hand, std::size_t which, std::size_t cube) {
  const auto& cup = std::get<CupTruth>(hand.truth->grip);
  if (!cup.pump || hand.truth->X_WT.R.z.z > -std::cos(kCupTilt)) return;
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (is_held(i, which)) return;
  }
  Vec3& p_WO = cubes_[cube].X_WO.p;
  const double gap = hand.truth->X_WT.p.z - (p_WO.z + cubes_[cube].edge / 2);
  if (gap > kCupGap || gap < -softness(*hand.truth)) return;
  if (!contains(square_of(cube), seen_from_above(hand.truth->X_WT.p), cup.radius)) return;
  if (gap > 0) p_WO.z += gap;
  hold(hand, which, cube);
}

void CubeWorld::hold(const Hand& hand, std::size_t which, std::size_t cube) {
  bodies_[cube].hold = Hold{which, hand.truth->X_WT.inverse() * cubes_[cube].X_WO};
  cubes_[cube].where = CubePlace::kHeld;
  cubes_[cube].on.reset();
  moved_ = true;
  note(CubeEvent::Kind::kGrasped, cube);
}

void CubeWorld::carry(Hand& hand, std::size_t cube) {
  cubes_[cube].X_WO = hand.truth->X_WT * bodies_[cube].hold->X_TO;
  bool holds = false;
  if (const auto* jaws = std::get_if<JawTruth>(&hand.truth->grip)) {
    Fit fit = fit_of(hand, cube);
    count_neighbours(hand, cube, fit);
    holds = jaws->width <= cubes_[cube].edge + fit.before + fit.behind + kOpened;
  } else {
    holds = std::get<CupTruth>(hand.truth->grip).pump;
  }
  if (!holds) {
    release(hand, cube);
    return;
  }
  const Block block = block_of(cube);
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (!is_free(i) || hand.contacts[i] == Contact::kBetween) continue;
    if (cubes_[i].on == cube) moved_ = true;
    const bool near = norm(cubes_[i].X_WO.p - block.X_WX.p) < cubes_[i].edge + cubes_[cube].edge;
    if (!near || drive(block, i, hand.of_held[i], softness(*hand.truth)) != Touch::kRests) {
      hand.of_held[i] = Contact::kNone;
    }
  }
}

void CubeWorld::release(const Hand& hand, std::size_t cube) {
  const double low = bottom(cube);
  CubeState& state = cubes_[cube];
  bodies_[cube].hold.reset();
  state.where = CubePlace::kTable;
  state.X_WO = {flat(state.X_WO.R), {state.X_WO.p.x, state.X_WO.p.y, low + state.edge / 2}};
  note(CubeEvent::Kind::kReleased, cube);
  const double speed = length(hand.velocity);
  if (speed > kThrown) {
    note(CubeEvent::Kind::kThrown, cube, speed);
    const double flight = std::sqrt(2 * std::max(0.0, low) / kGravity);
    const double slide = speed / (2 * kFriction * kGravity);
    const double way = std::min(kFlightMost, speed * (flight + slide));
    move(cube, way / speed * hand.velocity);
  }
  moved_ = true;
  fall(cube);
}

std::optional<double> CubeWorld::blocked_width(std::size_t which) const {
  if (which >= hands_.size() || !hands_[which].truth) return std::nullopt;
  const Hand& hand = hands_[which];
  if (!std::holds_alternative<JawTruth>(hand.truth->grip)) return std::nullopt;
  std::optional<double> widest;
  for (std::size_t i = 0; i < cubes_.size(); ++i) {
    if (hand.contacts[i] != Contact::kBetween || cubes_[i].where == CubePlace::kGone) continue;
    Fit fit = fit_of(hand, i);
    // What is held stays between the jaws however the hand is turned.
    const bool stops = is_held(i, which) ||
                       (fit.face >= kFaceLeast && fit.is_level && std::abs(fit.turn) <= kTurnMost);
    if (!stops) continue;
    count_neighbours(hand, i, fit);
    widest = std::max(widest.value_or(0), cubes_[i].edge + fit.before + fit.behind);
  }
  return widest;
}

}  // namespace sinew::sim
