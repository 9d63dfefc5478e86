#include "sinew/devices/maxarm/maxarm_driver_pulses.h"

#include <cmath>

#include "sinew/core/error_code.h"

namespace sinew {

Expected<MaxArmPulses> maxarm_pulses(const MaxArmDevice& device, std::span<const Joint> joints,
                                     std::span<const double> q,
                                     std::span<const JointPosition> here) {
  if (q.size() != maxarm::kServos || joints.size() != maxarm::kServos) {
    return std::unexpected(Error{ErrorCode::kTaskNotSupported});
  }
  MaxArmPulses pulses{};
  for (std::size_t i = 0; i < maxarm::kServos; ++i) {
    const auto index = static_cast<std::int8_t>(i);
    SendRange range = joints[i];
    if (!here.empty()) range = range.from(here[i]);
    if (!range.holds(q[i])) {
      const double limit = q[i] < joints[i].lower ? joints[i].lower : joints[i].upper;
      return std::unexpected(Error{ErrorCode::kJointLimit, index, q[i], limit});
    }
    const double pulse = device.servos[i].offset + device.servos[i].pulses_per_rad * q[i];
    const double whole = std::round(pulse);
    if (!(whole >= kMaxArmPulseMin && whole <= kMaxArmPulseMax)) {
      const double limit = whole < kMaxArmPulseMin ? kMaxArmPulseMin : kMaxArmPulseMax;
      return std::unexpected(Error{ErrorCode::kPulseRange, index, pulse, limit});
    }
    pulses[i] = static_cast<std::int32_t>(whole);
  }
  return pulses;
}

std::optional<Error> MaxArmDevice::target_refusal(const RobotModel& robot,
                                                  std::span<const double> q,
                                                  std::span<const double> from) const {
  FixedVector<JointPosition, kMaxJoints> here;
  for (const double at : from) here.push_back({PositionQuality::kMeasured, at, at, at});
  const auto pulses = maxarm_pulses(*this, robot.joints, q, {here.data(), here.size()});
  return pulses ? std::nullopt : std::optional(pulses.error());
}

}  // namespace sinew
