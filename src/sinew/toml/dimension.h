#pragma once

#include <span>
#include <string_view>

#include "sinew/core/units.h"

namespace sinew {

/// A unit as people write it into a key's name.
struct Unit {
  std::string_view name;  ///< in the key: "deg_s2"
  std::string_view text;  ///< in a sentence: "deg/s^2"
  double to_si = 1;       ///< value in SI or radians = written value * to_si
};

/// The units that one kind of quantity may be written in.
using Dimension = std::span<const Unit>;

inline constexpr double kInch = 0.0254;  // m, exact by definition
inline constexpr double kDegree = from_deg(1);
inline constexpr double kMillimetre = from_mm(1);

inline constexpr Unit kLength[] = {{"mm", "mm", kMillimetre}, {"m", "m", 1}, {"in", "in", kInch}};
inline constexpr Unit kLengthRate[] = {{"mm_s", "mm/s", kMillimetre}, {"m_s", "m/s", 1}};
inline constexpr Unit kLengthRate2[] = {{"mm_s2", "mm/s^2", kMillimetre}, {"m_s2", "m/s^2", 1}};
inline constexpr Unit kLengthRate3[] = {{"mm_s3", "mm/s^3", kMillimetre}, {"m_s3", "m/s^3", 1}};
inline constexpr Unit kAngle[] = {{"deg", "deg", kDegree}, {"rad", "rad", 1}};
inline constexpr Unit kAngleRate[] = {{"deg_s", "deg/s", kDegree}, {"rad_s", "rad/s", 1}};
inline constexpr Unit kAngleRate2[] = {{"deg_s2", "deg/s^2", kDegree}, {"rad_s2", "rad/s^2", 1}};
inline constexpr Unit kAngleRate3[] = {{"deg_s3", "deg/s^3", kDegree}, {"rad_s3", "rad/s^3", 1}};
/// "per turn" is the exact one: step counts of geared joints are whole numbers there.
inline constexpr Unit kPerAngle[] = {{"turn", "steps per turn", 1 / (2 * kPi)},
                                     {"deg", "steps per deg", 180 / kPi},
                                     {"rad", "steps per rad", 1}};
inline constexpr Unit kPerLength[] = {{"mm", "steps per mm", 1000}, {"m", "steps per m", 1}};
inline constexpr Unit kTorque[] = {{"nm", "Nm", 1}, {"ncm", "Ncm", 0.01}};
inline constexpr Unit kTorquePerRate[] = {{"nms_rad", "Nm s/rad", 1}};
inline constexpr Unit kForce[] = {{"n", "N", 1}};
inline constexpr Unit kForcePerRate[] = {{"ns_m", "N s/m", 1}};
inline constexpr Unit kInertia[] = {{"kgm2", "kg m^2", 1}, {"gcm2", "g cm^2", 1e-7}};
inline constexpr Unit kMass[] = {{"kg", "kg", 1}, {"g", "g", 1e-3}};
inline constexpr Unit kTurnRate[] = {{"rpm", "rpm", 2 * kPi / 60}, {"rad_s", "rad/s", 1}};
inline constexpr Unit kPerTime[] = {{"per_s", "1/s", 1}};
/// A number without a unit; its key carries none.
inline constexpr Unit kPlain{"", "", 1};

/// What a value may be, in SI.
struct Range {
  double lower = 0;
  double upper = 0;
  bool lower_excluded = false;
};

constexpr Range between(double lower, double upper) {
  return {lower, upper};
}
constexpr Range above_zero_to(double upper) {
  return {0, upper, true};
}

}  // namespace sinew
