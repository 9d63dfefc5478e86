#pragma once

#include <cmath>

#include "sinew/core/vec3.h"
#include "sinew/kinematics/hexapod_linear.h"

namespace sinew::kinematics {

/// A 3 x 3 matrix as three rows.
struct Matrix3 {
  Vec3 row0, row1, row2;
};

inline Vec3 operator*(const Matrix3& A, const Vec3& v) {
  return {dot(A.row0, v), dot(A.row1, v), dot(A.row2, v)};
}

/// Three legs whose directions hold a platform's translation, and the other three.
struct LegSplit {
  std::array<std::size_t, 3> first{0, 2, 4};
  std::array<std::size_t, 3> second{1, 3, 5};
};

/// Solves with the 6 x 6 matrix of a platform's legs by elimination of 3 x 3 blocks: three legs
/// give the translation, the others the rotation that is left. No pivot is searched, so it takes a
/// third of LegLu's time, and it has an answer only while both blocks are far from singular.
///
/// Source: Schur complement, with the inverse of a 3 x 3 matrix by cross products. @rt
class LegBlocks {
 public:
  /// @param gradient         columns 0 to 2 directions, 3 to 5 moments of the legs.
  /// @param determinant_min  of each block; a smaller one counts as singular.
  /// @return                 false where a block is (close to) singular.
  bool factor(const LegColumns& gradient, const LegSplit& split,
              const std::array<double, 2>& determinant_min) {
    const auto& [first, second] = split_ = split;
    const auto direction = [&](std::size_t leg) {
      return Vec3{gradient[0][leg], gradient[1][leg], gradient[2][leg]};
    };
    const auto moment = [&](std::size_t leg) {
      return Vec3{gradient[3][leg], gradient[4][leg], gradient[5][leg]};
    };
    const Matrix3 A{direction(first[0]), direction(first[1]), direction(first[2])};
    if (!invert(A, determinant_min[0], inverse_first_)) return false;
    const Matrix3 W{moment(first[0]), moment(first[1]), moment(first[2])};
    directions_ = {direction(second[0]), direction(second[1]), direction(second[2])};
    per_rotation_ = product(inverse_first_, W);
    const Matrix3 rest{moment(second[0]) - row_times(directions_.row0, per_rotation_),
                       moment(second[1]) - row_times(directions_.row1, per_rotation_),
                       moment(second[2]) - row_times(directions_.row2, per_rotation_)};
    return invert(rest, determinant_min[1], inverse_rest_);
  }

  /// The x with matrix x = rhs; only after a factor() that returned true.
  TwistArray solve(const LegLanes& rhs) const {
    const auto& [first, second] = split_;
    const Vec3 held = inverse_first_ * Vec3{rhs[first[0]], rhs[first[1]], rhs[first[2]]};
    const Vec3 rest = Vec3{rhs[second[0]], rhs[second[1]], rhs[second[2]]} - directions_ * held;
    const Vec3 w = inverse_rest_ * rest;
    const Vec3 v = held - per_rotation_ * w;
    return {v.x, v.y, v.z, w.x, w.y, w.z};
  }

 private:
  static Vec3 row_times(const Vec3& row, const Matrix3& B) {
    return row.x * B.row0 + row.y * B.row1 + row.z * B.row2;
  }
  static Matrix3 product(const Matrix3& A, const Matrix3& B) {
    return {row_times(A.row0, B), row_times(A.row1, B), row_times(A.row2, B)};
  }
  static bool invert(const Matrix3& A, double determinant_min, Matrix3& inverse) {
    const Vec3 c0 = cross(A.row1, A.row2);
    const Vec3 c1 = cross(A.row2, A.row0);
    const Vec3 c2 = cross(A.row0, A.row1);
    const double determinant = dot(A.row0, c0);
    const double scale = 1 / determinant;
    inverse = {scale * Vec3{c0.x, c1.x, c2.x}, scale * Vec3{c0.y, c1.y, c2.y},
               scale * Vec3{c0.z, c1.z, c2.z}};
    return std::abs(determinant) > determinant_min;
  }

  LegSplit split_;
  Matrix3 inverse_first_;  ///< of the first legs' directions
  Matrix3 per_rotation_;   ///< translation of the first legs' common point, per rotation
  Matrix3 directions_;     ///< of the second legs
  Matrix3 inverse_rest_;
};

}  // namespace sinew::kinematics
