#include "sinew/control/position_evidence.h"

#include <gtest/gtest.h>

#include <array>

namespace sinew::control {
namespace {

using Source = Evidence::Source;

constexpr JointPosition at(double q) {
  return {PositionQuality::kCommanded, q, q, q};
}

TEST(PositionEvidence, narrows_what_is_said_by_everything_that_is_known) {
  const std::array known{Evidence{Source::kRecord, {-1, 1}, 0},
                         Evidence{Source::kCounters, {0.2, 0.4}, 0.01}};
  const auto agreed = agree(0, known, {PositionQuality::kUncertain, 0.5, 0.3, 2});
  ASSERT_TRUE(agreed);
  EXPECT_DOUBLE_EQ(agreed->lower, 0.3);
  EXPECT_DOUBLE_EQ(agreed->upper, 0.41);
}

TEST(PositionEvidence, names_both_numbers_of_a_contradiction) {
  const std::array counted{Evidence{Source::kRecord, {-1.05, 1.05}, 0},
                           Evidence{Source::kCounters, {-1.03, -1.01}, 0}};
  EXPECT_EQ(agree(2, counted, at(0)).error(), (Error{ErrorCode::kCountedElsewhere, 2, 0, -1.02}));
  const std::array recorded{Evidence{Source::kRecord, {-1, 1}, 0.1}};
  EXPECT_EQ(agree(1, recorded, at(1.2)).error(), (Error{ErrorCode::kDeclaredElsewhere, 1, 1.2, 1}));
  EXPECT_TRUE(agree(1, recorded, at(1.1)));
}

TEST(PositionEvidence, without_any_what_is_said_counts) {
  const auto agreed = agree(0, {}, at(0.7));
  ASSERT_TRUE(agreed);
  EXPECT_EQ(*agreed, (JointInterval{0.7, 0.7}));
}

}  // namespace
}  // namespace sinew::control
