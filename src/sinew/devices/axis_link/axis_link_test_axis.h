#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "sinew/core/instant.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis/axis_device.h"
#include "sinew/model/robot_model.h"

namespace sinew::test {

/// Joint `axis` of robot-arm-2, numbers of its fact sheet, but quicker to brake.
inline Joint link_joint(std::size_t axis = 0) {
  constexpr std::array<double, 6> kLimits{170, 90, 135, 170, 120, 360};
  Joint joint;
  joint.upper = from_deg(kLimits.at(axis));
  joint.lower = -joint.upper;
  joint.velocity_max = from_deg(100);
  joint.acceleration_max = from_deg(200);
  joint.jerk_max = from_deg(2000);
  return joint;
}

/// An axis that goes where it is told at up to 1.1 times its full speed, brakes at its
/// acceleration, and keeps a record of what it was told. What a test wants to go wrong it sets.
class LinkTestAxis final : public Axis {
 public:
  explicit LinkTestAxis(const Joint& joint) : joint_(joint), home_angle(joint.lower) {}

  void advance(Instant now) {
    const double dt = to_seconds(now - now_);
    now_ = now;
    if (dt <= 0 || jammed) return;
    double velocity = 0;
    if (braking_) {
      const double speed = std::max(0.0, std::abs(told_.qd) - joint_.acceleration_max * dt);
      velocity = std::copysign(speed, told_.qd);
    } else if (goal_) {
      const double left = *goal_ - told_.q;
      velocity = std::abs(left) <= std::abs(rate_) * dt ? left / dt : rate_;
    }
    told_.q += velocity * dt;
    told_.qd = velocity;
    told_.moving = velocity != 0;
    if (velocity != 0) return;
    if (told_.homing) {
      told_.homed = told_.position_ok = true;
      told_.q += zero_shift;
    }
    told_.homing = braking_ = false;
    goal_.reset();
  }

  AxisStatus status() const override { return told_; }
  AxisVerdict home() override {
    ++homings;
    if (const auto no = refusal()) return *no;
    told_.homed = told_.position_ok = false;
    told_.homing = true;
    go(home_angle);
    rate_ = std::copysign(from_deg(30), home_angle - told_.q);
    return AxisVerdict::kAccepted;
  }
  void cancel_homing() override {
    ++cancels;
    told_.homing = false;
    braking_ = told_.moving;
  }
  AxisVerdict move_to(double q) override { return go_checked(q); }
  AxisVerdict track(double q, double qd) override {
    feed_forward = qd;
    const AxisVerdict verdict = go_checked(q);
    // Evenly to where it shall be at the next setpoint, 1 ms on.
    const double most = 1.1 * joint_.velocity_max;
    rate_ = std::clamp((q - told_.q) * 1000, -most, most);
    return verdict;
  }
  void stop(AxisFault why = AxisFault::kNone) override {
    ++stops;
    told_.homing = false;
    braking_ = told_.moving;
    goal_.reset();
    if (told_.fault == AxisFault::kNone) told_.fault = why;
  }
  void emergency_stop() override {
    ++emergency_stops;
    told_.emergency_stopped = true;
    told_.homing = told_.moving = braking_ = false;
    told_.qd = 0;
    goal_.reset();
  }
  void release_emergency_stop() override {
    ++releases;
    told_.emergency_stopped = false;
  }
  void clear_faults() override {
    ++clears;
    if (!fault_stays) told_.fault = AxisFault::kNone;
  }
  void self_test() override {
    ++self_tests;
    if (test_fails) told_.fault = AxisFault::kSelfTest;
  }

  /// Its supply was gone for a moment.
  void reboot() {
    const double q = told_.q;
    told_ = {};
    told_.q = q;
    goal_.reset();
    braking_ = false;
  }
  /// As if it had been homed before the test.
  void place(double q) {
    told_.q = q;
    told_.homed = told_.position_ok = true;
  }
  AxisStatus& told() { return told_; }
  double q() const { return told_.q; }
  /// Every target that was accepted, in order.
  std::vector<double> targets;

 private:
  std::optional<AxisVerdict> refusal() const {
    if (told_.emergency_stopped) return AxisVerdict::kEmergencyStopped;
    if (told_.fault != AxisFault::kNone) return AxisVerdict::kFaulted;
    if (told_.homing) return AxisVerdict::kBusy;
    return std::nullopt;
  }
  AxisVerdict go_checked(double q) {
    if (const auto no = refusal()) return *no;
    if (!told_.homed) return AxisVerdict::kNotHomed;
    constexpr double kUnit = 1e-8;  // rad
    const bool back_in = q >= std::min(joint_.lower, told_.q) - kUnit &&
                         q <= std::max(joint_.upper, told_.q) + kUnit;
    if (!back_in) return AxisVerdict::kOutOfLimits;
    go(q);
    return AxisVerdict::kAccepted;
  }
  void go(double q) {
    if (keep_record) targets.push_back(q);
    told_.q_target = q;
    goal_ = q;
    rate_ = std::copysign(joint_.velocity_max, q - told_.q);
    braking_ = false;
    // A goal that it stands on already is reached at the next tick.
    told_.moving = told_.q != q;
  }

  Joint joint_;
  AxisStatus told_;
  std::optional<double> goal_;
  double rate_ = 0;
  bool braking_ = false;
  Instant now_{};

 public:
  double home_angle;
  double zero_shift = 0;  ///< by which a search names its zero elsewhere
  double feed_forward = 0;
  bool keep_record = true;
  bool jammed = false;
  bool fault_stays = false;
  bool test_fails = false;
  int homings = 0, cancels = 0, stops = 0, emergency_stops = 0, releases = 0, clears = 0,
      self_tests = 0;
};

}  // namespace sinew::test
