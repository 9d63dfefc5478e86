#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "sinew/core/units.h"

namespace sinew {

/// Branch-free sine, cosine and arc tangent. Sines and arc tangents are most of what kinematics
/// costs; without branches and calls the compiler keeps several in flight or in one vector, two to
/// four times faster than the C library. trig_test.cc holds them against it.

struct SinCos {
  double sin;
  double cos;
};

/// Largest |angle| in rad for which the functions below keep their promise; more than 1e5 turns,
/// so no joint gets there. Beyond it (and for NaN) the result is only finite or NaN, never a trap.
inline constexpr double kSinCosRange = 1e6;

namespace detail {

/// Adding this rounds to an integer and leaves that integer in the low bits of the sum.
inline constexpr double kRoundToInteger = 0x1.8p52;

/// n pi/2 in three parts of 33 bits each, so that n times a part is exact for |n| < 2^20
/// (W. Cody, W. Waite, Software Manual for the Elementary Functions, 1980).
inline constexpr double kHalfPiHigh = 0x1.921fb544p0;
inline constexpr double kHalfPiMiddle = 0x1.0b4611a6p-34;
inline constexpr double kHalfPiLow = 0x1.3198a2e037073p-69;

}  // namespace detail

/// sin and cos of an angle in rad, |angle| <= kSinCosRange; absolute error <= 2.3e-16. @rt
inline SinCos sin_cos(double angle) {
  const double shifted = angle * (2 / kPi) + detail::kRoundToInteger;
  const double n = shifted - detail::kRoundToInteger;
  const auto quadrant = std::bit_cast<std::uint64_t>(shifted);
  double r = angle - n * detail::kHalfPiHigh;
  r -= n * detail::kHalfPiMiddle;
  r -= n * detail::kHalfPiLow;

  // Taylor series on |r| <= pi/4: the first term left out is below 5e-17.
  const double z = r * r;
  const double z2 = z * z;
  const double z4 = z2 * z2;
  const double sin_low = (-1.0 / 6 + z * (1.0 / 120)) + z2 * (-1.0 / 5040 + z * (1.0 / 362880));
  const double sin_high = (-1.0 / 39916800 + z * (1.0 / 6227020800)) + z2 * (-1.0 / 1307674368000);
  const double sin_r = r + r * z * (sin_low + z4 * sin_high);
  const double cos_low = (1.0 / 24 + z * (-1.0 / 720)) + z2 * (1.0 / 40320 + z * (-1.0 / 3628800));
  const double cos_high =
      (1.0 / 479001600 + z * (-1.0 / 87178291200)) + z2 * (1.0 / 20922789888000);
  const double cos_r = 1 - 0.5 * z + z2 * (cos_low + z4 * cos_high);

  // Odd quadrants swap sine and cosine; quadrants 2, 3 negate the sine and 1, 2 the cosine.
  const std::uint64_t swap = 0 - (quadrant & 1);
  const auto sin_bits = std::bit_cast<std::uint64_t>(sin_r);
  const auto cos_bits = std::bit_cast<std::uint64_t>(cos_r);
  const std::uint64_t differ = (sin_bits ^ cos_bits) & swap;
  const std::uint64_t sin_sign = (quadrant & 2) << 62;
  const std::uint64_t cos_sign = ((quadrant + 1) & 2) << 62;
  return {std::bit_cast<double>((sin_bits ^ differ) ^ sin_sign),
          std::bit_cast<double>((cos_bits ^ differ) ^ cos_sign)};
}

/// Angle in rad, (-pi, pi], of the vector (x, y); 0 for the zero vector; absolute error <= 5e-16.
/// Infinite components are outside its promise. @rt
inline double arc_tangent(double y, double x) {
  const double abs_x = std::abs(x);
  const double abs_y = std::abs(y);
  const double large = abs_x > abs_y ? abs_x : abs_y;
  const double small = abs_x > abs_y ? abs_y : abs_x;
  // Above tan(pi/8) the angle is measured from pi/4, so that one short polynomial serves.
  const bool upper = small > large * 0.41421356237309503;
  const double numerator = upper ? small - large : small;
  const double denominator = (upper ? small + large : large) + 0x1p-1000;
  const double u = numerator / denominator;

  // atan(u) = u + u z p(z), z = u^2 <= tan^2(pi/8); p by Remez exchange, error below 8e-18.
  const double z = u * u;
  const double z2 = z * z;
  const double z4 = z2 * z2;
  const double p01 = -0.33333333333325189709 + z * 0.19999999998183237891;
  const double p23 = -0.14285714133662009519 + z * 0.11111104506376420013;
  const double p45 = -0.090907388663658964489 + z * 0.076895246500992029105;
  const double p67 = -0.066368825454249943187 + z * 0.056724240403078864107;
  const double p89 = -0.043059387942766474958 + z * 0.020660006131645017764;
  const double p = (p01 + z2 * p23) + z4 * ((p45 + z2 * p67) + z4 * p89);
  double angle = u + u * z * p;

  angle = upper ? kPi / 4 + angle : angle;
  angle = abs_y > abs_x ? kPi / 2 - angle : angle;
  angle = x < 0 ? kPi - angle : angle;
  return std::copysign(angle, y);
}

/// The same angle in [reference - pi, reference + pi], to rounding. @rt
inline double wrap_near(double angle, double reference) {
  const double turns = (angle - reference) * (0.5 / kPi);
  const double whole = (turns + detail::kRoundToInteger) - detail::kRoundToInteger;
  return angle - whole * (2 * kPi);
}

}  // namespace sinew
