#include "sinew/devices/lsc/lsc_driver_units.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew {
namespace {

/// Units that the wire can say: of bus servos 0..1000, else a pulse in us.
constexpr double kBusMin = 0, kBusMax = 1000;
constexpr double kPulseMin = 500, kPulseMax = 2500;

SendRange servo_range(const Joint& joint, const JointPosition& here) {
  SendRange range = joint;
  if (here.quality == PositionQuality::kLost) return range;
  if (here.q < range.lower) range.lower = here.q - kServoSlack;
  if (here.q > range.upper) range.upper = here.q + kServoSlack;
  return range;
}

/// LscUnits::of_joint() of the servo of a joint.
/// @param limits  the joint's
Expected<std::uint16_t> servo_units(const LscDevice& device, std::size_t joint, const Joint& limits,
                                    double q, const SendRange& range) {
  const auto index = static_cast<std::int8_t>(joint);
  if (!range.holds(q)) {
    const double limit = q < limits.lower ? limits.lower : limits.upper;
    return std::unexpected(Error{ErrorCode::kJointLimit, index, q, limit});
  }
  const LscServo& servo = device.servos[joint];
  const double units = std::round(servo.centre + servo.trim + servo.units_per_rad * q);
  // What the wire itself can say.
  const bool bus = device.profile == LscProfile::kBus;
  const bool back = !within_limits(limits, q);
  const double lower = back ? (bus ? kBusMin : kPulseMin) : servo.lower;
  const double upper = back ? (bus ? kBusMax : kPulseMax) : servo.upper;
  if (!(units >= lower && units <= upper)) {
    const double limit = units < lower ? lower : upper;
    return std::unexpected(Error{ErrorCode::kPulseRange, index, units, limit});
  }
  return static_cast<std::uint16_t>(units);
}

}  // namespace

LscUnits::LscUnits(const LscDevice& device, std::span<const Joint> joints,
                   const std::optional<JawGripper>& gripper)
    : device_(device), joints_(joints), gripper_(gripper) {
  SINEW_ASSERT(!joints.empty() && joints.size() == device.servos.size());
  SINEW_ASSERT(slots() <= kMaxJoints);
  for (const LscServo& servo : device.servos) {
    SINEW_ASSERT(servo.units_per_rad != 0 && servo.lower >= 0 && servo.upper <= 0xFEFF);
  }
  SINEW_ASSERT(device.gripper.open != device.gripper.closed);
}

std::optional<std::size_t> LscUnits::jaws() const {
  if (!gripper_) return std::nullopt;
  return joints_.size();
}

std::uint8_t LscUnits::id(std::size_t slot) const {
  return slot < joints_.size() ? device_.servos[slot].id : device_.gripper.id;
}

std::optional<std::size_t> LscUnits::slot_of(std::uint8_t servo_id) const {
  for (std::size_t slot = 0; slot < slots(); ++slot) {
    if (id(slot) == servo_id) return slot;
  }
  return std::nullopt;
}

Expected<std::uint16_t> LscUnits::of_joint(std::size_t joint, double q,
                                           const SendRange& range) const {
  return servo_units(device_, joint, joints_[joint], q, range);
}

std::uint16_t LscUnits::beside(std::size_t joint, std::uint16_t units, double more) const {
  const LscServo& servo = device_.servos[joint];
  const auto units_of = [&](double q) {
    return servo.centre + servo.trim + servo.units_per_rad * q;
  };
  const auto [low, high] =
      std::minmax({units_of(joints_[joint].lower), units_of(joints_[joint].upper)});
  const double lowest = std::max(low, 1.0 * servo.lower),
               highest = std::min(high, 1.0 * servo.upper);
  // From beyond a limit never farther out.
  const double lower = std::min(1.0 * units, std::ceil(lowest));
  const double upper = std::max(1.0 * units, std::floor(highest));
  return static_cast<std::uint16_t>(std::clamp(std::round(units + more), lower, upper));
}

Expected<std::uint16_t> LscUnits::of_width(double width) const {
  if (!gripper_) return std::unexpected(Error{ErrorCode::kToolNotFitted});
  const LscGripper& jaws = device_.gripper;
  const double units = jaws.closed + (jaws.open - jaws.closed) * width / gripper_->width_max;
  if (!std::isfinite(width) || width < 0 || width > gripper_->width_max) {
    const double limit = width < 0 ? jaws.closed : jaws.open;
    return std::unexpected(Error{ErrorCode::kGripperRange, -1, units, limit});
  }
  return static_cast<std::uint16_t>(std::lround(units));
}

double LscUnits::width_of(double units) const {
  SINEW_ASSERT(gripper_.has_value());
  const LscGripper& jaws = device_.gripper;
  return gripper_->width_max * (units - jaws.closed) / (jaws.open - jaws.closed);
}

double LscUnits::q_of(std::size_t joint, double units) const {
  const LscServo& servo = device_.servos[joint];
  return (units - servo.centre - servo.trim) / servo.units_per_rad;
}

bool LscUnits::inside(std::size_t joint, double q) const {
  const Joint& limits = joints_[joint];
  return q >= limits.lower - resolution(joint) && q <= limits.upper + resolution(joint);
}

SendRange LscUnits::range_from(std::size_t joint, const JointPosition& here) const {
  return servo_range(joints_[joint], here);
}

double LscUnits::resolution(std::size_t joint) const {
  return 1 / std::abs(device_.servos[joint].units_per_rad);
}

double LscUnits::speed_max(std::size_t joint) const {
  return joints_[joint].velocity_max * std::abs(device_.servos[joint].units_per_rad);
}

double LscUnits::stroke() const {
  return std::abs(device_.gripper.closed - device_.gripper.open);
}

std::optional<Error> LscDevice::target_refusal(const RobotModel& robot, std::span<const double> q,
                                               std::span<const double> from) const {
  for (std::size_t i = 0; i < q.size(); ++i) {
    const double here = from.empty() ? robot.joints[i].home : from[i];
    const auto range = servo_range(robot.joints[i], {PositionQuality::kMeasured, here, here, here});
    const auto told = servo_units(*this, i, robot.joints[i], q[i], range);
    if (!told) return told.error();
  }
  return std::nullopt;
}

}  // namespace sinew
