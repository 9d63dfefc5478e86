#include "sinew/kinematics/hexapod_linear.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "sinew/kinematics/leg_blocks.h"
#include "support/property.h"

namespace sinew::kinematics {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr TwistArray kAnyPivot{};

LegColumns columns_of(const Matrix6& matrix) {
  LegColumns columns;
  for (std::size_t k = 0; k < kTwistSize; ++k) {
    for (std::size_t i = 0; i < kLegs; ++i) {
      columns[k][i] = matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
    }
  }
  return columns;
}

/// Entries in [-1, 1], one in five of them zero, so that pivots have to be looked for.
Matrix6 random_matrix(test::Random& random) {
  Matrix6 matrix;
  for (double& entry : matrix.reshaped()) {
    entry = random.chance(0.2) ? 0 : random.uniform(-1, 1);
  }
  return matrix;
}

TEST(LegLu, solves_what_can_be_solved) {
  int solved = 0;
  test::for_random_cases(100'000, [&](test::Random& random) {
    const Matrix6 matrix = random_matrix(random);
    LegLu lu;
    if (!lu.factor(columns_of(matrix), kAnyPivot)) return random.discard();
    Vector6 x_expected;
    for (double& entry : x_expected) entry = random.uniform(-1, 1);
    const Vector6 rhs = matrix * x_expected;
    LegLanes lanes;
    for (std::size_t i = 0; i < kLegs; ++i) lanes[i] = rhs(static_cast<Eigen::Index>(i));
    const TwistArray x = lu.solve(lanes);
    const Vector6 residual = matrix * Eigen::Map<const Vector6>(x.data()) - rhs;
    // Backward stable: the residual is small against the solution, whatever the condition.
    EXPECT_LT(residual.norm(), 1e-14 * (1 + Eigen::Map<const Vector6>(x.data()).norm()));
    ++solved;
  });
  EXPECT_GT(solved, 90'000);
}

TEST(LegBlocks, agrees_with_the_pivoted_solver_where_both_blocks_are_regular) {
  constexpr LegSplit kSplit{.first = {5, 0, 3}, .second = {1, 4, 2}};
  int solved = 0;
  test::for_random_cases(100'000, [&](test::Random& random) {
    const LegColumns columns = columns_of(random_matrix(random));
    LegBlocks blocks;
    LegLu lu;
    if (!blocks.factor(columns, kSplit, {0.1, 0.1}) || !lu.factor(columns, kAnyPivot))
      return random.discard();
    LegLanes rhs;
    for (double& value : rhs.lane) value = random.uniform(-1, 1);
    const TwistArray x = blocks.solve(rhs);
    const TwistArray x_expected = lu.solve(rhs);
    for (std::size_t k = 0; k < kTwistSize; ++k) ASSERT_NEAR(x[k], x_expected[k], 1e-10);
    ++solved;
  });
  EXPECT_GT(solved, 50'000);
}

TEST(LegBlocks, block_without_a_volume_is_refused) {
  // Legs 0, 2 and 4 are parallel: the matrix is regular, but its first block is not.
  LegColumns columns;
  for (std::size_t i = 0; i < kLegs; ++i) columns[2][i] = 1;
  columns[3] = {{0, 0, 1, 0, 0, 0}};
  columns[4] = {{0, 0, 0, 0, 1, 0}};
  columns[0] = {{0, 1, 0, 0, 0, 0}};
  columns[1] = {{0, 0, 0, 1, 0, 0}};
  columns[5] = {{0, 0, 0, 0, 0, 1}};
  LegBlocks blocks;
  EXPECT_FALSE(blocks.factor(columns, {}, {1e-4, 1e-4}));
  EXPECT_TRUE(blocks.factor(columns, {.first = {0, 1, 3}, .second = {2, 4, 5}}, {1e-4, 1e-4}));
}

TEST(LegLu, rows_in_any_order_have_their_pivots_found) {
  // A permutation has exactly one usable pivot per column.
  std::array<std::size_t, kLegs> order{3, 0, 5, 1, 2, 4};
  LegColumns columns;
  for (std::size_t k = 0; k < kTwistSize; ++k) columns[k][order[k]] = 2;
  LegLu lu;
  ASSERT_TRUE(lu.factor(columns, kAnyPivot));
  const TwistArray x = lu.solve(LegLanes{{0, 1, 2, 3, 4, 5}});
  for (std::size_t k = 0; k < kTwistSize; ++k) {
    EXPECT_EQ(x[k], 0.5 * static_cast<double>(order[k]));
  }
}

TEST(LegLu, singular_matrix_is_refused) {
  constexpr TwistArray kPivots{1e-12, 1e-12, 1e-12, 1e-12, 1e-12, 1e-12};
  test::for_random_cases(10'000, [&](test::Random& random) {
    Matrix6 matrix = random_matrix(random);
    const Eigen::Index column = random.integer(1, 5);
    matrix.col(column) = 0.5 * matrix.col(column - 1);
    LegLu lu;
    EXPECT_FALSE(lu.factor(columns_of(matrix), kPivots));
    matrix.col(3).setConstant(std::nan(""));
    EXPECT_FALSE(lu.factor(columns_of(matrix), kPivots));
  });
}

TEST(SingularRange, agrees_with_eigen) {
  test::for_random_cases(20'000, [](test::Random& random) {
    const Matrix6 matrix = random_matrix(random);
    const SingularRange range = singular_range(columns_of(matrix));
    const Vector6 expected = Eigen::JacobiSVD<Matrix6>(matrix).singularValues();
    EXPECT_NEAR(range.max, expected(0), 1e-14 * expected(0));
    EXPECT_NEAR(range.min, expected(5), 1e-14 * expected(0));
  });
}

TEST(SingularRange, keeps_a_value_that_squaring_would_lose) {
  test::for_random_cases(10'000, [](test::Random& random) {
    const double tiny = std::pow(10, random.uniform(-13, -8));
    Vector6 values;
    values << 1, 0.7, 0.5, 0.3, 0.2, tiny;
    const Eigen::JacobiSVD<Matrix6> full(random_matrix(random),
                                         Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Matrix6 matrix = full.matrixU() * values.asDiagonal() * full.matrixV().transpose();
    EXPECT_NEAR(singular_range(columns_of(matrix)).min, tiny, 1e-15);
  });
}

}  // namespace
}  // namespace sinew::kinematics
