#include "sinew/devices/axis/axis_device_settings.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew {
namespace {

constexpr double kAs5600CountsPerTurn = 4096;
constexpr double kTrackingJerk = 10;  // times the joint's own
/// The switch closes this far outside the position limits, and the homed axis waits as far inside.
constexpr double kSwitchBeyondLimit = from_deg(2);
constexpr double kClearInsideLimit = from_deg(1);
/// From contact to rest, at most: 3 deg/s at 10 deg/s^3.
constexpr double kContactWay = from_deg(1.643);
/// The search may take the whole way between the limits, both ends beyond them, and this.
constexpr double kSearchMargin = from_deg(10);

/// As boards come, where the file says nothing of this one.
AxisBoard board_of(const Device& device, std::size_t joint) {
  const auto boards = boards_of(device);
  return joint < boards.size() ? boards[joint] : AxisBoard{};
}

/// The speed from which a stop takes this way: its acceleration rises and falls, and is held at its
/// limit in between where it gets there.
double speed_to_stop_within(double way, const motion::AxisLimits& limits) {
  const double rise = limits.acceleration * limits.acceleration / (2 * limits.jerk);
  const double held = std::sqrt(rise * rise + 2 * limits.acceleration * way) - rise;
  return held >= 2 * rise ? held : std::cbrt(way * way * limits.jerk);
}

}  // namespace

double AxisSettings::uncertainty() const {
  // Homing names the place of the switch as if the motor pushed the joint there. Where a weight
  // pulled it, the name is off by the whole play; half of the play is left on either flank; and the
  // gear gives, then and now. Two counts are noise and the edge of one.
  const double count = 2 * kPi / std::abs(encoders.motor_counts_per_turn * gear_ratio);
  return 1.5 * backlash + 2 * give + 2 * count;
}

AxisSettings axis_settings(const RobotModel& model, std::size_t joint) {
  SINEW_ASSERT(joint < model.joints.size());
  const Joint& from = model.joints[joint];
  AxisSettings settings;
  if (joint < model.dynamics.drives.size()) {
    const StepperDrive& drive = model.dynamics.drives[joint];
    settings.gear_ratio = drive.gear_ratio;
    settings.backlash = drive.backlash;
    settings.full_steps_per_turn = drive.steps_per_turn;
    settings.microsteps = drive.microsteps;
    settings.encoders.joint = drive.joint_encoder;
    if (drive.joint_encoder == JointEncoder::kAs5600) {
      settings.encoders.joint_counts_per_turn = kAs5600CountsPerTurn;
    }
    // Play and a count of the joint's encoder are no disagreement, whatever this gear's play is.
    settings.supervision.disagreement += drive.backlash;
  }
  settings.lower = from.lower;
  settings.upper = from.upper;
  const AxisBoard board = board_of(model.device, joint);
  settings.step_rate_max = board.step_rate_max;
  settings.encoders.joint_node =
      board.encoder_node && settings.encoders.joint == JointEncoder::kAs5600;
  const double rate_max = settings.step_rate_max / settings.steps_per_rad();
  settings.limits = {std::min(from.velocity_max, kStepRateShare * rate_max), from.acceleration_max,
                     from.jerk_max};
  settings.tracking_jerk = kTrackingJerk * from.jerk_max;

  settings.encoders.gear_ratio = settings.gear_ratio;
  // Half an electrical turn of the motor: two full steps.
  settings.supervision.stall_angle = 2 * 2 * kPi / settings.full_steps_per_turn;

  HomingSettings& homing = settings.homing;
  homing.direction = board.homing_direction;
  if (homing.direction < 0) {
    homing.end_stop_angle = from.lower - kSwitchBeyondLimit;
    homing.clear_angle = std::min(from.lower + kClearInsideLimit, from.upper);
  } else {
    homing.end_stop_angle = from.upper + kSwitchBeyondLimit;
    homing.clear_angle = std::max(from.upper - kClearInsideLimit, from.lower);
  }
  homing.travel_max = from.upper - from.lower + 2 * kSwitchBeyondLimit + kSearchMargin;
  const double approach = speed_to_stop_within(kContactWay, settings.limits);
  homing.approach_speed =
      std::min(std::max(homing.approach_speed, approach), settings.limits.velocity);
  homing.slow_speed = std::min(homing.slow_speed, settings.limits.velocity);

  if (joint < model.dynamics.gains.size()) {
    const AxisGains& gains = model.dynamics.gains[joint];
    settings.cascade.position_gain = gains.position_gain;
    settings.cascade.velocity_gain = gains.velocity_gain;
    settings.cascade.integral_gain = gains.integral_gain;
  }
  settings.cascade.rate_max = rate_max;
  settings.cascade.dead_band = 1 / settings.steps_per_rad();
  return settings;
}

}  // namespace sinew
