#include "sinew/control/position_evidence.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "sinew/control/journal_record.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/model/left_out.h"
#include "support/robots.h"

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

TEST(PositionEvidence, what_is_shown_is_the_middle_of_an_interval_that_a_person_can_see) {
  const RobotModel robot = sinew::test::robot("bigrobotarm");
  JournalPositions known(std::vector<JointPosition>(
      5, {PositionQuality::kUncertain, 0.1, 0.1 - from_deg(1), 0.1 + from_deg(1.5)}));
  const auto shown = as_shown(robot, {known.data(), known.size()});
  ASSERT_TRUE(shown);
  EXPECT_EQ((*shown)[2].quality, PositionQuality::kCommanded);
  EXPECT_NEAR((*shown)[2].q, 0.1 + from_deg(0.25), 1e-12);
  EXPECT_EQ((*shown)[2].upper, known[2].upper) << "the interval stays";
  known[3].upper += from_deg(2);
  EXPECT_EQ(as_shown(robot, {known.data(), known.size()}).error(),
            (Error{ErrorCode::kPositionUnknown, 3}));
  // Of a lost joint what the last record says.
  const JournalPositions said(std::vector<JointPosition>(5, at(0.3)));
  known[3] = {};
  EXPECT_FALSE(as_shown(robot, {known.data(), known.size()}));
  const auto last = as_shown(robot, {known.data(), known.size()}, {said.data(), said.size()});
  ASSERT_TRUE(last);
  EXPECT_EQ((*last)[3].q, 0.3);
}

TEST(PositionEvidence, what_is_shown_is_taken_without_a_joint_that_is_left_out) {
  RobotModel robot = sinew::test::robot("robot-arm-2");
  std::vector<JointPosition> known(robot.joints.size(),
                                   {PositionQuality::kUncertain, 0.1, 0.09, 0.11});
  known[2] = {};
  const auto refused = as_shown(robot, known, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error(), (Error{ErrorCode::kPositionUnknown, 2}));
  robot.device.settings.get<AxisRegistersDevice>().boards[2].homing_place = kLeftOut;
  const auto shown = as_shown(robot, known, {});
  ASSERT_TRUE(shown);
  for (std::size_t j = 0; j < shown->size(); ++j) {
    EXPECT_EQ((*shown)[j].quality, j == 2 ? PositionQuality::kLost : PositionQuality::kCommanded);
  }
}

}  // namespace
}  // namespace sinew::control
