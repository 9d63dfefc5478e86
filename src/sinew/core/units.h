#pragma once

#include <limits>
#include <numbers>

namespace sinew {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Inside Sinew everything is SI and radians; these are the only doors from and to people's units.
constexpr double from_deg(double angle_deg) {
  return angle_deg * (kPi / 180.0);
}
constexpr double to_deg(double angle_rad) {
  return angle_rad * (180.0 / kPi);
}
constexpr double from_mm(double length_mm) {
  return length_mm * 1e-3;
}
constexpr double to_mm(double length_m) {
  return length_m * 1e3;
}

}  // namespace sinew
