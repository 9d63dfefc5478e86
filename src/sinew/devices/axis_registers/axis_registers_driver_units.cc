#include "sinew/devices/axis_registers/axis_registers_driver_units.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"

namespace sinew::axis_registers {

namespace {

/// 1.5 microsteps of a board's 200 x 16 steps behind 17:1.
constexpr double kTargetTolerance = 0.01 * kPi / 180;

std::optional<ToldAngle> told(AngleEncoding encoding, double offset, const AngleBytes& bytes) {
  const auto angle_deg = decode_angle(encoding, bytes);
  if (!angle_deg) return std::nullopt;
  return ToldAngle{bytes, offset + from_deg(*angle_deg),
                   from_deg(angle_unit_deg(encoding, *angle_deg)) / 2};
}

double offset_of(AngleEncoding encoding, double zero) {
  return encoding == AngleEncoding::kDegU32 ? zero : 0;
}

}  // namespace

Expected<ToldAngle> tell_angle(AngleEncoding encoding, double zero, const SendRange& range,
                               double q) {
  const double limit = q < range.lower ? range.lower : range.upper;
  const Error outside{ErrorCode::kJointLimit, -1, q, limit};
  if (!range.holds(q)) return std::unexpected(outside);
  const double offset = offset_of(encoding, zero);
  const double wanted_deg = to_deg(q - offset);
  const double unit_deg = angle_unit_deg(encoding, wanted_deg);
  // The nearest may lie beyond a limit that is no whole unit; then its neighbour inside.
  const double inward = q > (range.lower + range.upper) / 2 ? -unit_deg : unit_deg;
  for (const double candidate_deg : {wanted_deg, wanted_deg + inward}) {
    const auto bytes = encode_angle(encoding, candidate_deg);
    if (!bytes) continue;
    const auto angle = told(encoding, offset, *bytes);
    if (angle && range.holds(angle->q)) return *angle;
  }
  return std::unexpected(outside);
}

std::optional<ToldAngle> read_angle(AngleEncoding encoding, double zero, const Data& data) {
  AngleBytes bytes{};
  if (data.size() != bytes.size()) return std::nullopt;
  std::copy_n(data.begin(), bytes.size(), bytes.begin());
  return told(encoding, offset_of(encoding, zero), bytes);
}

double same_target_tolerance(const ToldAngle& told) {
  return std::max(told.half_unit, kTargetTolerance);
}

double quickest_time(const Joint& joint, double distance) {
  const double v = joint.velocity_max;
  const double a = joint.acceleration_max;
  const double j = joint.jerk_max;
  const double d = std::abs(distance);
  // Peak speed of a move that never cruises, and from it whether it would be too fast.
  const double ramp = a / j;
  const bool full_ramp = d >= 2 * a * ramp * ramp;
  const double time = full_ramp ? ramp + std::sqrt(ramp * ramp + 4 * d / a) : std::cbrt(32 * d / j);
  const double peak = 2 * d / time;
  if (d == 0 || peak <= v) return d == 0 ? 0 : time;
  const double to_cruise = v * j >= a * a ? v / a + ramp : 2 * std::sqrt(v / j);
  return d / v + to_cruise;
}

std::optional<Error> fault_of(std::uint8_t number) {
  using enum ErrorCode;
  constexpr std::array kCodes{kFollowingError, kStalled,    kEncodersDisagree, kEncoderLost,
                              kEncoderLost,    kEndStop,    kHomingFailed,     kHomingFailed,
                              kSupplyFlag,     kOverheated, kLinkSilent,       kSelfTestFailed};
  if (number == 0) return std::nullopt;
  if (number > kCodes.size()) return Error{kUnexpectedReply, -1, 1.0 * number};
  return Error{kCodes[number - 1]};
}

}  // namespace sinew::axis_registers

namespace sinew {

std::optional<Error> AxisRegistersDevice::target_refusal(const RobotModel& robot,
                                                         std::span<const double> q,
                                                         std::span<const double> from) const {
  for (std::size_t i = 0; i < q.size(); ++i) {
    SendRange range = robot.joints[i];
    if (!from.empty()) range = range.from(from[i]);
    const auto told = axis_registers::tell_angle(encoding, boards[i].zero, range, q[i]);
    if (told) continue;
    Error error = told.error();
    error.index = static_cast<std::int8_t>(i);
    return error;
  }
  return std::nullopt;
}

}  // namespace sinew
