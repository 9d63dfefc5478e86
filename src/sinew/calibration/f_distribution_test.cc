#include "sinew/calibration/f_distribution.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::calibration {
namespace {

TEST(FDistribution, quantiles_are_those_of_printed_tables) {
  EXPECT_NEAR(f_quantile(0.95, 3, 3), 9.2766, 1e-3);
  EXPECT_NEAR(f_quantile(0.95, 1, 10), 4.9646, 1e-3);
  EXPECT_NEAR(f_quantile(0.99, 3, 12), 5.9525, 1e-3);
  EXPECT_NEAR(f_quantile(0.95, 2, 4), 6.9443, 1e-3);
  EXPECT_NEAR(f_quantile(0.5, 7, 7), 1, 1e-9);
}

TEST(FDistribution, quantile_of_the_other_tail_is_the_reciprocal) {
  for (const double freedom : {0.7, 1.4, 3.0, 9.0}) {
    for (const double estimate : {1.0, 3.0, 30.0}) {
      const double product =
          f_quantile(0.95, freedom, estimate) * f_quantile(0.05, estimate, freedom);
      EXPECT_NEAR(product, 1, 1e-6) << freedom << " " << estimate;
    }
  }
}

TEST(FDistribution, many_residuals_give_the_normal_distribution) {
  EXPECT_NEAR(std::sqrt(f_quantile(0.95, 1, 1e6)), 1.95996, 1e-4);
}

}  // namespace
}  // namespace sinew::calibration
