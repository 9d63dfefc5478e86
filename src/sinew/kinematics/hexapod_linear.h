#pragma once

#include <array>
#include <cstddef>

#include "sinew/model/robot_model.h"

namespace sinew::kinematics {

/// One number per leg. Loops over all six become whole vectors of two lanes, which every 64-bit
/// processor has; padding to eight for wider ones makes those two thirds as fast.
struct alignas(16) LegLanes {
  std::array<double, kLegs> lane{};

  double& operator[](std::size_t i) { return lane[i]; }
  const double& operator[](std::size_t i) const { return lane[i]; }
};

inline constexpr std::size_t kTwistSize = 6;
using TwistArray = std::array<double, kTwistSize>;

/// A 6 x 6 matrix as six columns, a row per leg.
using LegColumns = std::array<LegLanes, kTwistSize>;

/// LU factorisation with partial pivoting of a 6 x 6 matrix, kept for several right-hand sides.
/// While it eliminates, rows stay where they are and each step is one pass over whole columns; the
/// triangles are put in the order of the pivots once, at the end. @rt
class LegLu {
 public:
  /// @param pivots_min  smallest pivot that counts as one, per column.
  /// @return            false where a pivot is smaller (or not a number): singular.
  bool factor(LegColumns matrix, const TwistArray& pivots_min);

  /// The x with matrix x = rhs; only after a factor() that returned true.
  TwistArray solve(const LegLanes& rhs) const;

 private:
  LegColumns triangles_;  ///< by column: above the diagonal U, below it L, whose diagonal is 1
  TwistArray inverse_pivots_{};
  std::array<std::size_t, kTwistSize> rows_{};  ///< row of the k-th pivot
};

/// Singular values of a 6 x 6 matrix, largest and smallest.
struct SingularRange {
  double max = 0;
  double min = 0;
};

/// One-sided Jacobi rotations (Hestenes 1958): small singular values come out as exactly as large
/// ones, which the eigenvalues of the matrix times its transpose would lose below 1e-8.
/// Good to 1e-14 of the largest value. @rt
SingularRange singular_range(LegColumns matrix);

}  // namespace sinew::kinematics
