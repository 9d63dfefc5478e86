#include "sinew/core/rotation.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"

namespace sinew {

Rotation rotation_x(double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return {{1, 0, 0}, {0, c, s}, {0, -s, c}};
}

Rotation rotation_y(double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return {{c, 0, -s}, {0, 1, 0}, {s, 0, c}};
}

Rotation rotation_z(double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return {{c, s, 0}, {-s, c, 0}, {0, 0, 1}};
}

Rotation rotation_from_vector(const Vec3& w_rad) {
  const double angle_squared = dot(w_rad, w_rad);
  const double angle = std::sqrt(angle_squared);
  // Rodrigues: R = I + a [w] + b [w]^2 with a = sin(t)/t, b = (1 - cos t)/t^2; series near 0.
  const bool small = angle < 1e-4;
  const double a = small ? 1 - angle_squared / 6 : std::sin(angle) / angle;
  const double half = std::sin(angle / 2);
  const double b = small ? 0.5 - angle_squared / 24 : 2 * half * half / angle_squared;
  const auto& [x, y, z] = w_rad;
  return {{1 - b * (y * y + z * z), b * x * y + a * z, b * x * z - a * y},
          {b * x * y - a * z, 1 - b * (x * x + z * z), b * y * z + a * x},
          {b * x * z + a * y, b * y * z - a * x, 1 - b * (x * x + y * y)}};
}

Vec3 rotation_vector(const Rotation& R) {
  const auto q = quaternion_wxyz(R);
  const Vec3 v{q[1], q[2], q[3]};
  const double s = norm(v);
  if (s < 1e-12) return 2.0 * v;
  return (2 * std::atan2(s, q[0]) / s) * v;
}

double angle_between(const Rotation& A, const Rotation& B) {
  return norm(rotation_vector(A.transposed() * B));
}

Rotation rotation_from_fixed_xyz(const Vec3& rpy_rad) {
  return rotation_z(rpy_rad.z) * rotation_y(rpy_rad.y) * rotation_x(rpy_rad.x);
}

Vec3 fixed_xyz(const Rotation& R) {
  const double cos_pitch = std::hypot(R.x.x, R.x.y);
  const double pitch = std::atan2(-R.x.z, cos_pitch);
  if (cos_pitch < 1e-12) return {0, pitch, std::atan2(-R.y.x, R.y.y)};
  return {std::atan2(R.y.z, R.z.z), pitch, std::atan2(R.x.y, R.x.x)};
}

std::array<double, 4> quaternion_wxyz(const Rotation& R) {
  // The largest of the four components is computed from the diagonal, the others from it: no
  // cancellation anywhere (Shepperd, 1978).
  const double w2 = 1 + R.x.x + R.y.y + R.z.z;
  const double x2 = 1 + R.x.x - R.y.y - R.z.z;
  const double y2 = 1 - R.x.x + R.y.y - R.z.z;
  const double z2 = 1 - R.x.x - R.y.y + R.z.z;
  const double wx = R.y.z - R.z.y;
  const double wy = R.z.x - R.x.z;
  const double wz = R.x.y - R.y.x;
  const double xy = R.y.x + R.x.y;
  const double xz = R.z.x + R.x.z;
  const double yz = R.z.y + R.y.z;
  std::array<double, 4> q{};
  const double largest = std::max({w2, x2, y2, z2});
  if (largest == w2) {
    q = {w2, wx, wy, wz};
  } else if (largest == x2) {
    q = {wx, x2, xy, xz};
  } else if (largest == y2) {
    q = {wy, xy, y2, yz};
  } else {
    q = {wz, xz, yz, z2};
  }
  const double scale = 0.5 / std::sqrt(largest) * (q[0] < 0 ? -1 : 1);
  for (double& component : q) component *= scale;
  return q;
}

Rotation rotation_from_quaternion(const std::array<double, 4>& wxyz) {
  const auto [w, x, y, z] = wxyz;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
          {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
          {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
}

}  // namespace sinew
