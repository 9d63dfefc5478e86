#include "sinew/runtime/position_record.h"

#include <gtest/gtest.h>

#include <vector>

#include "sinew/io/clock.h"
#include "sinew/io/scratch_folder_test_support.h"
#include "support/robots.h"

namespace sinew::runtime {
namespace {

TEST(PositionRecord, what_another_program_wrote_down_is_an_interval_that_somebody_has_to_verify) {
  const sinew::test::ScratchFolder folder;
  const RobotModel& hexapod = sinew::test::robot("hexapod");
  std::vector<JointPosition> legs;
  for (const Joint& leg : hexapod.joints) {
    legs.push_back({PositionQuality::kUncertain, 0.27, leg.lower, leg.upper});
  }
  {
    const auto record = PositionRecord::open(folder.at("positions"), "old", hexapod);
    ASSERT_TRUE(record) << record.error().sentence;
    EXPECT_EQ((*record)->recovery().finding, JournalFinding::kNothing);
    const auto said = (*record)->import(hexapod, legs, {Instant{}, io::wall_time_ns()});
    ASSERT_TRUE(said) << said.error().sentence;
  }
  const auto again = PositionRecord::open(folder.at("positions"), "old", hexapod);
  ASSERT_TRUE(again) << again.error().sentence;
  const JournalRecovery& found = (*again)->recovery();
  EXPECT_EQ(found.way_out, WayOut::kVerify) << sentence(found.finding);
  ASSERT_EQ(found.positions.size(), legs.size());
  for (std::size_t leg = 0; leg < legs.size(); ++leg) {
    EXPECT_EQ(found.positions[leg].quality, PositionQuality::kUncertain);
    EXPECT_LE(found.positions[leg].lower, legs[leg].lower);
    EXPECT_GE(found.positions[leg].upper, legs[leg].upper);
    EXPECT_EQ(found.last_said[leg].q, 0.27);
  }
}

}  // namespace
}  // namespace sinew::runtime
