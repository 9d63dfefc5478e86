#include "sinew/devices/grbl/grbl_driver_positions.h"

#include <gtest/gtest.h>

#include <vector>

namespace sinew {
namespace {

/// Two axes of 100 steps per degree; the second one counts the other way round.
GrblDevice two_axes() {
  GrblDevice device;
  device.axes.push_back({.steps_per_unit = 100, .zero = 0.5});
  device.axes.push_back({.steps_per_unit = -100, .zero = -0.25});
  return device;
}

grbl::Values counts(double a, double b) {
  grbl::Values all;
  all.push_back(a), all.push_back(b);
  return all;
}

JointPosition at(double q, std::optional<double> zero = std::nullopt, double slack = 1e-4) {
  return {PositionQuality::kCommanded, q, q - slack, q + slack, zero};
}

constexpr double kNear = 1e-9;

class GrblKnown : public ::testing::Test {
 protected:
  void begin(const std::vector<JointPosition>& left) {
    known.declare(left);
    known.leave();
  }
  PositionQuality quality(std::size_t joint) const { return known.position(joint, 0).quality; }

  GrblPositions known{two_axes()};
};

TEST_F(GrblKnown, knows_nothing_of_itself_and_a_declaration_ties_the_counts) {
  known.count(counts(10, 20));
  EXPECT_EQ(known.unknown(), 0U);
  EXPECT_FALSE(known.counted(0));
  known.declare(std::vector{at(1), at(2)});
  EXPECT_FALSE(known.unknown());
  known.count(counts(20, 30));
  EXPECT_NEAR(known.position(0, 0).q, 1 + from_deg(10), kNear);
  EXPECT_NEAR(known.position(1, 0).q, 2 - from_deg(10), kNear);
  EXPECT_NEAR(known.count_of(1, 2), 20, kNear);
  EXPECT_NEAR(known.place(1, 20), 2, kNear);
}

TEST_F(GrblKnown, until_the_first_status_it_shows_what_was_left) {
  begin({at(1, 0.0), at(2, 0.0)});
  EXPECT_EQ(quality(0), PositionQuality::kCommanded);
  EXPECT_EQ(known.position(1, 0).q, 2);
}

TEST_F(GrblKnown, counts_that_are_where_they_were_left_are_believed) {
  begin({at(from_deg(10), 0.0), at(from_deg(-20), 0.0)});
  known.count(counts(10, 20));
  EXPECT_EQ(quality(0), PositionQuality::kCommanded);
  EXPECT_NEAR(known.position(1, 0).q, from_deg(-20), kNear);
  EXPECT_EQ(known.away_from_zero(), 3);
}

TEST_F(GrblKnown, counts_that_are_elsewhere_are_not) {
  begin({at(from_deg(10), 0.0), at(from_deg(-20), 0.0)});
  known.count(counts(10, 20.1));
  EXPECT_EQ(quality(0), PositionQuality::kLost);
  EXPECT_EQ(quality(1), PositionQuality::kLost);
}

TEST_F(GrblKnown, counts_of_0_are_those_of_a_board_that_restarted) {
  begin({at(0, 0.0), at(0, 0.0)});
  known.count(counts(0, 0));
  EXPECT_EQ(quality(0), PositionQuality::kLost);
}

TEST_F(GrblKnown, counts_of_0_are_believed_of_a_board_that_has_the_mark) {
  begin({at(0, 0.0), at(0, 0.0)});
  known.see_mark(true);
  known.count(counts(0, 0));
  EXPECT_EQ(quality(0), PositionQuality::kCommanded);
  begin({at(0, 0.0), at(0, 0.0)});
  known.see_mark(true);
  known.count(counts(1, 0));
  EXPECT_EQ(quality(0), PositionQuality::kLost);
}

TEST_F(GrblKnown, a_restart_that_is_told_counts_more_than_counts) {
  begin({at(from_deg(10), 0.0), at(from_deg(-20), 0.0)});
  known.restart();
  known.count(counts(10, 20));
  EXPECT_EQ(quality(0), PositionQuality::kLost);
}

TEST_F(GrblKnown, a_place_that_somebody_saw_stays_behind_a_restart) {
  begin({at(1), at(2)});
  known.restart();
  known.count(counts(0, 0));
  EXPECT_NEAR(known.position(1, 0).q, 2, kNear);
}

TEST_F(GrblKnown, a_motion_that_was_under_way_is_found_inside_what_was_reserved) {
  JointPosition a = at(0, 0.0), b = at(0, 0.0);
  a.quality = b.quality = PositionQuality::kUncertain;
  a.lower = 0, a.upper = from_deg(30);
  b.lower = from_deg(-30), b.upper = 0;
  begin({a, b});
  known.count(counts(12, 7));
  EXPECT_EQ(quality(0), PositionQuality::kCommanded);
  EXPECT_NEAR(known.position(1, 0).q, from_deg(-7), kNear);
  // Without its mark it may have restarted, and have been moved since.
  begin({a, b});
  known.see_mark(false);
  known.count(counts(12, 7));
  EXPECT_EQ(quality(0), PositionQuality::kLost);
}

TEST_F(GrblKnown, a_lost_joint_keeps_the_evidence_of_its_count) {
  begin({at(from_deg(10), 0.0), {.count_zero = 0.0}});
  known.count(counts(10, 20));
  EXPECT_EQ(quality(0), PositionQuality::kCommanded);
  EXPECT_EQ(quality(1), PositionQuality::kLost);
  ASSERT_TRUE(known.counted(1));
  EXPECT_NEAR(known.counted(1)->lower, from_deg(-20), 1e-3);
}

TEST_F(GrblKnown, behind_a_search_for_switches_the_zeros_are_those_of_the_file) {
  known.count(counts(0, 0));
  known.count(counts(5, -5));
  known.homed();
  EXPECT_NEAR(known.position(0, 0).q, 0.5 + from_deg(5), kNear);
  EXPECT_NEAR(known.position(1, 0).q, -0.25 + from_deg(5), kNear);
  known.lose();
  EXPECT_EQ(known.unknown(), 0U);
}

}  // namespace
}  // namespace sinew
