#include "sinew/devices/maxarm/maxarm_device_ik.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"

namespace sinew::maxarm {
namespace {

constexpr double kPulsesPerDeg = 1000.0 / 240;
constexpr double kTooHigh = 225;  // mm, the MicroPython program's ceiling

struct FirmwareAngles {
  double a1 = 0;  ///< deg, all three
  double a2 = 0;
  double a3 = 0;
};

/// Not a number in a2 and a3 where the point is out of reach, as in the original.
FirmwareAngles angles_of(const PalletizerGeometry& geometry, double x, double y, double z) {
  double theta = to_deg(std::atan2(y, -x));
  while (theta <= 30) theta += 360;
  const double r = std::hypot(x, y) - to_mm(geometry.shoulder_offset) - to_mm(geometry.tool_offset);
  const double h = z - to_mm(geometry.base_height);
  const double upper = to_mm(geometry.upper_arm);
  const double fore = to_mm(geometry.forearm);
  const double d2 = r * r + h * h;
  const double beta = std::acos((upper * upper + fore * fore - d2) / (2 * upper * fore));
  const double gamma = std::acos((upper * upper + d2 - fore * fore) / (2 * upper * std::sqrt(d2)));
  const double alpha = std::atan(h / r);
  return {theta - 150, 180 - to_deg(alpha + gamma), 180 - to_deg(alpha + beta + gamma)};
}

/// Cut as the original cuts; not a number becomes 0 on its chip.
std::int32_t cut(double pulse) {
  return std::isfinite(pulse) ? static_cast<std::int32_t>(pulse) : 0;
}

bool servo_can(double angle) {
  return angle >= 0 && angle <= 240;
}

std::int16_t whole_mm(double mm) {
  return static_cast<std::int16_t>(std::clamp(mm, -32768.0, 32767.0));
}

}  // namespace

std::optional<ServoPulses> firmware_pulses(const PalletizerGeometry& geometry,
                                           MaxArmVariant variant,
                                           const std::array<std::int16_t, 3>& xyz_mm) {
  const double x = xyz_mm[0];
  const double y = xyz_mm[1];
  if (std::hypot(x, y) < to_mm(geometry.radius_min)) return std::nullopt;
  const bool python = variant == MaxArmVariant::kMicroPython;
  const double z = python ? std::min(1.0 * xyz_mm[2], kTooHigh) : xyz_mm[2];
  const FirmwareAngles a = angles_of(geometry, x, y, z);
  // Written so that what is not a number is refused too.
  if (python && !(servo_can(a.a1) && servo_can(a.a2) && servo_can(a.a3))) return std::nullopt;
  return ServoPulses{cut(a.a1 * kPulsesPerDeg), cut((210 - a.a2) * kPulsesPerDeg),
                     cut((a.a3 + 120) * kPulsesPerDeg)};
}

std::array<std::int16_t, 3> firmware_xyz(const PalletizerGeometry& geometry, MaxArmVariant variant,
                                         const std::array<std::int16_t, 3>& pulses) {
  const double a1 = pulses[0] / kPulsesPerDeg;
  const double a2 = from_deg(210 - pulses[1] / kPulsesPerDeg);
  const double a3 = from_deg(pulses[2] / kPulsesPerDeg - 120);
  const double b = from_deg(120 - a1);
  const double r = to_mm(geometry.shoulder_offset - geometry.upper_arm * std::cos(a2) +
                         geometry.forearm * std::cos(a3) + geometry.tool_offset);
  const double z = to_mm(geometry.base_height + geometry.upper_arm * std::sin(a2) -
                         geometry.forearm * std::sin(a3));
  const double x = r * std::sin(b);
  const double y = -r * std::cos(b);
  if (variant == MaxArmVariant::kArduino) return {whole_mm(x), whole_mm(y), whole_mm(z)};
  // Its x axis points the other way until the very end.
  return {whole_mm(-std::trunc(0.5 - x)), whole_mm(y + 0.5), whole_mm(z + 0.5)};
}

}  // namespace sinew::maxarm
