#include "sinew/program/plans/row_planner.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_multipliers.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/program/plans/program_plan.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::program {
namespace {

using kinematics::PoseBT;

/// A stretched-out start of each robot from where its tool has room all around.
JointVector start_of(const RobotModel& robot) {
  if (robot.id == "robot-arm-2") {
    return {0, from_deg(20), from_deg(-30), 0, from_deg(30), 0};
  }
  if (robot.id == "learm") return {0, from_deg(10), from_deg(75), from_deg(20), 0};
  if (robot.id == "bigrobotarm") return {0, from_deg(10), from_deg(70), 0, from_deg(40)};
  if (robot.id == "maxarm") return {from_deg(120), from_deg(110), from_deg(30)};
  JointVector q;
  for (const Joint& joint : robot.joints) q.push_back(joint.home);
  return q;
}

/// robot-arm-2 with boards that are led along a way.
RobotModel streaming_arm() {
  RobotModel robot = test::robot("robot-arm-2");
  robot.device.capability.motion = MotionKind::kStream;
  robot.device.capability.segment = std::chrono::milliseconds(20);
  return robot;
}

struct Bench {
  explicit Bench(std::string_view id) : Bench(test::robot(id)) {}
  explicit Bench(RobotModel model) : robot(std::move(model)), planner(robot) {}

  std::expected<RowMotion, Refusal> plan(std::string_view text) {
    program = *parse(text, "p", robot);
    return planner.plan(start_of(robot), {}, program.steps);
  }
  PoseBT tool(std::span<const double> q) {
    const auto X_BT = planner.space().forward(q, planner.space().home());
    EXPECT_TRUE(X_BT);
    return *X_BT;
  }
  PoseBT start() { return tool({start_of(robot).data(), robot.joints.size()}); }

  const RobotModel robot;
  RowPlanner planner;
  Program program;
};

class RowPlannerOf : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Robots, RowPlannerOf,
                         testing::Values("robot-arm-2", "learm", "bigrobotarm", "maxarm",
                                         "hexapod"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST_P(RowPlannerOf, line_ends_where_it_was_sent_and_its_pieces_lie_on_it) {
  Bench bench(GetParam());
  const auto from = bench.start();
  // A platform's legs are slow and short.
  const double step = bench.planner.space().hexapod() != nullptr ? 4e-3 : 30e-3;
  char text[80];
  std::snprintf(text, sizeof text, "line z=%.6fmm", (from.p.z + step) * 1e3);
  const auto motion = bench.plan(text);
  ASSERT_TRUE(motion) << describe(motion.error().error);
  ASSERT_FALSE(motion->pieces.empty());
  for (const JointMove& piece : motion->pieces) {
    const auto X_BT = bench.tool({piece.q.data(), piece.q.size()});
    EXPECT_LT(std::hypot(X_BT.p.x - from.p.x, X_BT.p.y - from.p.y), 2e-5);
    EXPECT_GE(X_BT.p.z, from.p.z - 1e-6);
    EXPECT_LE(X_BT.p.z, from.p.z + step + 1e-6);
  }
  EXPECT_EQ(motion->pieces.back().q, motion->q_end);
  EXPECT_NEAR(bench.tool({motion->q_end.data(), motion->q_end.size()}).p.z, from.p.z + step, 1e-6);
  if (const auto* boards = bench.robot.device.settings.as<AxisRegistersDevice>()) {
    // Frame by frame: each piece is asked for, told, polled and read back.
    double frames = 0, before = 0;
    for (const JointMove& piece : motion->pieces) {
      before = frames;
      frames += to_seconds(piece.duration) + 3 * 0.082;
    }
    EXPECT_GE(motion->duration, frames);
    EXPECT_LE(motion->duration, frames + 1.2 * static_cast<double>(motion->pieces.size()));
    EXPECT_GT(motion->arrival, before);
    EXPECT_LT(motion->arrival, motion->duration - 0.082);
    EXPECT_TRUE(boards->reports_status);
    return;
  }
  const MotionDelay delay = bench.robot.device.settings->motion_delay();
  const bool streamed = bench.robot.device.capability.motion == MotionKind::kStream;
  double sum = streamed ? to_seconds(delay.report) : 0;
  for (const JointMove& piece : motion->pieces) {
    sum += to_seconds(piece.duration) + (streamed ? 0 : to_seconds(delay.report));
  }
  EXPECT_NEAR(sum, motion->duration, 1e-9 * static_cast<double>(motion->pieces.size()));
  EXPECT_NEAR(motion->duration - motion->arrival, to_seconds(delay.report - delay.arrival), 1e-9);
}

TEST_P(RowPlannerOf, whoever_takes_whole_moves_is_led_along_the_way_from_stop_to_stop) {
  Bench bench(GetParam());
  const auto from = bench.start();
  const double step = bench.planner.space().hexapod() != nullptr ? 4e-3 : 40e-3;
  char text[80];
  std::snprintf(text, sizeof text, "line z=%.6fmm", (from.p.z + step) * 1e3);
  const auto motion = bench.plan(text);
  ASSERT_TRUE(motion) << describe(motion.error().error);
  if (bench.robot.device.capability.motion == MotionKind::kStream) {
    EXPECT_LE(motion->pieces[0].duration, bench.robot.device.capability.segment);
    return;
  }
  JointVector last = start_of(bench.robot);
  for (const JointMove& piece : motion->pieces) {
    for (const double qd : piece.qd) EXPECT_EQ(qd, 0);
    for (const double share : {0.25, 0.5, 0.75}) {
      JointVector q = last;
      for (std::size_t j = 0; j < q.size(); ++j) q[j] += share * (piece.q[j] - last[j]);
      const auto X_BT = bench.tool({q.data(), q.size()});
      EXPECT_LT(std::hypot(X_BT.p.x - from.p.x, X_BT.p.y - from.p.y),
                RowPlanner::kWayTolerance * 1.05);
    }
    last = piece.q;
  }
}

TEST(RowPlanner, rows_that_blend_are_one_motion_and_the_others_are_not) {
  Bench bench(streaming_arm());
  const auto stops = bench.plan("line y=40mm\nline z=620mm\n");
  ASSERT_TRUE(stops) << describe(stops.error().error);
  EXPECT_EQ(stops->rows, 1U);
  const auto blended = bench.plan("line y=40mm blend=10mm\nline z=620mm blend=5mm\nline y=0mm\n");
  ASSERT_TRUE(blended) << describe(blended.error().error);
  EXPECT_EQ(blended->rows, 3U);
  const auto end = bench.tool({blended->q_end.data(), 6});
  EXPECT_NEAR(end.p.z, 0.62, 1e-6);
  EXPECT_NEAR(end.p.y, 0, 1e-6);
}

TEST(RowPlanner, what_a_row_does_not_name_stays_as_it_is) {
  Bench bench("learm");
  const auto from = bench.start();
  const auto pitched = bench.plan("line pitch=120deg");
  ASSERT_TRUE(pitched) << describe(pitched.error().error);
  const auto to = bench.tool({pitched->q_end.data(), 5});
  EXPECT_LT(norm(to.p - from.p), 1e-6);
  EXPECT_NEAR(bench.planner.space().point(to).attitude[0], from_deg(120), 1e-6);
  Bench six("robot-arm-2");
  const JointVector q = start_of(six.robot);
  const auto X_from = six.start();
  char text[80];
  std::snprintf(text, sizeof text, "move z=%.3fmm", (X_from.p.z + 0.05) * 1e3);
  const auto program = *parse(text, "p", six.robot);
  const auto moved = six.planner.plan(q, {}, program.steps);
  ASSERT_TRUE(moved) << describe(moved.error().error);
  const auto X_to = six.tool({moved->q_end.data(), 6});
  EXPECT_NEAR(X_to.p.z, X_from.p.z + 0.05, 1e-5);
  EXPECT_NEAR(X_to.p.x, X_from.p.x, 1e-6);
  EXPECT_LT(angle_between(X_to.R, X_from.R), 1e-6);
}

TEST(RowPlanner, joint_row_behind_a_blended_line_keeps_the_joints_that_the_line_ends_with) {
  Bench bench(streaming_arm());
  const auto line = bench.plan("line y=40mm\n");
  ASSERT_TRUE(line);
  const auto both = bench.plan("line y=40mm blend=10mm\njoint J1=20deg\n");
  ASSERT_TRUE(both) << describe(both.error().error);
  ASSERT_EQ(both->rows, 2U);
  EXPECT_EQ(both->q_end[0], from_deg(20));
  for (std::size_t j = 1; j < 6; ++j) EXPECT_NEAR(both->q_end[j], line->q_end[j], 1e-9);
}

TEST(RowPlanner, tool_speed_stretches_the_pieces_of_whole_moves_too) {
  for (const char* id : {"learm", "bigrobotarm", "maxarm"}) {
    Bench bench(id);
    const auto from = bench.start();
    char text[80];
    std::snprintf(text, sizeof text, "line z=%.3fmm speed=5mm/s", (from.p.z + 0.03) * 1e3);
    const auto slow = bench.plan(text);
    ASSERT_TRUE(slow) << id << describe(slow.error().error);
    EXPECT_GE(slow->duration, 0.03 / 5e-3) << id;
  }
}

TEST(RowPlanner, blend_is_not_heard_where_whole_moves_are_taken_and_costs_nothing) {
  for (const char* id : {"maxarm", "bigrobotarm", "robot-arm-2"}) {
    Bench bench(id);
    const auto stops = bench.plan("joint J1=115deg\njoint J2=100deg\n");
    const auto blends = bench.plan("joint J1=115deg blend=5deg\njoint J2=100deg\n");
    if (!stops) continue;  // beyond a limit of this one
    ASSERT_TRUE(blends) << id;
    EXPECT_EQ(blends->rows, 1U) << id;
    ASSERT_EQ(blends->pieces.size(), 1U) << id;
    EXPECT_EQ(blends->duration, stops->duration) << id;
    EXPECT_TRUE(unheard(*motion_of(bench.program.steps[0]), bench.robot).blend) << id;
  }
}

/// The tool's greatest acceleration on a whole move whose joints go by these trapezoids.
double trapezoids_acceleration(Bench& bench, const JointVector& from, const JointVector& to,
                               const BigRobotArmMultipliers& told) {
  const auto& device = bench.robot.device.settings.get<BigRobotArmDevice>();
  constexpr double kStep = 2e-3;
  const auto at = [&](double t) {
    JointVector q = from;
    for (std::size_t j = 0; j < q.size(); ++j) {
      const BigRobotArmJoint& joint = device.joints[j];
      const double unit = joint.steps_per_motor_rev / 100 / std::abs(joint.steps_per_rad);
      const double way = std::abs(to[j] - from[j]);
      const double a = told.accelerations[j] * unit;
      const double v = std::min(told.speeds[j] * unit, std::sqrt(way * a));
      if (way == 0) continue;
      const double end = way / v + v / a;
      const auto ramp = [&](double s) { return s < v / a ? a * s * s / 2 : v * (s - v / a / 2); };
      const double s = std::clamp(t, 0.0, end);
      const double gone = s < end / 2 ? ramp(s) : way - ramp(end - s);
      q[j] += std::copysign(gone, to[j] - from[j]);
    }
    return bench.tool({q.data(), q.size()}).p;
  };
  double greatest = 0;
  for (double t = 0; t < 60; t += kStep) {
    const Vec3 bend = at(t + kStep) - 2 * at(t) + at(t - kStep);
    greatest = std::max(greatest, norm(bend) / (kStep * kStep));
  }
  return greatest;
}

TEST(RowPlanner, tool_acceleration_is_kept_by_a_device_that_can_be_told_one) {
  Bench bench("bigrobotarm");
  const auto& device = bench.robot.device.settings.get<BigRobotArmDevice>();
  for (const double asked : {5.0, 10.0, 20.0, 80.0}) {
    // Settings of two or three are coarse: the device rounds up.
    const double coarse = asked < 10 ? 1.25 : 1;
    char text[80];
    std::snprintf(text, sizeof text, "line y=40mm accel=%.0fmm/s2", asked);
    const auto motion = bench.plan(text);
    ASSERT_TRUE(motion) << describe(motion.error().error);
    EXPECT_GE(motion->duration, 2 * std::sqrt(0.04 / (asked * 1e-3)));
    JointVector from = start_of(bench.robot);
    for (const JointMove& piece : motion->pieces) {
      bigrobotarm::Words deltas{};
      BigRobotArmMultipliers base;
      for (std::size_t j = 0; j < from.size(); ++j) {
        const BigRobotArmJoint& joint = device.joints[j];
        const double unit = joint.steps_per_motor_rev / 100 / std::abs(joint.steps_per_rad);
        deltas[j] = static_cast<std::int32_t>((piece.q[j] - from[j]) * joint.steps_per_rad);
        base.speeds[j] = static_cast<std::int32_t>(bench.robot.joints[j].velocity_max / unit);
        base.accelerations[j] =
            static_cast<std::int32_t>(bench.robot.joints[j].acceleration_max / unit);
      }
      const auto told = synchronised_multipliers(device, deltas, base, to_seconds(piece.duration));
      ASSERT_TRUE(told);
      const double real = trapezoids_acceleration(bench, from, piece.q, *told);
      RecordProperty("real_mm_s2", std::to_string(real * 1e3));
      EXPECT_LE(real, coarse * 1e-3 * asked) << asked;
      from = piece.q;
    }
  }
}

TEST(RowPlanner, what_a_device_cannot_be_told_does_not_count) {
  const struct {
    const char* robot;
    bool speed, acceleration, blend;
  } kCases[] = {{"robot-arm-2", true, true, true},
                {"maxarm", false, true, true},
                {"bigrobotarm", false, false, true},
                {"learm", false, false, false},
                {"hexapod", false, false, false}};
  for (const auto& c : kCases) {
    const RobotModel& robot = test::robot(c.robot);
    const auto program = *parse("line z=1mm speed=80mm/s accel=5mm/s2 blend=1mm", "p", robot);
    const Unheard told = unheard(*motion_of(program.steps[0]), robot);
    EXPECT_EQ(told.speed, c.speed) << c.robot;
    EXPECT_EQ(told.acceleration, c.acceleration) << c.robot;
    EXPECT_EQ(told.blend, c.blend) << c.robot;
  }
  Bench boards("robot-arm-2");
  const auto plain = boards.plan("line y=40mm");
  const auto slow = boards.plan("line y=40mm speed=1mm/s accel=1mm/s2");
  ASSERT_TRUE(plain && slow);
  EXPECT_EQ(slow->duration, plain->duration);
}

TEST(RowPlanner, corner_that_stops_says_why) {
  Bench bench(streaming_arm());
  const auto nowhere = bench.plan("line y=40mm blend=10mm\nline y=40mm\n");
  ASSERT_TRUE(nowhere) << describe(nowhere.error().error);
  EXPECT_EQ(nowhere->rows, 1U);
  EXPECT_EQ(nowhere->stop, CornerStopReason::kNoWay);
  const auto none = bench.plan("line y=40mm\nline y=0mm\n");
  ASSERT_TRUE(none);
  EXPECT_EQ(none->stop, CornerStopReason::kNone);
}

TEST(RowPlanner, refusal_names_its_line_and_what_would_work) {
  Bench bench(streaming_arm());
  const auto motion = bench.plan("line y=40mm blend=10mm\n\nline x=3000mm\n");
  ASSERT_FALSE(motion);
  EXPECT_EQ(motion.error().line, 3);
  ASSERT_TRUE(motion.error().way);
  EXPECT_EQ(motion.error().way->refusal.place.move, 1U);
  EXPECT_EQ(motion.error().error.code, ErrorCode::kOutOfReach);
  // Folded onto its own upper arm.
  const auto through = bench.plan("joint J3=-100deg\n");
  ASSERT_FALSE(through);
  EXPECT_EQ(through.error().error.code, ErrorCode::kCollision) << describe(through.error().error);
  EXPECT_GE(through.error().error.other, 0);
  EXPECT_GT(through.error().way->refusal.place.at, 0);
}

/// Held against joints drawn all over the range: none has the tool nearer to its target.
TEST(RowPlanner, nearest_place_in_reach_is_offered_and_a_tenth_of_a_millimetre_is_no_refusal) {
  RobotModel free = test::robot("maxarm");
  free.collision = {};
  Bench bench(free);
  int offered = 0;
  test::for_random_cases(10, [&](test::Random& random) {
    const Vec3 target{random.uniform(-0.5, 0.5), random.uniform(-0.5, -0.1),
                      random.uniform(0.05, 0.5)};
    const auto row = [](const Vec3& p) {
      return "move x=" + std::to_string(to_mm(p.x)) + "mm y=" + std::to_string(to_mm(p.y)) +
             "mm z=" + std::to_string(to_mm(p.z)) + "mm";
    };
    const auto motion = bench.plan(row(target));
    if (motion) return random.discard();
    ASSERT_TRUE(motion.error().way);
    const auto& near = motion.error().way->proposal.near;
    ASSERT_TRUE(near) << row(target);
    ++offered;
    const planning::ToolSpace& space = bench.planner.space();
    double nearest = 1;
    for (int k = 0; k < 20'000; ++k) {
      JointVector q;
      for (const Joint& joint : free.joints) q.push_back(random.uniform(joint.lower, joint.upper));
      const auto X_BT = space.forward({q.data(), q.size()}, space.home());
      const Vec3 p = X_BT->p;
      // The linkage itself may not have it.
      if (norm(p - target) >= nearest || space.branches(space.point(*X_BT), {}).empty()) continue;
      nearest = norm(p - target);
    }
    EXPECT_LT(near->left, nearest + 2e-3) << row(target);
    const std::span<const double> q(near->q.data(), 3);
    const auto X_BT = space.forward(q, space.home());
    EXPECT_NEAR(norm(X_BT->p - target), near->left, 1e-6);
    // Next to it.
    const Vec3 out = (1 / near->left) * (target - X_BT->p);
    EXPECT_TRUE(bench.plan(row(X_BT->p + 0.02e-3 * out))) << row(target);
  });
  EXPECT_GT(offered, 3);
}

TEST(RowPlanner, row_that_goes_nowhere_has_no_pieces) {
  Bench bench("robot-arm-2");
  const auto motion = bench.plan("joint J1=0deg\n");
  ASSERT_TRUE(motion);
  EXPECT_TRUE(motion->pieces.empty());
  EXPECT_EQ(motion->rows, 1U);
  EXPECT_EQ(motion->q_end, start_of(bench.robot));
}

TEST(RowPlanner, loops_plan_each_motion_once_and_count_them_all) {
  const RobotModel robot = streaming_arm();
  const auto program = *parse(
      "loop 5000\nline y=40mm z=600mm\nline y=-40mm blend=5mm\nline z=620mm\nend\n", "p", robot);
  const auto plan = make_plan(program, robot, start_of(robot));
  ASSERT_TRUE(plan) << describe(plan.error().error);
  EXPECT_EQ(plan->orders.size(), 10'000U);
  EXPECT_EQ(plan->orders[1].line, 3);
  EXPECT_EQ(plan->orders[1].last_line, 4);
}

TEST(RowPlanner, tool_rows_need_a_known_start) {
  const RobotModel& robot = test::robot("learm");
  const auto plan = make_plan(*parse("line z=200mm", "p", robot), robot, std::nullopt);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().error.code, ErrorCode::kPositionUnknown);
}

}  // namespace
}  // namespace sinew::program
