#pragma once

#include <array>

#include "sinew/core/vec3.h"

namespace sinew {

/// A proper rotation as three columns: the axes of the rotated frame, seen from the outer one. @rt
struct Rotation {
  Vec3 x{1, 0, 0};
  Vec3 y{0, 1, 0};
  Vec3 z{0, 0, 1};

  constexpr Rotation transposed() const {
    return {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
  }

  friend constexpr bool operator==(const Rotation&, const Rotation&) = default;
};

constexpr Vec3 operator*(const Rotation& R, const Vec3& v) {
  return {R.x.x * v.x + R.y.x * v.y + R.z.x * v.z, R.x.y * v.x + R.y.y * v.y + R.z.y * v.z,
          R.x.z * v.x + R.y.z * v.y + R.z.z * v.z};
}
constexpr Rotation operator*(const Rotation& A, const Rotation& B) {
  return {A * B.x, A * B.y, A * B.z};
}
/// A^T v without forming the transpose.
constexpr Vec3 transposed_times(const Rotation& A, const Vec3& v) {
  return {dot(A.x, v), dot(A.y, v), dot(A.z, v)};
}

Rotation rotation_x(double angle_rad);
Rotation rotation_y(double angle_rad);
Rotation rotation_z(double angle_rad);

/// Rotation by |w| rad about w (exponential map); exact down to w = 0.
Rotation rotation_from_vector(const Vec3& w_rad);

/// Rotation vector in rad, |w| <= pi (logarithm). Good to 1e-9 rad everywhere, at pi too, where
/// the sign of the axis is free.
Vec3 rotation_vector(const Rotation& R);

/// Angle in rad, 0..pi, between two orientations.
double angle_between(const Rotation& A, const Rotation& B);

/// Roll, pitch, yaw about the fixed axes x, then y, then z: R = Rz(yaw) Ry(pitch) Rx(roll).
Rotation rotation_from_fixed_xyz(const Vec3& rpy_rad);

/// Inverse of the above, pitch in [-pi/2, pi/2]. At |pitch| = pi/2 roll is set to 0.
Vec3 fixed_xyz(const Rotation& R);

/// Unit quaternion, order w x y z, w >= 0.
std::array<double, 4> quaternion_wxyz(const Rotation& R);

/// @param wxyz unit quaternion, either sign.
Rotation rotation_from_quaternion(const std::array<double, 4>& wxyz);

}  // namespace sinew
