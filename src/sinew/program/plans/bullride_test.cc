#include "sinew/program/plans/bullride.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/program_plan.h"
#include "support/robots.h"

namespace sinew::program {
namespace {

class Rides : public ::testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot() const { return test::robot(GetParam()); }
  JointVector start() const {
    // A wrist that is straight, or an arm that is, has no room on one side.
    if (GetParam() == "robot-arm-2") {
      JointVector q;
      for (const double deg : {0, -30, -30, 0, 60, 0}) q.push_back(from_deg(deg));
      return q;
    }
    return home_joints(robot());
  }
};

TEST_P(Rides, fills_its_time_with_moves_that_the_robot_can_make) {
  const auto ride = make_ride(robot(), start(), {.duration = 20, .seed = 5});
  ASSERT_TRUE(ride) << describe(ride.error().error);
  EXPECT_GE(ride->moves, 6);
  EXPECT_LE(ride->duration, 20);
  EXPECT_GT(ride->duration, 14) << ride->text;
  const auto program = parse(ride->text, "ride", robot());
  ASSERT_TRUE(program) << ride->text;
  const auto plan = make_plan(*program, robot(), start());
  ASSERT_TRUE(plan) << describe(plan.error().error);
  EXPECT_NEAR(plan->duration, ride->duration, 1e-6 + 0.01 * ride->duration);
  const auto* last = std::get_if<MoveOrder>(&plan->orders.back().what);
  ASSERT_NE(last, nullptr);
  for (std::size_t j = 0; j < start().size(); ++j) EXPECT_NEAR(last->q[j], start()[j], 1e-6);
}

TEST_P(Rides, one_seed_is_one_ride_and_another_another) {
  const RideOrder order{.duration = 8, .seed = 3};
  const auto first = make_ride(robot(), start(), order);
  const auto again = make_ride(robot(), start(), order);
  const auto other = make_ride(robot(), start(), {.duration = 8, .seed = 4});
  ASSERT_TRUE(first && again && other);
  EXPECT_EQ(first->text, again->text);
  EXPECT_NE(first->text, other->text);
}

TEST_P(Rides, an_amplitude_that_was_asked_for_bounds_every_pose) {
  const double amplitude = GetParam() == "hexapod" ? 0.002 : 0.05;
  const auto ride =
      make_ride(robot(), start(), {.duration = 30, .seed = 9, .amplitude = amplitude});
  ASSERT_TRUE(ride);
  const auto program = parse(ride->text, "ride", robot());
  ASSERT_TRUE(program);
  for (const Step& step : program->steps) {
    const auto& row = std::get<JointStep>(step.what);
    for (std::size_t j = 0; j < row.q.size(); ++j) {
      const Joint& joint = robot().joints[j];
      EXPECT_LE(std::abs(row.q[j] - start()[j]),
                amplitude * (joint.upper - joint.lower) / 2 + 1e-6);
    }
  }
}

TEST(Hexapod, rides_with_amplitude_and_time_both_chosen_and_says_what_the_wire_could) {
  const RobotModel robot = test::robot("hexapod");
  const JointVector q = home_joints(robot);
  // 0.02 % of 75 mm: 15 um a leg, 240 steps a second for all of them.
  const auto ride = make_ride(robot, q, {.duration = 10, .seed = 1, .amplitude = 2e-4});
  ASSERT_TRUE(ride);
  EXPECT_GE(ride->moves, 2);
  EXPECT_LE(ride->duration, 10);
  const RideOrder wide{.duration = 10, .seed = 1, .amplitude = 0.01};
  const auto none = make_ride(robot, q, wide);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().error.code, ErrorCode::kRideTime);
  EXPECT_GT(none.error().error.measured, 10);
  EXPECT_EQ(none.error().error.limit, 10);
  RideOrder fitting = wide;
  fitting.amplitude = fitting_ride(robot, q, wide);
  EXPECT_GT(fitting.amplitude, 2e-4);
  EXPECT_LT(fitting.amplitude, 0.01);
  EXPECT_TRUE(make_ride(robot, q, fitting));
  RideOrder longer = wide;
  longer.duration = 4 * none.error().error.measured;
  EXPECT_TRUE(make_ride(robot, q, longer));
}

TEST_P(Rides, what_is_no_ride_is_refused) {
  for (const double duration : {0.0, -1.0, 1e9, std::nan("")}) {
    EXPECT_FALSE(make_ride(robot(), start(), {.duration = duration}));
  }
  for (const double amplitude : {-0.1, 1.1, std::nan("")}) {
    EXPECT_FALSE(make_ride(robot(), start(), {.amplitude = amplitude}));
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, Rides,
                         ::testing::Values("robot-arm-2", "learm", "bigrobotarm", "maxarm",
                                           "hexapod"),
                         [](const auto& robot) {
                           std::string name = robot.param;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace sinew::program
