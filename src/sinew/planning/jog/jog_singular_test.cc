// Jogs at singularities: whatever direction is lost, the tool's tip goes as asked or more slowly.
#include <gtest/gtest.h>

#include <vector>

#include "sinew/planning/jog/jog_test_robot.h"

namespace sinew::planning {
namespace {

/// How the tip goes while a jog is held, and after it was let go.
struct TipWay {
  double aside = 0;  ///< m, at most, off the line that was asked for
  double along = 0;  ///< m, at the end
  double back = 0;   ///< m, at most, against it
  double after = 0;  ///< m, from letting go to rest
  double turned = 0;
};

TipWay tip_way(JogRun& run, std::initializer_list<double> q_deg, const JogCommand& command,
               double seconds) {
  std::vector<double> q;
  for (const double value : q_deg) q.push_back(from_deg(value));
  run.start(q);
  const PoseBT X_start = run.jog.pose();
  Vec3 line{command.velocity[0], command.velocity[1], command.velocity[2]};
  if (norm(line) > 0) line = normalized(line);
  TipWay way;
  for (double t = 0; t < seconds; t += 0.01) {
    run.hold(command, 0.01, 0.002);
    const Vec3 gone = run.jog.pose().p - X_start.p;
    way.along = dot(gone, line);
    way.back = std::max(way.back, -way.along);
    way.aside = std::max(way.aside, norm(gone - way.along * line));
  }
  way.turned = angle_between(run.jog.pose().R, X_start.R);
  const Vec3 end = run.jog.pose().p;
  run.settle(0.005);
  way.after = norm(run.jog.pose().p - end);
  return way;
}

JogCommand turn_about(Vec3 axis) {
  const Vec3 w = from_deg(20) * axis;
  return {.frame = JogFrame::kBase, .velocity = {0, 0, 0, w.x, w.y, w.z}};
}

constexpr Vec3 kAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

TEST(JogSingular, pure_turn_keeps_the_tip_where_the_wrist_is_singular) {
  const std::initializer_list<double> kPlaces[] = {{0, 0, 0, 0, 0, 0},      {0, -60, 60, 0, 0, 0},
                                                   {0, -60, 60, 0, 0.5, 0}, {0, -60, 60, 0, 5, 0},
                                                   {0, -30, -30, 0, 0, 0},  {0, -30, -30, 0, 1, 0},
                                                   {20, -40, 30, 0, 0, 0}};
  for (const auto& place : kPlaces) {
    for (const Vec3& axis : kAxes) {
      JogRun run("robot-arm-2");
      SCOPED_TRACE(testing::PrintToString(std::vector<double>(place)) +
                   testing::PrintToString(std::vector<double>{axis.x, axis.y, axis.z}));
      const TipWay way = tip_way(run, place, turn_about(axis), 5);
      ASSERT_FALSE(HasFatalFailure());
      EXPECT_LT(way.aside, 5e-3);
      // To rest the joints go along their own line, for a second or two from full speed.
      EXPECT_LT(way.after, 60e-3);
    }
  }
}

/// About the one axis that is lost nothing turns; about the others it does.
TEST(JogSingular, turn_that_is_lost_is_left_out_and_the_others_go) {
  JogRun run("robot-arm-2");
  const TipWay lost = tip_way(run, {0, 0, 0, 0, 0, 0}, turn_about({0, 0, 1}), 5);
  EXPECT_EQ(run.jog.status().reason, JogReason::kStopped);
  EXPECT_LT(lost.turned, from_deg(1));
  EXPECT_LT(lost.aside + lost.after, 1e-4);
  EXPECT_GT(tip_way(run, {0, 0, 0, 0, 0, 0}, turn_about({1, 0, 0}), 5).turned, from_deg(40));
  EXPECT_GT(tip_way(run, {0, 0, 0, 0, 0, 0}, turn_about({0, 1, 0}), 5).turned, from_deg(20));
}

TEST(JogSingular, arm_that_gets_stretched_slows_down_on_its_line_and_comes_back) {
  for (const double bend_deg : {0.0, 0.5, 20.0}) {
    SCOPED_TRACE(bend_deg);
    JogRun run("robot-arm-2");
    JogCommand command{.frame = JogFrame::kBase, .velocity = {0.05, 0, 0}};
    const TipWay way = tip_way(run, {0, -60, 60, 0, bend_deg, 0}, command, 20);
    ASSERT_FALSE(HasFatalFailure());
    EXPECT_LT(way.aside, 6e-3);
    EXPECT_LT(way.back, 1e-4);
    EXPECT_GT(way.along, 5e-3);
    EXPECT_LT(way.after, 1e-3);
    // Back out again.
    command.velocity[0] = -0.05;
    const Vec3 stretched = run.jog.pose().p;
    run.hold(command, 10, 0.002);
    EXPECT_LT(run.jog.pose().p.x, stretched.x - 0.05);
  }
}

}  // namespace
}  // namespace sinew::planning
