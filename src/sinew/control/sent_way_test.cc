#include "sinew/control/sent_way.h"

#include <gtest/gtest.h>

#include <vector>

namespace sinew::control {
namespace {

constexpr double kOpen = 14e-6;  // m

/// What a piece of 1 um needs that begins at rest at 0.2 m.
JointInterval reach(PositionQuality quality, bool under_way = false) {
  const std::vector<motion::AxisLimits> limits(1, {1e-3, 1e-4, 1e-3});
  SentWay sent(limits);
  const std::vector<double> start{0.2};
  sent.rest(start);
  JointMove piece{.q = {}, .qd = {}, .duration = std::chrono::milliseconds(100)};
  piece.q.push_back(0.2 + 1e-6);
  const JointPosition now{quality, 0.2, 0.2 - kOpen, 0.2 + kOpen, std::nullopt, under_way};
  return sent.with(std::span(&now, 1), piece)[0];
}

TEST(SentWay, what_is_open_about_a_joint_goes_along_with_it) {
  for (const auto quality : {PositionQuality::kCommanded, PositionQuality::kUncertain}) {
    EXPECT_NEAR(reach(quality).upper, 0.2 + 1e-6 + kOpen, 1e-12);
    EXPECT_NEAR(reach(quality).lower, 0.2 - kOpen, 1e-12);
  }
}

TEST(SentWay, what_is_measured_is_measured_again_on_the_way) {
  EXPECT_NEAR(reach(PositionQuality::kMeasured).upper, 0.2 + kOpen, 1e-12);
}

TEST(SentWay, what_is_open_along_the_way_moves_none_of_what_follows) {
  EXPECT_NEAR(reach(PositionQuality::kCommanded, true).upper, 0.2 + kOpen, 1e-12);
  EXPECT_NEAR(reach(PositionQuality::kCommanded, true).lower, 0.2 - kOpen, 1e-12);
}

}  // namespace
}  // namespace sinew::control
