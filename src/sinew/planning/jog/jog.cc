#include "sinew/planning/jog/jog.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/planning/paths/motion_limits.h"

namespace sinew::planning {
namespace {

using motion::AxisState;

/// Share of a joint's acceleration that the curves of its way may take at the tool's full speed.
constexpr double kCurveShare = 0.35;
/// Share of acceleration and jerk for the tool to gather speed, of what its curves leave.
constexpr double kRampShare = 0.8;
constexpr double kRampJerkShare = 0.3;

/// Places at which the way to rest is looked at.
constexpr std::size_t kLooks = 4;

double length_of(const TaskArray& task) {
  double squares = 0;
  for (const double number : task) squares += number * number;
  return std::sqrt(squares);
}

double along(const TaskArray& task, const TaskArray& way) {
  double sum = 0;
  double squares = 0;
  for (std::size_t k = 0; k < kTasksMax; ++k) {
    sum += task[k] * way[k];
    squares += way[k] * way[k];
  }
  return squares > 0 ? sum / squares : 0;
}

FixedVector<JogJoint, kMaxJoints> joints_of(const RobotModel& model) {
  FixedVector<JogJoint, kMaxJoints> joints;
  const auto limits = motion_limits(model);
  for (std::size_t j = 0; j < limits.size(); ++j) {
    joints.push_back(JogJoint(limits[j], {model.joints[j].lower, model.joints[j].upper}));
  }
  return joints;
}

}  // namespace

Jog::Jog(const RobotModel& model, const Options& options)
    : space_(model),
      joints_(joints_of(model)),
      shared_velocity_(shared_velocity(model)),
      resolver_(space_, {joints_.data(), joints_.size()}) {
  if (options.avoid_contact && !model.collision.shapes.empty()) {
    collision_ = std::make_unique<CollisionModel>(model);
  }
}

std::optional<Error> Jog::start(std::span<const AxisState> states, Instant now,
                                const PoseBT* X_near) {
  if (states.size() != joints()) return Error{ErrorCode::kMotionInput};
  JointArray q{};
  for (std::size_t j = 0; j < joints(); ++j) {
    const AxisState& state = states[j];
    const motion::AxisLimits& limits = joints_[j].limits();
    constexpr double kRounding = 1 + 1e-9;
    if (!std::isfinite(state.q) || !(std::abs(state.q) <= 1e3) ||
        !(std::abs(state.qd) <= limits.velocity * kRounding) ||
        !(std::abs(state.qdd) <= limits.acceleration * kRounding)) {
      return Error{ErrorCode::kMotionInput, static_cast<std::int8_t>(j), state.qd, limits.velocity};
    }
    q[j] = state.q;
  }
  const auto X_BT = space_.place(q, X_near != nullptr ? *X_near : space_.tool().home());
  if (!X_BT) return X_BT.error();
  X_BT_ = *X_BT;
  states_ = {};
  std::copy(states.begin(), states.end(), states_.begin());
  set_states(states_);
  can_stop_ = false;
  JointArray rest{};
  for (std::size_t j = 0; j < joints(); ++j) rest[j] = joints_[j].stop(states_[j]).target();
  violation_ = space_.violation(rest, X_BT_);
  overlaps_ = true;
  look_at_overlap();
  last_ = now;
  drive_ = Drive::kBrake;
  idle_ = JogReason::kNoCommand;
  refused_ = JogReason::kNone;
  ramp_valid_ = false;
  resolver_.forget();
  step_ = 0;
  speed_share_ = 1;
  slowest_ = -1;
  return std::nullopt;
}

std::optional<Error> Jog::refusal(const JogCommand& command, Instant now) const {
  if (!space_.has(command.frame)) return Error{ErrorCode::kTaskNotSupported};
  const std::size_t count = command.velocity.size();
  const bool point = command.frame != JogFrame::kJoint && count == 3;
  if (count != space_.numbers(command.frame) && !point) {
    return Error{ErrorCode::kTaskNotSupported, -1, static_cast<double>(count),
                 static_cast<double>(space_.numbers(command.frame))};
  }
  for (std::size_t k = 0; k < count; ++k) {
    if (!(std::abs(command.velocity[k]) <= kSpeedMax)) {
      return Error{ErrorCode::kMoveInput, static_cast<std::int8_t>(k), command.velocity[k],
                   kSpeedMax};
    }
  }
  if (command.expiry <= Duration::zero() || command.expiry > kJogExpiryMax) {
    return Error{ErrorCode::kSegmentTime, -1, to_seconds(command.expiry),
                 to_seconds(kJogExpiryMax)};
  }
  if (now < last_) return Error{ErrorCode::kSegmentTime, -1, to_seconds(now - last_), 0};
  return std::nullopt;
}

std::optional<Error> Jog::command(const JogCommand& command, Instant now) {
  if (const auto error = refusal(command, now)) return error;
  expires_ = now + command.expiry;
  if (std::ranges::all_of(command.velocity, [](double number) { return number == 0; })) {
    if (driven()) drive_ = Drive::kBrake;
    idle_ = JogReason::kNoCommand;
    return std::nullopt;
  }
  const bool joints = command.frame == JogFrame::kJoint;
  const Drive drive = joints ? Drive::kJoints : Drive::kTool;
  JointArray wanted{};
  for (std::size_t k = 0; k < command.velocity.size(); ++k) {
    wanted[k] = (joints ? 1 : space_.scale(k)) * command.velocity[k];
  }
  if (drive == drive_ && command.frame == frame_ && wanted == wanted_joints_) return std::nullopt;
  // From what the tool does, not from what it was asked for and a boundary did not let it.
  ramp_valid_ = false;
  refused_ = JogReason::kNone;
  drive_ = drive;
  frame_ = command.frame;
  wanted_joints_ = wanted;
  std::copy_n(wanted.begin(), kTasksMax, wanted_.begin());
  return std::nullopt;
}

void Jog::stop() {
  if (drive_ != Drive::kRest) drive_ = Drive::kBrake;
  idle_ = JogReason::kStopped;
}

void Jog::expire(Instant now) {
  if (!driven() || (now < expires_ && now - last_ <= kGap)) return;
  drive_ = Drive::kBrake;
  idle_ = JogReason::kExpired;
}

std::optional<Error> Jog::step(Instant now) {
  if (now < last_) return Error{ErrorCode::kSegmentTime, -1, to_seconds(now - last_), 0};
  expire(now);
  const Duration gone = now - last_;
  last_ = now;
  if (gone == Duration::zero()) return std::nullopt;
  if (drive_ == Drive::kBrake || drive_ == Drive::kRest) {
    brake(to_seconds(gone));
    return std::nullopt;
  }
  const auto steps = (gone + kStep - Duration{1}) / kStep;
  const double dt = to_seconds(gone) / static_cast<double>(steps);
  for (auto k = steps; k > 0; --k) advance(dt);
  return std::nullopt;
}

void Jog::advance(double dt) {
  // Half braked and half driven it would be thrown about.
  if (refused_ == JogReason::kContact) return brake(dt);
  refused_ = JogReason::kNone;
  if (drive_ == Drive::kJoints) return drive_joints(dt);
  if (!drive_tool(dt)) {
    refused_ = JogReason::kPoseLimit;
    brake(dt);
  }
  step_ = dt;
}

void Jog::set_states(const States& next) {
  states_ = next;
  for (std::size_t j = 0; j < joints(); ++j) {
    setpoint_.q[j] = next[j].q;
    setpoint_.qd[j] = next[j].qd;
    setpoint_.qdd[j] = next[j].qdd;
  }
}

void Jog::plan_stop(const States& states, JogStop& stop) const {
  stop.plan({joints_.data(), joints()}, {states.data(), joints()});
}

/// The way to rest that was found to be free when the last setpoint was made, or the one from here
/// where that was not asked.
void Jog::brake(double dt) {
  ramp_valid_ = false;
  if (drive_ == Drive::kRest) return;
  if (!can_stop_) {
    plan_stop(states_, *stop_);
    stopping_ = 0;
    can_stop_ = true;
  }
  stopping_ += dt;
  States next{};
  JointArray q{};
  for (std::size_t j = 0; j < joints(); ++j) {
    next[j] = stop_->at(j, stopping_);
    q[j] = next[j].q;
  }
  set_states(next);
  if (const auto X = space_.place(q, X_BT_)) X_BT_ = *X;
  if (drive_ == Drive::kBrake && at_rest()) drive_ = Drive::kRest;
}

bool Jog::at_rest() const {
  for (std::size_t j = 0; j < joints(); ++j) {
    if (states_[j].qd != 0 || states_[j].qdd != 0) return false;
  }
  return true;
}

/// Of velocities `full` (of the joints), what the wire carries of them.
void Jog::slow_for_wire(const JointArray& full, double& share) {
  double sum = 0;
  for (std::size_t j = 0; j < joints(); ++j) sum += std::abs(full[j]);
  // One joint alone may have the wire's whole speed as its own limit.
  wire_slows_ = sum * share >= shared_velocity_ * (1 - 1e-9);
  if (wire_slows_) share = std::min(share, shared_velocity_ / sum);
}

/// A joint that slows down holds its part of the wire until it has done so: those that shall become
/// faster get what is left.
void Jog::share_wire(JointArray& wanted) const {
  if (!std::isfinite(shared_velocity_)) return;
  JointArray held{};
  double sum = 0, more = 0;
  for (std::size_t j = 0; j < joints(); ++j) {
    // The fastest that it will still be on the way to no acceleration.
    const double qd = states_[j].qd, qdd = states_[j].qdd;
    held[j] =
        std::max(std::abs(qd), std::abs(qd + qdd * std::abs(qdd) / (2 * joints_[j].limits().jerk)));
    sum += held[j];
    more += std::max(std::abs(wanted[j]) - held[j], 0.0);
  }
  const double left = std::max(shared_velocity_ - sum, 0.0);
  if (more <= left) return;
  for (std::size_t j = 0; j < joints(); ++j) {
    const double extra = std::abs(wanted[j]) - held[j];
    if (extra > 0) wanted[j] = std::copysign(held[j] + extra * left / more, wanted[j]);
  }
}

/// Once it is clear, contacts are kept out as anywhere.
void Jog::look_at_overlap() {
  // In some pose of joints that are left out it may overlap anywhere: that excuses nothing.
  if (!overlaps_ || !collision_ || collision_->poses() > 1) {
    overlaps_ = false;
    return;
  }
  const auto X_BP = relabel<frame::Base, frame::Platform>(X_BT_);
  distance_ = collision_->distance({setpoint_.q.data(), joints()}, &X_BP).distance;
  overlaps_ = distance_ < collision_->margin() - kOverlapDepth;
}

void Jog::drive_joints(double dt) {
  speed_share_ = 1;
  slowest_ = -1;
  look_at_overlap();
  for (std::size_t j = 0; j < joints(); ++j) {
    const double slow = overlaps_ ? kOverlapShare : 1;
    const double most = slow * joints_[j].limits().velocity;
    if (std::abs(wanted_joints_[j]) * speed_share_ <= most) continue;
    speed_share_ = most / std::abs(wanted_joints_[j]);
    slowest_ = static_cast<std::int8_t>(j);
  }
  slow_for_wire(wanted_joints_, speed_share_);
  JointArray wanted = wanted_joints_;
  for (double& velocity : wanted) velocity *= speed_share_;
  share_wire(wanted);
  States next{};
  for (std::size_t j = 0; j < joints(); ++j) {
    next[j] = joints_[j].follow(states_[j], {wanted[j], 0}, dt);
  }
  try_states(next, dt);
}

/// From what the joints do now, whoever made them do it.
void Jog::begin_ramp() {
  JointArray qd{}, qdd{};
  for (std::size_t j = 0; j < joints(); ++j) {
    qd[j] = states_[j].qd;
    qdd[j] = states_[j].qdd;
  }
  ramp_.begin(resolver_.task_of(qd), resolver_.task_of(qdd));
  reference_ = qd;
  along_ramp_ = qd;
  turn_ = {};
  held_ = resolver_.held();
  ramp_valid_ = true;
}

/// Of what is wanted: no joint beyond its speed, nor, in the curves that it has to take, beyond a
/// part of its acceleration and jerk.
double Jog::speed_share(const JointArray& full, const JointArray& turn) {
  double share = 1;
  slowest_ = -1;
  const auto slow = [&](std::size_t j, double most) {
    if (!(most < share)) return;
    share = most;
    slowest_ = static_cast<std::int8_t>(j);
  };
  const double wanted = length_of(wanted_);
  const double now = wanted > 0 ? length_of(ramp_.velocity()) / wanted : 0;
  for (std::size_t j = 0; j < joints(); ++j) {
    const auto& [velocity, acceleration, jerk] = joints_[j].limits();
    if ((resolver_.held() >> j & 1U) == 0 && full[j] != 0) slow(j, velocity / std::abs(full[j]));
    // A curve's acceleration grows with the square of the speed, its jerk with the cube.
    if (turn[j] == 0) continue;
    slow(j, now * std::sqrt(kCurveShare * acceleration / std::abs(turn[j])));
    const double change = std::abs(turn[j] - turn_[j]) / step_;
    if (change > 0 && turn_[j] != 0) slow(j, now * std::cbrt(kCurveShare * jerk / change));
  }
  slow_for_wire(full, share);
  return share;
}

/// Acceleration (and jerk) of the tool along its ramp, whose joints change as `change` says.
double Jog::ramp_limits(const JointArray& change, const JointArray& turn, double& jerk) const {
  double acceleration = std::numeric_limits<double>::infinity();
  jerk = acceleration;
  for (std::size_t j = 0; j < joints(); ++j) {
    if (change[j] == 0) continue;
    const motion::AxisLimits& limits = joints_[j].limits();
    const double left =
        std::max(limits.acceleration - std::abs(turn[j]), 0.2 * limits.acceleration);
    acceleration = std::min(acceleration, kRampShare * left / std::abs(change[j]));
    jerk = std::min(jerk, kRampJerkShare * limits.jerk / std::abs(change[j]));
  }
  return acceleration;
}

bool Jog::drive_tool(double dt) {
  JointArray q{};
  for (std::size_t j = 0; j < joints(); ++j) {
    const AxisState& state = states_[j];
    q[j] = state.q + dt * (state.qd + dt / 2 * state.qdd);
  }
  if (!resolver_.look(frame_, q, ramp_.velocity(), X_BT_)) return false;
  if (!ramp_valid_) begin_ramp();
  const bool same = held_ == resolver_.held();
  held_ = resolver_.held();

  JointArray turn{};
  // A joint that brakes before its limit makes the others change too, but that is no curve.
  if (same && step_ > 0 && !resolver_.in_the_way(ramp_.velocity())) {
    const JointArray now = resolver_.joints_for(ramp_.velocity());
    for (std::size_t j = 0; j < joints(); ++j) turn[j] = (now[j] - along_ramp_[j]) / dt;
  }
  speed_share_ = speed_share(resolver_.joints_for(wanted_), turn);
  turn_ = turn;
  TaskArray target = wanted_;
  for (double& number : target) number *= speed_share_;
  // The limits belong to the direction, which belongs a little to the limits: once round is enough.
  double jerk = 0;
  double acceleration = 0;
  const double size = std::max({length_of(wanted_), length_of(ramp_.velocity()), 1e-9});
  for (double time = 0.5, pass = 0; pass < 2; ++pass) {
    TaskArray way = ramp_.direction(target, time, 1);
    for (double& number : way) number *= size;  // as far as it may go: walls stand at a distance
    JointArray change = resolver_.joints_for(way);
    for (double& number : change) number /= size;
    acceleration = ramp_limits(change, turn, jerk);
    if (!std::isfinite(acceleration)) acceleration = jerk = 1;
    time = acceleration / jerk;
  }
  ramp_.step(target, acceleration, jerk, dt);
  along_ramp_ = resolver_.joints_for(ramp_.velocity());

  JointArray reference = resolver_.drive(ramp_.velocity(), dt);
  double scale = 1, sum = 0;
  for (std::size_t j = 0; j < joints(); ++j) {
    scale = std::min(scale, joints_[j].limits().velocity / std::abs(reference[j]));
    sum += std::abs(reference[j]);
  }
  scale = std::min(scale, shared_velocity_ / sum);
  if (scale < 1) {
    for (double& number : reference) number *= scale;
  }
  States next{};
  for (std::size_t j = 0; j < joints(); ++j) {
    const double rate = same ? (reference[j] - reference_[j]) / dt : states_[j].qdd;
    next[j] = joints_[j].follow(states_[j], {reference[j], rate}, dt);
  }
  reference_ = reference;
  try_states(next, dt);
  return true;
}

/// Only where the robot may also come to rest afterwards; else it comes to rest now, where it was
/// found that it may.
void Jog::try_states(const States& next, double dt) {
  if (space_.has_more_limits() || collision_) {
    plan_stop(next, *tried_);
    if (!may_be(*tried_)) return brake(dt);
    std::swap(stop_, tried_);
    stopping_ = 0;
    can_stop_ = true;
  } else {
    can_stop_ = false;
  }
  set_states(next);
  JointArray q{};
  for (std::size_t j = 0; j < joints(); ++j) q[j] = next[j].q;
  if (const auto X = space_.place(q, X_BT_)) X_BT_ = *X;
}

/// Looks along the way to rest, at places that follow each other in even times.
bool Jog::may_be(const JogStop& stop) {
  std::array<JointArray, kLooks + 1> way{};
  double violation = 0;
  for (std::size_t k = 0; k <= kLooks; ++k) {
    const double t = stop.duration() * static_cast<double>(k) / kLooks;
    for (std::size_t j = 0; j < joints(); ++j) way[k][j] = stop.at(j, t).q;
    // A platform's ways to rest are short, and looking at its joints is dear.
    if (!space_.has_more_limits() || (space_.tool().hexapod() != nullptr && k < kLooks)) continue;
    violation = std::max(violation, space_.violation(way[k], X_BT_));
  }
  if (violation > 0 && !(violation < violation_)) {
    refused_ = JogReason::kPoseLimit;
    return false;
  }
  const bool may_touch = overlaps_ && drive_ == Drive::kJoints;
  if (collision_ && !may_touch && !clear_to_rest(way)) {
    refused_ = JogReason::kContact;
    return false;
  }
  violation_ = violation;
  return true;
}

bool Jog::clear_to_rest(std::span<const JointArray> way) const {
  const auto X_BP = relabel<frame::Base, frame::Platform>(X_BT_);
  const double margin = collision_->margin();
  const auto span = [&](const JointArray& q) { return std::span(q.data(), joints()); };
  if (space_.tool().hexapod() == nullptr) {
    // Nothing moves farther than by its distance from all joints that turn; hands reach farther
    // than their tip by less than half of the arm.
    double turn = 0;
    for (std::size_t j = 0; j < joints(); ++j) turn += std::abs(way.back()[j] - way.front()[j]);
    const double reach = 1.5 / space_.scale(0);
    const double room = collision_->distance(span(way.front()), &X_BP).distance - margin;
    if (room > turn * reach + CollisionModel::kResolution) return true;
  }
  for (std::size_t k = 0; k + 1 < way.size(); ++k) {
    JointArray piece{};
    for (std::size_t j = 0; j < joints(); ++j) piece[j] = way[k + 1][j] - way[k][j];
    if (collision_->free_time(span(way[k]), span(piece), 1, margin, &X_BP) < 1) return false;
  }
  return true;
}

JogStatus Jog::status() const {
  JogStatus status;
  status.moving = !at_rest();
  if (drive_ == Drive::kBrake || drive_ == Drive::kRest) {
    status.reason = idle_;
    return status;
  }
  JointArray qd{};
  for (std::size_t j = 0; j < joints(); ++j) qd[j] = states_[j].qd;
  const bool tool = drive_ == Drive::kTool;
  if (tool) {
    status.share = along(resolver_.task_of(qd), wanted_);
    if (length_of(wanted_) == 0) return status;
  } else {
    double sum = 0;
    double squares = 0;
    for (std::size_t j = 0; j < joints(); ++j) {
      sum += qd[j] * wanted_joints_[j];
      squares += wanted_joints_[j] * wanted_joints_[j];
    }
    if (squares == 0) return status;
    status.share = sum / squares;
  }
  status.reason = refused_;
  if (refused_ != JogReason::kNone) return status;
  if (!tool) {
    for (std::size_t j = 0; j < joints(); ++j) {
      const double asked = speed_share_ * std::abs(wanted_joints_[j]);
      if (asked > joints_[j].approach_speed(states_[j].q, wanted_joints_[j] > 0, 1)) {
        status.reason = JogReason::kJointLimit;
        status.joint = static_cast<std::int8_t>(j);
        return status;
      }
    }
  } else {
    const JogObstacle obstacle = resolver_.obstacle(ramp_.velocity());
    status.joint = obstacle.joint;
    if (obstacle.kind == JogObstacle::Kind::kJointLimit) status.reason = JogReason::kJointLimit;
    if (obstacle.kind == JogObstacle::Kind::kPoseLimit) status.reason = JogReason::kPoseLimit;
    if (obstacle.kind == JogObstacle::Kind::kSingular) status.reason = JogReason::kSingular;
    if (status.reason != JogReason::kNone) return status;
  }
  if (!tool && overlaps_) {
    status.reason = JogReason::kOverlap;
    status.distance = distance_;
    return status;
  }
  if (speed_share_ < 0.999) {
    status.reason = wire_slows_ ? JogReason::kWire : JogReason::kJointSpeed;
    status.joint = wire_slows_ ? std::int8_t{-1} : slowest_;
  }
  return status;
}

}  // namespace sinew::planning
