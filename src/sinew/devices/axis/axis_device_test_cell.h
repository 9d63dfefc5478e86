#pragma once

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/devices/axis/axis_device_controller.h"
#include "sinew/devices/axis/axis_machine_plant.h"

namespace sinew::test {

/// One axis of robot-arm-2: motor of the torque table's first row behind its 17:1 gear, limits of
/// the first joint. Inertia, friction and play are those of a printed arm of this size.
inline StepperDrive test_drive() {
  return {.holding_torque = 1.26,
          .motors = 1,
          .gear_ratio = 17,
          .gear_efficiency = 0.7,
          .steps_per_turn = 200,
          .microsteps = 16,
          .rotor_inertia = 3e-5,
          .corner_speed = 30,
          .coulomb_friction = 0.2,
          .viscous_friction = 0.1,
          .backlash = from_deg(0.2),
          .joint_encoder = JointEncoder::kQuadrature};
}

inline RobotModel test_model() {
  RobotModel model;
  model.joints.push_back({.name = "base",
                          .lower = from_deg(-170),
                          .upper = from_deg(170),
                          .velocity_max = from_deg(100),
                          .acceleration_max = from_deg(10),
                          .jerk_max = from_deg(10)});
  model.dynamics.drives.push_back(test_drive());
  return model;
}

inline AxisSettings test_settings() {
  return axis_settings(test_model(), 0);
}

/// A controller and the axis under it, tick by tick in virtual time.
class AxisCell {
 public:
  explicit AxisCell(double q, const AxisSettings& settings = test_settings(),
                    std::uint64_t seed = 1)
      : settings_(settings), plant(plant_settings(settings), q, seed), controller(settings) {
    plant.set_load(0, 0.1);
  }

  void tick(double dt = 1e-3) {
    inputs = plant.inputs();
    if (spoil) spoil(inputs);
    outputs = controller.tick(inputs, now);
    plant.advance(outputs, dt);
    now += from_seconds(dt);
  }
  void run(double seconds, double dt = 1e-3) {
    for (std::int64_t i = ticks(seconds, dt); i > 0; --i) tick(dt);
  }
  /// Until `done` holds; false where that takes longer.
  template <class Done>
  bool run_until(Done done, double seconds, double dt = 1e-3) {
    for (std::int64_t i = ticks(seconds, dt); i > 0; --i) {
      tick(dt);
      if (done()) return true;
    }
    return false;
  }
  bool run_to_rest(double seconds = 30) {
    tick();
    return run_until([&] { return !controller.status().moving; }, seconds);
  }
  /// Powers up, homes, and waits until it is done.
  bool home() {
    run(0.2);
    if (controller.home() != AxisVerdict::kAccepted) return false;
    tick();
    return run_until([&] { return !controller.status().homing; }, 400) && run_to_rest() &&
           controller.status().homed;
  }
  AxisStatus status() const { return controller.status(); }
  /// rad between what the controller says and where the joint is.
  double error() const { return std::abs(status().q - plant.q()); }

  Instant now;
  AxisInputs inputs;
  AxisOutputs outputs;
  void (*spoil)(AxisInputs&) = nullptr;

 private:
  static std::int64_t ticks(double seconds, double dt) { return std::llround(seconds / dt); }
  static sim::AxisPlantSettings plant_settings(const AxisSettings& settings) {
    sim::AxisPlantSettings plant;
    plant.drive = test_drive();
    plant.switch_angle = settings.homing.end_stop_angle;
    plant.end_lower = settings.homing.end_stop_angle - from_deg(3);
    plant.end_upper = settings.upper + from_deg(5);
    plant.joint_as5600 = settings.encoders.joint == JointEncoder::kAs5600;
    return plant;
  }
  AxisSettings settings_;

 public:
  sim::AxisPlant plant;
  AxisController controller;
};

/// Between what the motor's encoder says and the joint: half the play, the gear's wind-up (0.1 deg
/// at stall torque) and two counts.
inline constexpr double kTruth = from_deg(0.15);

/// Homing takes a quarter of a minute of simulated time; most tests begin after it.
inline const AxisCell& homed_cell() {
  static const AxisCell cell = [] {
    AxisCell fresh(from_deg(-165));
    SINEW_ASSERT(fresh.home());
    return fresh;
  }();
  return cell;
}

/// Holds every step of a reference against the limits that the axis was given.
struct LimitWatch {
  explicit LimitWatch(const AxisCell& cell, double jerk) : last(cell.controller.reference()) {
    limits = cell.controller.settings().limits;
    limits.jerk = jerk;
    lower = cell.controller.settings().lower;
    upper = cell.controller.settings().upper;
  }
  void look(const AxisCell& cell, double dt = 1e-3) {
    const motion::AxisState now = cell.controller.reference();
    worst = std::max(
        {worst, std::abs(now.qd) - limits.velocity, std::abs(now.qdd) - limits.acceleration,
         std::abs(now.qdd - last.qdd) / dt - limits.jerk, now.q - upper, lower - now.q});
    last = now;
  }
  motion::AxisState last;
  motion::AxisLimits limits;
  double lower, upper;
  double worst = -1;  ///< rad, s: the greatest excess over any limit
};

}  // namespace sinew::test
