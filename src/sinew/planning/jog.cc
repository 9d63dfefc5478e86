#include "sinew/planning/jog.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"
#include "sinew/planning/motion_limits.h"

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
    : space_(model, options.jaw_width),
      joints_(joints_of(model)),
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
  last_ = now;
  drive_ = Drive::kBrake;
  idle_ = JogReason::kNoCommand;
  refused_ = JogReason::kNone;
  ramp_valid_ = false;
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
  const bool driven = drive_ == Drive::kJoints || drive_ == Drive::kTool;
  if (!driven || (now < expires_ && now - last_ <= kGap)) return;
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

Jog::Stops Jog::stops_from(const States& states) const {
  Stops stops;
  for (std::size_t j = 0; j < joints(); ++j) {
    stops.joints[j] = joints_[j].stop(states[j]);
    stops.duration = std::max(stops.duration, stops.joints[j].duration());
  }
  for (std::size_t j = 0; j < joints(); ++j) {
    stops.joints[j] = joints_[j].stop_in(states[j], stops.duration);
  }
  return stops;
}

/// The way to rest that was found to be free when the last setpoint was made, or the one from here
/// where that was not asked.
void Jog::brake(double dt) {
  ramp_valid_ = false;
  if (drive_ == Drive::kRest) return;
  if (!can_stop_) {
    stops_ = stops_from(states_);
    stopping_ = 0;
    can_stop_ = true;
  }
  stopping_ += dt;
  States next{};
  JointArray q{};
  for (std::size_t j = 0; j < joints(); ++j) {
    // Durations differ by rounding.
    const motion::OnlineProfile& stop = stops_.joints[j];
    next[j] =
        stop.at(stopping_ >= stops_.duration ? std::max(stopping_, stop.duration()) : stopping_);
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

void Jog::drive_joints(double dt) {
  speed_share_ = 1;
  slowest_ = -1;
  for (std::size_t j = 0; j < joints(); ++j) {
    const double most = joints_[j].limits().velocity;
    if (std::abs(wanted_joints_[j]) * speed_share_ <= most) continue;
    speed_share_ = most / std::abs(wanted_joints_[j]);
    slowest_ = static_cast<std::int8_t>(j);
  }
  States next{};
  for (std::size_t j = 0; j < joints(); ++j) {
    next[j] = joints_[j].follow(states_[j], {speed_share_ * wanted_joints_[j], 0}, dt);
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
  double scale = 1;
  for (std::size_t j = 0; j < joints(); ++j) {
    scale = std::min(scale, joints_[j].limits().velocity / std::abs(reference[j]));
  }
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
    const Stops stops = stops_from(next);
    if (!may_be(stops)) return brake(dt);
    stops_ = stops;
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
bool Jog::may_be(const Stops& stops) {
  std::array<JointArray, kLooks + 1> way{};
  double violation = 0;
  for (std::size_t k = 0; k <= kLooks; ++k) {
    const double t = stops.duration * static_cast<double>(k) / kLooks;
    for (std::size_t j = 0; j < joints(); ++j) way[k][j] = stops.joints[j].at(t).q;
    // A platform's ways to rest are short, and looking at its joints is dear.
    if (!space_.has_more_limits() || (space_.tool().hexapod() != nullptr && k < kLooks)) continue;
    violation = std::max(violation, space_.violation(way[k], X_BT_));
  }
  if (violation > 0 && !(violation < violation_)) {
    refused_ = JogReason::kPoseLimit;
    return false;
  }
  if (collision_ && !clear_to_rest(way)) {
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
        return {JogReason::kJointLimit, static_cast<std::int8_t>(j), status.share, status.moving};
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
  if (speed_share_ < 0.999) {
    status.reason = JogReason::kJointSpeed;
    status.joint = slowest_;
  }
  return status;
}

}  // namespace sinew::planning
