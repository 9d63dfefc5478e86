#include "sinew/devices/bigrobotarm/bigrobotarm_driver_positions.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"

namespace sinew {

using namespace bigrobotarm;

namespace {

constexpr double kFullStepsPerRev = 200;
/// Full steps by which a rotor may snap when its power stage starts anew, or its motor has slipped.
constexpr double kSnap = 2;
constexpr double kFullStepsPerPole = 4;
constexpr double kRounding = 1e-9;  // rad

}  // namespace

BigRobotArmPositions::BigRobotArmPositions(const BigRobotArmJoints& joints) : joints_(joints) {
  for (const BigRobotArmJoint& joint : joints_) {
    SINEW_ASSERT(joint.steps_per_rad != 0 && joint.steps_per_motor_rev > 0);
  }
}

double BigRobotArmPositions::angle(std::size_t joint, const Words& steps) const {
  return offset_[joint] + steps[joint] / joints_[joint].steps_per_rad;
}

double BigRobotArmPositions::full_step(std::size_t joint) const {
  const BigRobotArmJoint& own = joints_[joint];
  return own.steps_per_motor_rev / kFullStepsPerRev / std::abs(own.steps_per_rad);
}

void BigRobotArmPositions::declare(std::span<const JointPosition> positions) {
  SINEW_ASSERT(positions.size() == kJoints);
  if (!heard_) {
    pending_.emplace();
    std::copy(positions.begin(), positions.end(), pending_->begin());
    take_declaration(positions);
    declared_ = false;
    return;
  }
  if (going_ || doubted_) return;
  take_declaration(positions);
}

void BigRobotArmPositions::take_declaration(std::span<const JointPosition> positions) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const JointPosition& one = positions[i];
    Slack& slack = slack_[i];
    const double margin = full_step(i) * (between_rests_[i] ? 1 + kSnap : 1);
    // Who has looked knows no count; a journal does.
    const bool place = one.quality >= PositionQuality::kCommanded;
    if (one.count_zero || place || !heard_) ties_[i] = one.count_zero;
    slack = {.lost = one.quality == PositionQuality::kLost || !std::isfinite(one.q) ||
                     !std::isfinite(one.lower) || !std::isfinite(one.upper),
             .uncertain = one.quality == PositionQuality::kUncertain,
             .lower = -margin,
             .upper = margin};
    if (slack.lost) continue;
    offset_[i] += one.q - angle(i, steps_);
    slack.lower = std::min(slack.lower, one.lower - one.q);
    slack.upper = std::max(slack.upper, one.upper - one.q);
  }
  declared_ = true;
}

void BigRobotArmPositions::go(const Words& target) {
  target_ = target;
  going_ = true;
}

void BigRobotArmPositions::arrive() {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (turned(i, steps_, target_)) between_rests_[i] = false;
  }
  steps_ = target_;
  going_ = false;
}

void BigRobotArmPositions::doubt() {
  doubted_ = heard_;
}

void BigRobotArmPositions::judge(const Status& status, BigRobotArmStart start) {
  const bool boot = start == BigRobotArmStart::kAnew;
  const bool kept = start == BigRobotArmStart::kKept;
  const Words from = steps_;
  const bool first = !heard_;
  const bool as_left = status.positions == from;
  const bool as_asked = going_ && status.positions == target_ && !reopened_;
  steps_ = status.positions;
  heard_ = true;
  if (status.sync) {
    lose();
  } else if (first) {
    // Nothing was said: all lost, and the count is evidence.
    const auto said =
        std::exchange(pending_, std::nullopt).value_or(std::array<JointPosition, kJoints>{});
    take_declaration(said);
    if (!boot) settle_by_count(said);
    if (boot || kept) widen_by_snap();
  } else if ((boot || kept) && going_) {
    lose();
  } else if (boot) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      offset_[i] += (from[i] - steps_[i]) / joints_[i].steps_per_rad;
    }
    widen_by_snap();
  } else if (as_left || as_asked) {
    if (kept) widen_by_snap();
  } else if (reopened_) {
    // Another host had it: its count is evidence, and where the arm stands is not known.
    std::array<std::optional<double>, kJoints> tied{};
    for (std::size_t i = 0; i < kJoints; ++i) tied[i] = is_tied(i) ? offset_[i] : ties_[i];
    lose();
    ties_ = tied;
  } else if (status.positions == Words{}) {
    reach_from_zero(from);
  }
  going_ = doubted_ = reopened_ = false;
  if (boot || kept) between_rests_.fill(true);
}

/// So far that a rotor anywhere between two rests has found one.
bool BigRobotArmPositions::turned(std::size_t joint, const Words& from, const Words& to) const {
  const double steps = std::abs(1.0 * to[joint] - from[joint]);
  const BigRobotArmJoint& own = joints_[joint];
  return steps >= own.steps_per_motor_rev / kFullStepsPerRev * kFullStepsPerPole;
}

void BigRobotArmPositions::lose() {
  between_rests_.fill(true);
  slack_ = {};
  ties_ = {};
  declared_ = false;
}

/// The board kept its power: what ties its count to the joints still holds, and a place that was
/// known as an interval is where it counts. What was said and what it counts have to agree; else
/// somebody else had it, and the count is evidence only.
void BigRobotArmPositions::settle_by_count(std::span<const JointPosition> said) {
  const bool all_zero = steps_ == Words{};
  const auto tied = ties_;
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (!tied[i] && slack_[i].lost && !all_zero) ties_[i] = 0;
    if (!tied[i] || slack_[i].lost) continue;
    const double here = *tied[i] + steps_[i] / joints_[i].steps_per_rad;
    const double near = (1 + kSnap) * full_step(i);
    const bool inside = said[i].lower - kRounding <= here && here <= said[i].upper + kRounding;
    // A damaged request may have reset its counters on the way: they count a place of the motion's
    // then, and not one at its ends.
    const bool at_end = std::min({std::abs(here - said[i].lower), std::abs(here - said[i].upper),
                                  std::abs(here - said[i].q)}) <= near;
    if (inside && (at_end || !all_zero)) continue;
    contradiction_ =
        Error{ErrorCode::kCountedElsewhere, static_cast<std::int8_t>(i), said[i].q, here};
    lose();
    ties_ = tied;
    return;
  }
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (!tied[i] || slack_[i].lost) continue;
    offset_[i] = *tied[i];
    const double here = angle(i, steps_);
    const double left = std::min(here - said[i].lower, said[i].upper - here);
    const double margin = std::clamp(left, full_step(i), (1 + kSnap) * full_step(i));
    slack_[i] = {.lost = false, .uncertain = false, .lower = -margin, .upper = margin};
  }
}

/// Its place is the count's, whatever moves it meanwhile.
bool BigRobotArmPositions::is_tied(std::size_t joint) const {
  return heard_ && declared_ && !slack_[joint].lost && !slack_[joint].uncertain;
}

std::optional<JointInterval> BigRobotArmPositions::counted(std::size_t joint) const {
  const std::optional<double> zero = is_tied(joint) ? offset_[joint] : ties_[joint];
  if (!heard_ || going_ || doubted_ || !zero) return std::nullopt;
  const double here = *zero + steps_[joint] / joints_[joint].steps_per_rad;
  const double margin = (1 + kSnap) * full_step(joint);
  return JointInterval{here - margin, here + margin};
}

void BigRobotArmPositions::zero() {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double way = steps_[i] / joints_[i].steps_per_rad;
    offset_[i] += way;
    if (ties_[i]) *ties_[i] += way;
  }
  steps_ = {};
}

void BigRobotArmPositions::widen_by_snap() {
  for (std::size_t i = 0; i < kJoints; ++i) {
    slack_[i].uncertain = true;
    slack_[i].lower -= kSnap * full_step(i);
    slack_[i].upper += kSnap * full_step(i);
  }
  ties_ = {};
  declared_ = false;
}

/// The arm stands where it stood, or at the device's zero; the device counts 0 in both cases.
void BigRobotArmPositions::reach_from_zero(const Words& from) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double way = from[i] / joints_[i].steps_per_rad;
    slack_[i].uncertain = true;
    slack_[i].lower += std::min(0.0, way);
    slack_[i].upper += std::max(0.0, way);
  }
  ties_ = {};
  declared_ = false;
}

std::optional<std::size_t> BigRobotArmPositions::unknown() const {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (!declared_ || slack_[i].lost) return i;
  }
  return std::nullopt;
}

void BigRobotArmPositions::show(double progress, std::span<JointPosition> positions) const {
  SINEW_ASSERT(positions.size() == kJoints);
  for (std::size_t i = 0; i < kJoints; ++i) {
    JointPosition& shown = positions[i];
    const Slack& slack = slack_[i];
    // In doubt a damaged request may just have reset the counters.
    const std::optional<double> zero = is_tied(i) ? offset_[i] : ties_[i];
    const std::optional<double> count_zero = doubted_ ? std::nullopt : zero;
    if (slack.lost) {
      shown = {.count_zero = count_zero};
      continue;
    }
    const double here = angle(i, steps_);
    shown = {PositionQuality::kCommanded, here, here, here, count_zero};
    const auto reach = [&](double q) {
      shown.lower = std::min(shown.lower, q);
      shown.upper = std::max(shown.upper, q);
    };
    if (going_) {
      const double there = angle(i, target_);
      reach(there);
      shown.q = here + std::clamp(progress, 0.0, 1.0) * (there - here);
    }
    // One flipped bit makes a gripper's request a way home; a cut goto leads there too.
    if (doubted_) reach(offset_[i]);
    if (going_ || doubted_ || slack.uncertain) shown.quality = PositionQuality::kUncertain;
    shown.lower += slack.lower;
    shown.upper += slack.upper;
  }
}

}  // namespace sinew
