#include "sinew/devices/axis/axis_device_homing.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

/// A way may take half as long again as it should, and some time for what settles.
constexpr double kTimeFactor = 1.5;
constexpr double kTimeExtra = 2;        // s
constexpr double kWayTolerance = 1e-6;  // rad
/// The edge lies before the place of contact; no need to go far beyond that.
constexpr double kBeyondContact = 0.2;  // of back_off

}  // namespace

void Debouncer::read(bool closed, double dt) {
  level_ = std::clamp(level_ + (closed ? dt : -dt), 0.0, time_);
  if (level_ >= time_) closed_ = true;
  if (level_ <= 0) closed_ = false;
}

Homing::Wish Homing::fail(AxisFault fault) {
  started_ = false;
  return {.kind = Wish::Kind::kFail, .fault = fault};
}

Homing::Wish Homing::move(double q_from, double q_to, double speed) {
  motion::AxisLimits limits = limits_;
  limits.velocity = std::min(limits.velocity, speed);
  const double expected = motion::plan_axis(std::abs(q_to - q_from), limits).duration();
  time_left_ = kTimeFactor * expected + kTimeExtra;
  return {.kind = Wish::Kind::kMoveTo, .q = q_to, .speed = limits.velocity};
}

Homing::Wish Homing::enter(Phase phase, double q, bool closed) {
  phase_ = phase;
  const double towards = settings_.direction;
  switch (phase) {
    case Phase::kLeaveSwitch:
      contact_ = q;
      return move(q, q - towards * settings_.back_off_max, settings_.approach_speed);
    case Phase::kApproach:
      return move(q, q + towards * settings_.travel_max, settings_.approach_speed);
    case Phase::kContact:
      return {.kind = Wish::Kind::kStop};
    case Phase::kBackOff:
      contact_ = q;
      return move(q, q - towards * (closed ? settings_.back_off_max : settings_.back_off),
                  settings_.approach_speed);
    case Phase::kEdge:
      maybe_closing_ = false;
      return move(q, contact_ + towards * kBeyondContact * settings_.back_off,
                  settings_.slow_speed);
    case Phase::kZero:
      return {.kind = Wish::Kind::kNameMark, .q = settings_.end_stop_angle};
    case Phase::kClear:
      return move(q, settings_.clear_angle, limits_.velocity);
    case Phase::kIdle:
      break;
  }
  return {};
}

Homing::Wish Homing::tick(const Debouncer& end_stop, double q, bool at_rest, double dt) {
  if (!started_) return {};
  const bool closed = end_stop.closed();
  time_left_ -= dt;
  const bool late = phase_ != Phase::kIdle && time_left_ < 0;
  switch (phase_) {
    case Phase::kIdle:
      time_left_ = kTimeExtra;
      return enter(closed ? Phase::kLeaveSwitch : Phase::kApproach, q, closed);
    case Phase::kLeaveSwitch:
    case Phase::kBackOff: {
      const double away = std::abs(q - contact_);
      if (!closed && away >= settings_.back_off - kWayTolerance)
        return enter(Phase::kEdge, q, closed);
      if (at_rest || late) return fail(AxisFault::kEndStopStuck);
      return {};
    }
    case Phase::kApproach:
      if (closed) return enter(Phase::kContact, q, closed);
      return at_rest || late ? fail(AxisFault::kHomingTimeout) : Wish{};
    case Phase::kContact:
      return at_rest ? enter(Phase::kBackOff, q, closed) : Wish{};
    case Phase::kEdge:
      if (closed) return enter(Phase::kZero, q, closed);
      if (at_rest || late) return fail(AxisFault::kHomingTimeout);
      // The first of the bounces is where it closes.
      if (end_stop.closing() == maybe_closing_) return {};
      maybe_closing_ = end_stop.closing();
      return maybe_closing_ ? Wish{.kind = Wish::Kind::kMark} : Wish{};
    case Phase::kZero:
      return at_rest ? enter(Phase::kClear, q, closed) : Wish{};
    case Phase::kClear:
      if (closed && (std::abs(q - settings_.end_stop_angle) > settings_.back_off_max || at_rest)) {
        return fail(AxisFault::kEndStopStuck);
      }
      if (!at_rest) return late ? fail(AxisFault::kHomingTimeout) : Wish{};
      started_ = false;
      return {.kind = Wish::Kind::kDone};
  }
  return {};
}

}  // namespace sinew
