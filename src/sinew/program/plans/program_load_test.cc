#include "sinew/program/plans/program_load.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/units.h"
#include "support/robots.h"

namespace sinew::program {
namespace {

using planning::DriveTrain;
using planning::InverseDynamics;

const RobotModel& arm() {
  return test::robot("robot-arm-2");
}

std::vector<DriveTrain> drives_of(const RobotModel& model) {
  std::vector<DriveTrain> drives;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    drives.push_back(*planning::drive_train(model, i));
  }
  return drives;
}

JointVector home_of(const RobotModel& model) {
  JointVector q;
  for (const Joint& joint : model.joints) q.push_back(joint.home);
  return q;
}

std::vector<JointLoad> loads_of(const RobotModel& model, std::string_view text, double payload) {
  const auto parsed = parse(text, "test.sinew", model);
  EXPECT_TRUE(parsed.has_value());
  const auto plan = make_plan(*parsed, model, home_of(model));
  EXPECT_TRUE(plan.has_value());
  const auto drives = drives_of(model);
  const auto loads = load_of(*plan, model, InverseDynamics(model, payload), drives);
  EXPECT_TRUE(loads.has_value());
  return *loads;
}

TEST(ProgramLoad, waiting_costs_the_weight_at_the_place) {
  const auto loads = loads_of(arm(), "wait 2s\n", 1);
  const JointVector still{0, 0, 0, 0, 0, 0};
  const JointVector weight = *InverseDynamics(arm(), 1).torque(home_of(arm()), {still, still});
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const double expected = drives_of(arm())[i].demand({weight[i], 0, 0});
    EXPECT_NEAR(loads[i].peak, expected, 1e-9);
    EXPECT_NEAR(loads[i].rms, expected, 1e-9);
    EXPECT_EQ(loads[i].line, 1);
  }
}

TEST(ProgramLoad, peak_is_where_a_slow_look_at_the_profile_finds_it) {
  const std::string_view text =
      "joint shoulder=-60deg elbow=80deg\nwait 1s\njoint shoulder=40deg elbow=-30deg\n";
  const auto loads = loads_of(arm(), text, 0.8);
  const auto plan = make_plan(*parse(text, "t", arm()), arm(), home_of(arm()));
  const InverseDynamics dynamics(arm(), 0.8);
  const DriveTrain shoulder = drives_of(arm())[1];
  double peak = 0, time = 0, start = 0;
  int line = 0;
  for (const Order& order : plan->orders) {
    const auto* move = std::get_if<MoveOrder>(&order.what);
    if (move == nullptr) {
      start += 1;
      continue;
    }
    const auto profile = profile_between(*move->q_start, move->q, arm(), 1);
    for (double t = 0; t <= profile.duration(); t += 1e-3) {
      motion::AxisStates s;
      profile.sample(t, s);
      const JointVector torque = *dynamics.torque(
          {s.q.data(), 6}, {std::span(s.qd.data(), 6), std::span(s.qdd.data(), 6)});
      const double demand = shoulder.demand({torque[1], s.qd[1], s.qdd[1]});
      if (demand <= peak) continue;
      peak = demand;
      time = start + t;
      line = order.line;
    }
    start += profile.duration();
  }
  EXPECT_NEAR(loads[1].peak, peak, 1e-3 * peak);
  EXPECT_NEAR(loads[1].time, time, 0.02);
  EXPECT_EQ(loads[1].line, line);
  EXPECT_LT(loads[1].rms, loads[1].peak);
  EXPECT_GT(loads[1].rms, 0);
}

TEST(ProgramLoad, more_payload_costs_more) {
  const std::string_view text = "joint shoulder=-70deg\njoint shoulder=0deg\n";
  const auto bare = loads_of(arm(), text, 0), loaded = loads_of(arm(), text, 2);
  EXPECT_GT(loaded[1].peak, bare[1].peak + 2 * 9.8 * 0.3);
  EXPECT_GT(loaded[1].rms, bare[1].rms);
  EXPECT_LT(loaded[1].margin(), bare[1].margin());
}

TEST(ProgramLoad, loops_and_homes_count_from_where_they_end) {
  const auto once = loads_of(arm(), "joint elbow=40deg\njoint elbow=0deg\n", 1);
  const auto often = loads_of(arm(), "loop 3\njoint elbow=40deg\njoint elbow=0deg\nend\n", 1);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_NEAR(once[i].peak, often[i].peak, 1e-9);
    EXPECT_NEAR(once[i].rms, often[i].rms, 1e-9);
  }
  EXPECT_EQ(often[2].line, once[2].line + 1);
  const auto homed = loads_of(arm(), "joint elbow=40deg\nhome\nwait 1s\n", 0);
  EXPECT_GT(homed[1].peak, 0);
}

TEST(ProgramLoad, legs_carry_their_platform) {
  const RobotModel& model = test::robot("hexapod");
  const auto loads = loads_of(model, "wait 1s\n", 3);
  for (const JointLoad& load : loads) EXPECT_GT(load.peak, 45 + 4.2 * 9.8 / 6);
}

TEST(ProgramLoad, leg_lengths_that_no_platform_has_are_refused_with_their_line) {
  const RobotModel& model = test::robot("hexapod");
  Plan plan;
  JointVector apart = home_of(model);
  apart[0] = model.joints[0].upper;
  apart[3] = model.joints[3].lower;
  apart[1] = model.joints[1].lower;
  const Step row{7, JointStep{apart, 63, {}}};
  plan.orders.push_back({7, 7, 1, 1, MoveOrder{{row}, home_of(model), apart, 1}});
  const auto drives = drives_of(model);
  const auto loads = load_of(plan, model, InverseDynamics(model, 0), drives);
  ASSERT_FALSE(loads.has_value());
  EXPECT_EQ(loads.error().line, 7);
}

}  // namespace
}  // namespace sinew::program
