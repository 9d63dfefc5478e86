#include "sinew/program/plans/home_return.h"

#include <gtest/gtest.h>

#include "sinew/control/governor.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"
#include "support/robots.h"

namespace sinew::program {
namespace {

JointVector degrees(std::initializer_list<double> values) {
  JointVector q;
  for (const double value : values) q.push_back(from_deg(value));
  return q;
}

/// Beside its end stops, as homing leaves it: the forearm in the upper arm.
const JointVector kRest = degrees({-169, -89, -134, -169, -119, -359});

double nearest(const RobotModel& robot, const planning::JointPath& path, double share) {
  planning::PathPoint at;
  path.sample(share * path.length(), at);
  return planning::CollisionModel(robot).distance({at.q.data(), 6}).distance;
}

TEST(HomeReturn, arm_whose_homing_ends_in_itself_leaves_joint_by_joint_and_ends_clear) {
  const RobotModel& robot = test::robot("robot-arm-2");
  const auto back = home_return(robot, kRest, 3);
  ASSERT_TRUE(back) << describe(back.error().error);
  ASSERT_TRUE(back->overlap);
  EXPECT_LT(back->overlap->distance, -0.04);
  ASSERT_GE(back->legs.size(), 2U);
  JointVector at = kRest;
  double sum = 0;
  for (const HomeLeg& leg : back->legs) {
    int moved = 0;
    for (std::size_t j = 0; j < 6; ++j) moved += leg.motion.q_end[j] != at[j] ? 1 : 0;
    EXPECT_EQ(moved == 1, &leg != &back->legs.back());
    at = leg.motion.q_end;
    sum += leg.motion.duration;
  }
  for (const double q : at) EXPECT_EQ(q, 0);
  EXPECT_EQ(sum, back->duration);
  const auto& last = back->legs.back().planned.path.joints;
  for (int k = 0; k <= 100; ++k) EXPECT_GE(nearest(robot, last, k / 100.0), 0.01 - 1e-9) << k;
}

TEST(HomeReturn, stand_and_table_are_never_excused) {
  RobotModel fixed = test::robot("robot-arm-2");
  const auto back = home_return(fixed, kRest, 3);
  ASSERT_TRUE(back);
  std::erase_if(fixed.collision.shapes,
                [](const CollisionShape& shape) { return shape.link >= 1 && shape.link <= 2; });
  for (const HomeLeg& leg : back->legs) {
    for (int k = 0; k <= 200; ++k) {
      EXPECT_GE(nearest(fixed, leg.planned.path.joints, k / 200.0), 0.01 - 1e-9);
    }
  }
}

TEST(HomeReturn, from_a_clear_pose_all_joints_go_at_once_and_at_home_none) {
  const RobotModel& robot = test::robot("robot-arm-2");
  const auto back = home_return(robot, degrees({20, -30, -30, 0, 30, 10}), 3);
  ASSERT_TRUE(back) << describe(back.error().error);
  EXPECT_EQ(back->legs.size(), 1U);
  EXPECT_FALSE(back->overlap);
  const auto there = home_return(robot, degrees({0, 0, 0, 0, 0, 0}), 3);
  ASSERT_TRUE(there);
  EXPECT_TRUE(there->legs.empty());
  EXPECT_EQ(there->q_end, home_joints(robot));
}

TEST(HomeReturn, where_no_way_is_clear_of_a_joint_that_is_left_out_the_others_stay) {
  RobotModel robot = test::robot("robot-arm-2");
  robot.device.settings.get<AxisRegistersDevice>().boards[2].homing_place = kLeftOut;
  JointVector rest = kRest;
  rest[2] = assumed_place(robot.joints[2]);
  const auto stays = home_return(robot, rest, 3);
  ASSERT_TRUE(stays) << describe(stays.error().error);
  EXPECT_TRUE(stays->legs.empty());
  EXPECT_EQ(stays->q_end, rest);
}

TEST(HomeReturn, out_of_an_overlap_it_is_slow_where_a_speed_is_heard) {
  RobotModel robot = test::robot("robot-arm-2");
  const auto quick = home_return(robot, kRest, 3);
  robot.device.capability.takes_speed = true;
  robot.device.capability.motion = MotionKind::kStream;
  robot.device.capability.segment = std::chrono::milliseconds(20);
  const auto slow = home_return(robot, kRest, 3);
  ASSERT_TRUE(quick && slow);
  EXPECT_FALSE(quick->legs[0].slow);
  EXPECT_TRUE(slow->legs[0].slow);
  EXPECT_FALSE(slow->legs.back().slow);
  EXPECT_GT(slow->legs[0].motion.duration, 3 * quick->legs[0].motion.duration);
}

TEST(HomeReturn, every_leg_passes_the_last_look_before_a_driver) {
  RobotModel robot = test::robot("robot-arm-2");
  robot.device.settings = AxisLinkDevice{};
  robot.device.capability.takes_speed = true;
  robot.device.capability.motion = MotionKind::kStream;
  robot.device.capability.segment = std::chrono::milliseconds(50);
  const auto limits = planning::motion_limits(robot);
  // Where each of its two wires leaves it.
  for (const JointVector& rest : {kRest, degrees({-5.4, -94.4, -112.4, -5.4, -5.4, -5.4})}) {
    const auto back = home_return(robot, rest, 3);
    ASSERT_TRUE(back) << describe(back.error().error);
    control::Governor governor(robot, limits);
    JointVector at = rest;
    for (const HomeLeg& leg : back->legs) {
      governor.rest({at.data(), at.size()});
      governor.leave(leg.overlaps);
      for (const JointMove& piece : leg.motion.pieces) {
        const auto passed = governor.pass(piece);
        ASSERT_TRUE(passed) << describe(passed.error());
      }
      at = leg.motion.q_end;
    }
  }
}

TEST(HomeReturn, arm_that_finds_no_way_out_is_refused_with_its_line) {
  RobotModel robot = test::robot("robot-arm-2");
  robot.collision.table_height = 0.3;  // it would have to rise through the table
  const auto back = home_return(robot, kRest, 7);
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().line, 7);
  EXPECT_EQ(back.error().error.code, ErrorCode::kCollision);
}

}  // namespace
}  // namespace sinew::program
