#pragma once

#include <algorithm>
#include <cmath>

#include "sinew/core/instant.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis/axis_device.h"
#include "sinew/model/robot_model.h"

namespace sinew::test {

/// An axis that turns at one speed, homes to a given angle, and does nothing else wrong. What a
/// test wants to go wrong it sets itself.
class FakeAxis final : public Axis {
 public:
  explicit FakeAxis(double lower = from_deg(-170), double upper = from_deg(170))
      : lower_(lower), upper_(upper), home_q(lower) {}

  void advance(Instant now) {
    const double step = to_seconds(now - now_) * speed;
    now_ = now;
    if (!told_.moving && !told_.homing) return;
    const double goal = told_.homing ? home_q : told_.q_target;
    const double left = goal - told_.q;
    told_.q += std::clamp(left, -step, step);
    if (std::abs(left) > step || endless) return;
    if (told_.homing) {
      told_.homed = told_.position_ok = true;
      told_.q_target = home_q;
    }
    told_.moving = told_.homing = false;
  }

  AxisStatus status() const override { return told_; }
  AxisVerdict home() override {
    ++homings;
    if (told_.emergency_stopped) return AxisVerdict::kEmergencyStopped;
    if (told_.fault != AxisFault::kNone) return AxisVerdict::kFaulted;
    told_.homed = told_.position_ok = false;
    told_.homing = true;
    return AxisVerdict::kAccepted;
  }
  void cancel_homing() override {
    ++cancels;
    told_.homing = false;
  }
  AxisVerdict move_to(double q) override {
    ++moves;
    if (told_.emergency_stopped) return AxisVerdict::kEmergencyStopped;
    if (told_.fault != AxisFault::kNone) return AxisVerdict::kFaulted;
    if (!told_.homed) return AxisVerdict::kNotHomed;
    if (!(q >= lower_ - kJointLimitTolerance && q <= upper_ + kJointLimitTolerance)) {
      return AxisVerdict::kOutOfLimits;
    }
    told_.q_target = q;
    told_.moving = true;
    return AxisVerdict::kAccepted;
  }
  AxisVerdict track(double, double) override { return AxisVerdict::kBusy; }
  void stop(AxisFault why) override {
    told_.moving = told_.homing = false;
    told_.fault = why;
  }
  void emergency_stop() override {
    ++stops;
    if (deaf_to_stop) return;
    told_.emergency_stopped = true;
    told_.moving = told_.homing = false;
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
  }
  /// As if it had been homed before the test.
  void place(double q) {
    told_.q = told_.q_target = q;
    told_.homed = told_.position_ok = true;
  }
  AxisStatus& told() { return told_; }
  double q() const { return told_.q; }

 private:
  double lower_;
  double upper_;
  AxisStatus told_;
  Instant now_{};

 public:
  double home_q;
  double speed = from_deg(40);  ///< rad/s
  bool endless = false;         ///< never says that it arrived
  bool deaf_to_stop = false;
  bool fault_stays = false;
  bool test_fails = false;
  int moves = 0, homings = 0, cancels = 0, stops = 0, releases = 0, clears = 0, self_tests = 0;
};

}  // namespace sinew::test
