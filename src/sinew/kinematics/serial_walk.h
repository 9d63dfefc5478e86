#pragma once

#include <array>

#include "sinew/core/pose.h"
#include "sinew/core/trig.h"
#include "sinew/model/robot_model.h"

namespace sinew::kinematics {

/// Three numbers in a vector of four. Only for the version with wide vectors: where compilers have
/// to take it apart it is five times slower than a Vec3.
using Column = double __attribute__((vector_size(32)));

inline Vec3 vec3(const Vec3& v) {
  return v;
}
inline Vec3 vec3(const Column& v) {
  return {v[0], v[1], v[2]};
}

/// One row of a DH table with what never changes folded.
struct SerialLink {
  double d = 0, a = 0, cos_alpha = 1, sin_alpha = 0;
};

/// Frame i of a chain in its base while the chain is walked: axes and origin, each a Vec3 or
/// Column.
template <class V>
struct WalkFrame {
  V x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, p{0, 0, 0};

  /// Passes one link, whose joint stands at the angle of s and c: docs/kinematics/serial.md, (1).
  void pass(const SerialLink& link, double s, double c) {
    const V x_turned = c * x + s * y;
    const V y_turned = c * y - s * x;
    p = p + link.d * z + link.a * x_turned;
    x = x_turned;
    y = link.cos_alpha * y_turned + link.sin_alpha * z;
    z = link.cos_alpha * z - link.sin_alpha * y_turned;
  }
};

/// Sines and cosines of q[i] + offset[i], i < n, always in pairs so that joints share a vector.
template <std::size_t N>
void sines(const double* q, const std::array<double, N>& offset, std::size_t n,
           std::array<double, N>& s, std::array<double, N>& c) {
  static_assert(N % 2 == 0);
  std::array<double, N> theta{};
  for (std::size_t i = 0; i < n; ++i) theta[i] = q[i] + offset[i];
  for (std::size_t i = 0; i < n; i += 2) {
    for (std::size_t lane = i; lane < i + 2; ++lane) {
      const SinCos sc = sin_cos(theta[lane]);
      s[lane] = sc.sin;
      c[lane] = sc.cos;
    }
  }
}

}  // namespace sinew::kinematics
