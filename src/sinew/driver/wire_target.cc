#include "sinew/driver/wire_target.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis/axis_registers_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/driver/axis_register_units.h"
#include "sinew/driver/bigrobotarm_channel.h"
#include "sinew/driver/maxarm_pulses.h"

namespace sinew {
namespace {

/// Further than the 256 steps in which one byte may stay the same.
constexpr int kUnitsMax = 2000;

std::optional<Error> refusal_of(const BigRobotArmDevice& device, std::span<const double> q) {
  SINEW_ASSERT(q.size() == kBigRobotArmJoints);
  BigRobotArmAngles angles{};
  std::ranges::copy(q, angles.begin());
  const auto steps = BigRobotArmChannel(device).steps_of(angles);
  return steps ? std::nullopt : std::optional(steps.error());
}

std::optional<Error> refusal_of(const AxisRegistersDevice& device, const RobotModel& robot,
                                std::span<const double> q, std::span<const double> from) {
  for (std::size_t i = 0; i < q.size(); ++i) {
    SendRange range = robot.joints[i];
    if (!from.empty()) range = range.from(from[i]);
    const auto told =
        axis_registers::tell_angle(device.encoding, device.boards[i].zero, range, q[i]);
    if (told) continue;
    Error error = told.error();
    error.index = static_cast<std::int8_t>(i);
    return error;
  }
  return std::nullopt;
}

}  // namespace

WireTarget::WireTarget(const RobotModel& robot) : robot_(robot) {
  const auto* device = robot.device.settings.as<LscDevice>();
  if (device == nullptr) return;
  const auto* geometry = std::get_if<SerialGeometry>(&robot.geometry);
  lsc_.emplace(*device, robot.joints, geometry != nullptr ? geometry->gripper : std::nullopt);
}

std::optional<Error> WireTarget::refusal(std::span<const double> q,
                                         std::span<const double> from) const {
  SINEW_ASSERT(q.size() == robot_.joints.size());
  const auto& settings = robot_.device.settings;
  if (const auto* arm = settings.as<BigRobotArmDevice>()) return refusal_of(*arm, q);
  if (const auto* boards = settings.as<AxisRegistersDevice>()) {
    return refusal_of(*boards, robot_, q, from);
  }
  if (const auto* arm = settings.as<MaxArmDevice>()) {
    FixedVector<JointPosition, kMaxJoints> here;
    for (const double at : from) here.push_back({PositionQuality::kMeasured, at, at, at});
    const auto pulses = maxarm_pulses(*arm, robot_.joints, q, {here.data(), here.size()});
    return pulses ? std::nullopt : std::optional(pulses.error());
  }
  if (!lsc_) return std::nullopt;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const double here = from.empty() ? robot_.joints[i].home : from[i];
    const auto range = lsc_->range_from(i, {PositionQuality::kMeasured, here, here, here});
    const auto units = lsc_->of_joint(i, q[i], range);
    if (!units) return units.error();
  }
  return std::nullopt;
}

std::optional<JointVector> WireTarget::nearest(std::span<const double> q) const {
  JointVector near(q);
  for (std::size_t fixed = 0; fixed <= near.size(); ++fixed) {
    const auto error = refusal({near.data(), near.size()});
    if (!error) return near;
    if (error->index < 0) return std::nullopt;
    const auto joint = static_cast<std::size_t>(error->index);
    const double step = robot_.device.settings->resolution(joint);
    const double from = near[joint];
    const auto works = [&](double angle) {
      near[joint] = angle;
      if (!within_limits(robot_.joints[joint], angle)) return false;
      const auto left = refusal({near.data(), near.size()});
      return !left || left->index > error->index;
    };
    int k = 1;
    while (k <= kUnitsMax && !works(from - k * step) && !works(from + k * step)) ++k;
    if (step == 0 || k > kUnitsMax) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace sinew
