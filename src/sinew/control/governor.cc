#include "sinew/control/governor.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"

namespace sinew::control {
namespace {

constexpr double kDay = 86400;  // s
/// rad or m; what the coarsest of our wires rounds a place to is commanded as it was planned.
constexpr double kPlaceTolerance = 1e-9;

Error joint_error(ErrorCode code, std::size_t joint, double measured, double limit) {
  return {code, static_cast<std::int8_t>(joint), measured, limit};
}

/// Written so that NaN is beyond every limit.
bool within(double value, double limit) {
  return std::abs(value) <= limit * (1 + Governor::kTolerance) + kPlaceTolerance;
}

std::optional<Error> beyond(ErrorCode code, std::size_t joint, double value, double limit) {
  if (within(value, limit)) return std::nullopt;
  return joint_error(code, joint, std::abs(value) / limit, 1);
}

}  // namespace

Governor::Governor(const RobotModel& model, std::span<const motion::AxisLimits> limits)
    : model_(model),
      collision_(model),
      size_(model.joints.size()),
      streams_(model.device.capability.motion == MotionKind::kStream) {
  SINEW_ASSERT(limits.size() == size_);
  std::ranges::copy(limits, limits_.begin());
}

void Governor::rest(std::span<const double> q) {
  SINEW_ASSERT(q.size() == size_);
  std::ranges::copy(q, q_.begin());
  qd_.fill(0);
  acceleration_.fill(0);
  seconds_ = 0;
  known_ = true;
  overlaps_.clear();
  look_around();
}

void Governor::look_around() {
  bool any = false;
  for (std::size_t pose = 0; pose < collision_.poses(); ++pose) {
    poses_[pose] = nearest(pose, q());
    any = any || !poses_[pose].surely;
  }
  nearest_ = {};
  for (std::size_t pose = 0; pose < collision_.poses(); ++pose) {
    planning::Clearance& here = poses_[pose];
    // Where none is possible, the file's shapes are wrong: then each counts.
    here.surely = here.surely && any;
    if (!here.surely && here.distance < nearest_.distance) nearest_ = here;
  }
}

void Governor::fit(const ToolState& tool) {
  tool_ = tool;
  collision_.fit(tool);
  if (known_) look_around();
}

Expected<void> Governor::pass_jaws(double to) {
  if (!known_) return {};
  if (const auto error = collision_.jaws_contact(q(), tool_, to)) return std::unexpected(*error);
  return {};
}

void Governor::leave(std::span<const LinkPair> overlaps) {
  if (!known_) return;
  if (!overlaps_.empty()) rest(q());
  if (nearest_.distance >= collision_.margin()) return;
  if (!holds(overlaps, planning::link_of(model_, nearest_.first),
             planning::link_of(model_, nearest_.second))) {
    return;
  }
  for (const LinkPair& pair : overlaps) {
    if (!overlaps_.full()) overlaps_.push_back(pair);
  }
  look_around();
}

std::optional<Error> Governor::look_at_numbers(const JointMove& move) const {
  const double seconds = to_seconds(move.duration);
  if (!(seconds > 0) || seconds > kDay) return Error{ErrorCode::kSegmentTime, -1, seconds, kDay};
  if (move.q.size() != size_)
    return Error{ErrorCode::kMoveInput, -1, static_cast<double>(move.q.size())};
  if (!move.qd.empty() && move.qd.size() != size_) {
    return Error{ErrorCode::kMoveInput, -1, static_cast<double>(move.qd.size())};
  }
  for (std::size_t i = 0; i < size_; ++i) {
    if (!std::isfinite(move.q[i])) return joint_error(ErrorCode::kMoveInput, i, move.q[i], 0);
    if (!move.qd.empty() && !std::isfinite(move.qd[i])) {
      return joint_error(ErrorCode::kMoveInput, i, move.qd[i], 0);
    }
  }
  return std::nullopt;
}

/// Inside its limits, or, where it began outside, no farther out than it is.
std::optional<Error> Governor::look_at_place(const JointMove& move) const {
  for (std::size_t i = 0; i < size_; ++i) {
    const Joint& joint = model_.joints[i];
    const double lower = known_ ? std::min(joint.lower, q_[i]) : joint.lower;
    const double upper = known_ ? std::max(joint.upper, q_[i]) : joint.upper;
    if (move.q[i] < lower - kPlaceTolerance) {
      return joint_error(ErrorCode::kJointLimit, i, move.q[i], joint.lower);
    }
    if (move.q[i] > upper + kPlaceTolerance) {
      return joint_error(ErrorCode::kJointLimit, i, move.q[i], joint.upper);
    }
  }
  return std::nullopt;
}

std::optional<Error> Governor::look_at_piece(const JointMove& move, std::size_t joint,
                                             double seconds) const {
  using enum ErrorCode;
  const motion::AxisLimits& limit = limits_[joint];
  const double way = move.q[joint] - q_[joint];
  const double qd = move.qd.empty() ? 0 : move.qd[joint];
  const double change = qd - qd_[joint];
  const double fastest = limit.velocity * (overlaps_.empty() ? 1 : kLeavingShare);
  if (const auto bad = beyond(kVelocityLimit, joint, qd, fastest)) return bad;
  if (const auto bad = beyond(kVelocityLimit, joint, way, fastest * seconds)) return bad;
  const double speed_up = limit.acceleration * seconds;
  if (const auto bad = beyond(kAccelerationLimit, joint, change, speed_up)) return bad;
  const double jump = change - acceleration_[joint] * seconds;
  const double middles = (seconds + seconds_) / 2;
  if (const auto bad = beyond(kJerkLimit, joint, jump, limit.jerk * middles * seconds)) return bad;
  const double apart = way - (qd_[joint] + qd) * seconds / 2;
  return beyond(kJump, joint, apart, limit.jerk * seconds * seconds * seconds / 12);
}

/// Nearer than the margin only where it began so, and then no nearer than it began.
std::optional<Error> Governor::look_at_contacts(const JointMove& move) const {
  const std::span<const double> q(move.q.data(), size_);
  const double least = collision_.margin() - planning::CollisionModel::kResolution;
  for (std::size_t pose = 0; pose < collision_.poses(); ++pose) {
    if (known_ && poses_[pose].surely) continue;
    const planning::Clearance near = nearest(pose, q);
    // What a planner takes for as near as it was, a motion may be.
    const double begun =
        poses_[pose].distance - planning::CollisionModel::kResolution - kPlaceTolerance;
    if (near.distance >= (known_ ? std::min(least, begun) : least)) continue;
    return planning::contact_error(model_, near);
  }
  return std::nullopt;
}

Expected<void> Governor::pass(const JointMove& move) {
  if (const auto bad = look_at_numbers(move)) return std::unexpected(*bad);
  if (!known_) return std::unexpected(Error{ErrorCode::kPositionUnknown});
  if (const auto bad = look_at_place(move)) return std::unexpected(*bad);
  for (std::size_t i = 0; i < size_; ++i) {
    const bool moves = is_left_out(model_, i) && !(std::abs(move.q[i] - q_[i]) <= kPlaceTolerance);
    if (moves) return std::unexpected(joint_error(ErrorCode::kPositionUnknown, i, 0, 0));
  }
  const double seconds = to_seconds(move.duration);
  for (std::size_t i = 0; streams_ && i < size_; ++i) {
    if (const auto bad = look_at_piece(move, i, seconds)) return std::unexpected(*bad);
  }
  if (const auto near = look_at_contacts(move)) return std::unexpected(*near);
  take(move, seconds);
  return {};
}

Expected<void> Governor::pass_blind(const JointMove& move) {
  if (const auto bad = look_at_numbers(move)) return std::unexpected(*bad);
  if (const auto bad = look_at_place(move)) return std::unexpected(*bad);
  if (const auto near = look_at_contacts(move)) return std::unexpected(*near);
  return {};
}

Expected<void> Governor::pass_nudge(std::size_t joint, double way,
                                    std::span<const JointPosition> positions) const {
  if (joint >= size_) {
    return std::unexpected(Error{ErrorCode::kMoveInput, -1, static_cast<double>(joint)});
  }
  const double most = nudge_max(model_, joint);
  if (!(most > 0)) return std::unexpected(Error{ErrorCode::kTaskNotSupported});
  if (way == 0 || !within(way, most)) {
    return std::unexpected(joint_error(ErrorCode::kNudgeRange, joint, way, most));
  }
  if (positions[joint].quality == PositionQuality::kLost) return {};
  const Joint& limits = model_.joints[joint];
  const double q = positions[joint].q + way;
  if (way < 0 && q < limits.lower - kPlaceTolerance) {
    return std::unexpected(joint_error(ErrorCode::kJointLimit, joint, q, limits.lower));
  }
  if (way > 0 && q > limits.upper + kPlaceTolerance) {
    return std::unexpected(joint_error(ErrorCode::kJointLimit, joint, q, limits.upper));
  }
  if (!known_) return {};
  JointMove move;
  move.q = JointVector(this->q());
  move.q[joint] += way;
  if (const auto near = look_at_contacts(move)) return std::unexpected(*near);
  return {};
}

void Governor::take(const JointMove& move, double seconds) {
  for (std::size_t i = 0; i < size_; ++i) {
    const double qd = move.qd.empty() || !streams_ ? 0 : move.qd[i];
    acceleration_[i] = streams_ ? (qd - qd_[i]) / seconds : 0;
    qd_[i] = qd;
    q_[i] = move.q[i];
  }
  seconds_ = streams_ ? seconds : 0;
}

}  // namespace sinew::control
