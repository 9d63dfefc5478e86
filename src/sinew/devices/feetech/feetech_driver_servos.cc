#include "sinew/devices/feetech/feetech_driver_servos.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew {

using namespace feetech;

namespace {

/// Units by which a servo's own limit may be inside the file's.
constexpr double kLimitSlack = 2;
constexpr double kTenths = 0.1;
/// rad beyond what its own speed explains; farther is believed when it is said twice.
constexpr double kJump = 0.1;
constexpr double kFastest = 20;  // rad/s, of a joint that falls or is pushed

Error of(std::size_t joint, ErrorCode code, double measured = 0, double limit = 0) {
  return {code, static_cast<std::int8_t>(joint), measured, limit};
}

}  // namespace

FeetechServos::FeetechServos(const FeetechDevice& device, std::span<const Joint> joints,
                             const std::optional<JawGripper>& gripper)
    : device_(device), joints_(joints) {
  SINEW_ASSERT(!joints.empty() && joints.size() == device.servos.size());
  if (gripper) width_max_ = gripper->width_max;
  SINEW_ASSERT(size() <= kServosMax && device.gripper.open != device.gripper.closed);
}

std::uint8_t FeetechServos::id(std::size_t i) const {
  return i < joints() ? device_.servos[i].id : device_.gripper.id;
}

std::optional<std::size_t> FeetechServos::index_of(std::uint8_t servo) const {
  for (std::size_t i = 0; i < size(); ++i) {
    if (id(i) == servo) return i;
  }
  return std::nullopt;
}

void FeetechServos::forget() {
  states_.fill({});
}

void FeetechServos::take_settings(std::size_t i, const Data& data) {
  SINEW_ASSERT(data.size() == kSettingsCount);
  constexpr std::uint8_t kOrder = 2;
  constexpr std::uint8_t kPhase = 18;
  constexpr std::uint8_t kFineSpeed = 0x04;
  constexpr std::uint16_t kCoarse = 50;
  FeetechServoState& servo = states_[i];
  const std::span bytes(data.data(), data.size());
  servo.missed = 0;
  servo.firmware = static_cast<std::uint16_t>(data[0] << 8 | data[1]);
  servo.other_order = (data[kOrder] == 0) != sts();
  servo.model = word_at(bytes, Register::kModel, std::endian::little);
  servo.lowest = word_at(bytes, Register::kLowest, device_.byte_order());
  servo.highest = word_at(bytes, Register::kHighest, device_.byte_order());
  servo.hottest = data[Register::kHottest];
  servo.volts_max = data[Register::kVoltsMax];
  servo.volts_min = data[Register::kVoltsMin];
  const bool no_limits = servo.lowest == 0 && servo.highest == 0;
  servo.mode = sts() ? data[Register::kMode] : static_cast<std::uint8_t>(no_limits ? 1 : 0);
  servo.speed_unit = sts() && (data[kPhase] & kFineSpeed) == 0 ? kCoarse : 1;
}

bool FeetechServos::take_state(std::size_t i, const Reply& reply, Instant asked) {
  SINEW_ASSERT(reply.data.size() == kStateCount);
  FeetechServoState& servo = states_[i];
  const std::span bytes(reply.data.data(), reply.data.size());
  const auto at = [&](std::uint8_t address) {
    return static_cast<std::size_t>(address - kStateFrom);
  };
  const auto word = [&](std::uint8_t address) {
    return word_at(bytes, at(address), device_.byte_order());
  };
  const auto units =
      static_cast<std::int16_t>(signed_word(word(Register::kPosition), kPositionSign));
  const auto within = [&](std::int16_t before, double speed, Instant then) {
    const double far = kJump * device_.units_per_rad() + speed * to_seconds(asked - then);
    return std::abs(units - before) <= far;
  };
  const bool near = !servo.known || within(servo.units, 2.0 * std::abs(servo.speed), servo.at) ||
                    (servo.suspect &&
                     within(*servo.suspect, kFastest * device_.units_per_rad(), servo.suspect_at));
  servo.missed = 0;
  servo.suspect = near ? std::nullopt : std::optional(units);
  servo.suspect_at = asked;
  if (!near) return false;
  servo.torque = bytes[at(Register::kTorque)] == 1;
  servo.goal = word(Register::kGoal);
  if (sts()) servo.torque_limit = word(Register::kTorqueLimit);
  servo.off = servo.torque ? 0 : servo.off + 1;
  servo.units = units;
  servo.speed = static_cast<std::int16_t>(signed_word(word(Register::kSpeedNow), kPositionSign));
  servo.load = static_cast<std::int16_t>(signed_word(word(Register::kLoad), kLoadSign));
  servo.volts = bytes[at(Register::kVolts)];
  servo.heat = bytes[at(Register::kHeat)];
  servo.troubled = reply.trouble != 0 ? servo.troubled + 1 : 0;
  servo.trouble = reply.trouble;
  servo.at = asked;
  servo.known = true;
  return true;
}

std::optional<Error> FeetechServos::misfit() const {
  for (std::size_t i = 0; i < size(); ++i) {
    const FeetechServoState& servo = states_[i];
    if (servo.other_order) return of(i, ErrorCode::kServoSeries);
    if (servo.mode != 0) return of(i, ErrorCode::kServoMode);
    const bool limited = servo.lowest != 0 || servo.highest != 0;
    if (i >= joints() || !limited) continue;
    const Joint& joint = joints_[i];
    for (const double limit : {joint.lower, joint.upper}) {
      const double units = device_.units_of(i, limit);
      const double reached =
          std::clamp(units, servo.lowest - kLimitSlack, servo.highest + kLimitSlack);
      if (reached == units) continue;
      const double own = units < servo.lowest ? servo.lowest : servo.highest;
      return of(i, ErrorCode::kServoRange, device_.q_of(i, own), limit);
    }
  }
  return std::nullopt;
}

std::optional<Error> FeetechServos::beyond_turn(std::uint8_t servos) const {
  for (std::size_t i = 0; i < size(); ++i) {
    const double units = states_[i].units;
    const double most = device_.units_max();
    const bool asked = (servos >> i & 1U) != 0 && states_[i].known;
    if (asked && (units < 0 || units > most)) return of(i, ErrorCode::kServoTurns, units, most);
  }
  return std::nullopt;
}

std::optional<Error> FeetechServos::trouble(std::size_t i) const {
  const FeetechServoState& servo = states_[i];
  const auto has = [&](std::uint8_t bits) { return (servo.trouble & bits) != 0; };
  if (has(Trouble::kVoltage)) {
    const bool high = servo.volts > servo.volts_max;
    return Error{high ? ErrorCode::kSupplyHigh : ErrorCode::kSupplyLow, -1, kTenths * servo.volts,
                 kTenths * (high ? servo.volts_max : servo.volts_min)};
  }
  if (has(Trouble::kSensor | Trouble::kAngle)) return of(i, ErrorCode::kEncoderLost);
  if (has(Trouble::kHeat)) return of(i, ErrorCode::kOverheated);
  if (has(Trouble::kOverload | Trouble::kCurrent)) return of(i, ErrorCode::kOverloaded);
  return std::nullopt;
}

bool FeetechServos::held() const {
  for (std::size_t i = 0; i < joints(); ++i) {
    if (!states_[i].torque) return false;
  }
  return true;
}

double FeetechServos::units_of(std::size_t joint, double q) const {
  return std::clamp(device_.units_of(joint, q), 0.0, device_.units_max());
}

double FeetechServos::width_of(double units) const {
  return *width_max_ * device_.opening(units);
}

double FeetechServos::units_of_width(double width) const {
  const FeetechDevice::Gripper& gripper = device_.gripper;
  const FeetechServoState& servo = states_[jaws()];
  const double units =
      gripper.closed + (gripper.open - gripper.closed) * std::clamp(width / *width_max_, 0.0, 1.0);
  const bool limited = servo.lowest < servo.highest;
  return limited ? std::clamp(units, 1.0 * servo.lowest, 1.0 * servo.highest) : units;
}

double FeetechServos::torque_limit(std::size_t i) const {
  return i < joints() ? device_.servos[i].torque_limit : device_.gripper.torque_limit;
}

}  // namespace sinew
