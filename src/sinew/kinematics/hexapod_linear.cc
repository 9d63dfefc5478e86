#include "sinew/kinematics/hexapod_linear.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/core/unrolled.h"

namespace sinew::kinematics {
namespace {

/// Sweeps of Jacobi rotations; 6 are enough for any 6 x 6 matrix seen, convergence is quadratic.
constexpr int kSweepsMax = 12;
/// Columns whose cosine is below this are orthogonal.
constexpr double kOrthogonal = 1e-15;

double dot_lanes(const LegLanes& a, const LegLanes& b) {
  return (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]) + (a[4] * b[4] + a[5] * b[5]);
}

/// Turns two columns in their plane until they are orthogonal; false where they already were.
bool orthogonalise(LegLanes& a, LegLanes& b) {
  const double aa = dot_lanes(a, a);
  const double bb = dot_lanes(b, b);
  const double ab = dot_lanes(a, b);
  if (!(std::abs(ab) > kOrthogonal * std::sqrt(aa * bb))) return false;
  const double zeta = (bb - aa) / (2 * ab);
  const double t = std::copysign(1.0, zeta) / (std::abs(zeta) + std::sqrt(1 + zeta * zeta));
  const double c = 1 / std::sqrt(1 + t * t);
  const double s = c * t;
  for (std::size_t i = 0; i < kLegs; ++i) {
    const double a_old = a[i];
    a[i] = c * a_old - s * b[i];
    b[i] = s * a_old + c * b[i];
  }
  return true;
}

}  // namespace

bool LegLu::factor(LegColumns matrix, const TwistArray& pivots_min) {
  rows_ = {0, 1, 2, 3, 4, 5};
  LegLanes is_free{{1, 1, 1, 1, 1, 1}};
  LegColumns factors;
  for (std::size_t k = 0; k < kTwistSize; ++k) {
    std::size_t best = k;
    double largest = -1;
    for (std::size_t i = k; i < kTwistSize; ++i) {
      const double size = std::abs(matrix[k][rows_[i]]);
      best = size > largest ? i : best;
      largest = size > largest ? size : largest;
    }
    if (!(largest > pivots_min[k])) return false;
    std::swap(rows_[k], rows_[best]);
    const std::size_t row = rows_[k];
    is_free[row] = 0;
    inverse_pivots_[k] = 1 / matrix[k][row];
    for (std::size_t i = 0; i < kLegs; ++i) {
      factors[k][i] = matrix[k][i] * inverse_pivots_[k] * is_free[i];
    }
    for (std::size_t j = k + 1; j < kTwistSize; ++j) {
      const double pivot_element = matrix[j][row];
      for (std::size_t i = 0; i < kLegs; ++i) matrix[j][i] -= pivot_element * factors[k][i];
    }
  }
  for (std::size_t k = 0; k < kTwistSize; ++k) {
    for (std::size_t i = 0; i < k; ++i) triangles_[k][i] = matrix[k][rows_[i]];
    for (std::size_t i = k + 1; i < kTwistSize; ++i) triangles_[k][i] = factors[k][rows_[i]];
  }
  return true;
}

TwistArray LegLu::solve(const LegLanes& rhs) const {
  TwistArray x;
  for (std::size_t i = 0; i < kTwistSize; ++i) x[i] = rhs[rows_[i]];
  unrolled<kTwistSize>([&](auto k) {
    unrolled<kTwistSize - 1 - k>([&](auto i) { x[k + 1 + i] -= x[k] * triangles_[k][k + 1 + i]; });
  });
  unrolled<kTwistSize>([&](auto step) {
    const std::size_t k = kTwistSize - 1 - step;
    x[k] *= inverse_pivots_[k];
    unrolled<k>([&](auto i) { x[i] -= x[k] * triangles_[k][i]; });
  });
  return x;
}

SingularRange singular_range(LegColumns matrix) {
  for (int sweep = 0; sweep < kSweepsMax; ++sweep) {
    bool turned = false;
    for (std::size_t a = 0; a + 1 < kTwistSize; ++a) {
      for (std::size_t b = a + 1; b < kTwistSize; ++b) {
        turned |= orthogonalise(matrix[a], matrix[b]);
      }
    }
    if (!turned) break;
  }
  SingularRange range{0, INFINITY};
  for (const LegLanes& column : matrix) {
    const double value = std::sqrt(dot_lanes(column, column));
    // In this order of arguments a column that is not a number is not passed over.
    range = {std::max(value, range.max), std::min(value, range.min)};
  }
  return range;
}

}  // namespace sinew::kinematics
