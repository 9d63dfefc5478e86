// Jogs at what stops them: limits of joints, singularities, a platform's walls, contact.
#include <gtest/gtest.h>

#include <vector>

#include "sinew/planning/jog/jog_test_robot.h"

namespace sinew::planning {
namespace {

std::vector<double> from_degrees(std::initializer_list<double> q_deg) {
  std::vector<double> q;
  for (const double value : q_deg) q.push_back(from_deg(value));
  return q;
}

JogCommand tool_command(JogFrame frame, std::initializer_list<double> numbers) {
  JogCommand command;
  command.frame = frame;
  for (const double number : numbers) command.velocity.push_back(number);
  return command;
}

struct Slide {
  const char* robot;
  std::initializer_list<double> q_deg;
  std::initializer_list<double> velocity;  ///< m/s
  std::size_t joint;                       ///< that comes to its limit
  Vec3 free;                               ///< where the tool still goes
  double seconds;
  double way;  ///< m of it at least
};

TEST(JogBoundary, tool_slides_along_the_limit_of_a_joint) {
  const Slide kSlides[] = {
      {"robot-arm-2", {160, 30, -60, 0, 30, 0}, {-0.05, -0.05, 0}, 0, {-1, 0, 0}, 10, 0.15},
      {"puma560", {150, -20, -60, 0, 60, 0}, {0.05, -0.1, 0}, 0, {0.87, -0.5, 0}, 3, 0.05},
      {"bigrobotarm", {80, 40, 60, 0, 30}, {-0.03, 0.03, 0}, 0, {0, 1, 0}, 5, 0.05},
      {"learm", {80, 40, 60, 30, 0}, {-0.05, -0.03, 0}, 0, {0, -1, 0}, 1.5, 0.015},
      {"maxarm", {10, 70, 20}, {0.05, 0.1, 0}, 0, {0, 1, 0}, 2, 0.02},
  };
  for (const Slide& slide : kSlides) {
    SCOPED_TRACE(slide.robot);
    JogRun run(slide.robot);
    run.start(from_degrees(slide.q_deg));
    const Vec3 start = run.jog.pose().p;
    run.hold(tool_command(JogFrame::kBase, slide.velocity), slide.seconds, 0.002);
    ASSERT_FALSE(HasFatalFailure());
    const JogStatus status = run.jog.status();
    EXPECT_EQ(status.reason, JogReason::kJointLimit);
    EXPECT_EQ(status.joint, static_cast<int>(slide.joint));
    const Joint& joint = run.model.joints[slide.joint];
    const double q = run.jog.setpoint().q[slide.joint];
    EXPECT_LT(std::min(joint.upper - q, q - joint.lower), 1e-6);
    EXPECT_GE(dot(run.jog.pose().p - start, slide.free), slide.way);
    const Vec3 before = run.jog.pose().p;
    run.hold(tool_command(JogFrame::kBase, slide.velocity), 0.2, 0.002);
    EXPECT_GT(dot(run.jog.pose().p - before, slide.free), 1e-4) << "still going";
  }
}

struct WayOut {
  const char* robot;
  std::initializer_list<double> q_deg;
  std::initializer_list<double> velocity;  ///< m/s in base
  double seconds;
};

/// Where the Jacobian says that nothing can be done, exactly.
TEST(JogBoundary, stretched_arm_comes_back_from_the_singularity_itself) {
  const WayOut kWays[] = {
      {"puma560", {0, 0, -90, 0, 0, 0}, {-0.1, 0, 0}, 0.75},
      {"learm", {0, 0, 0, 0, 0}, {0, 0, -0.05}, 1.5},
      {"bigrobotarm", {0, 0, 0, 0, 0}, {0, 0, -0.03}, 5},
      {"bigrobotarm", {0, 90, 0, 0, 0}, {-0.03, 0, 0}, 5},
      {"learm", {0, 90, 0, 0, 0}, {-0.03, 0, 0}, 2},
  };
  for (const WayOut& way : kWays) {
    SCOPED_TRACE(way.robot);
    JogRun run(way.robot);
    run.start(from_degrees(way.q_deg));
    run.hold(tool_command(JogFrame::kBase, way.velocity), way.seconds, 0.002);
    ASSERT_FALSE(HasFatalFailure());
    EXPECT_GT(run.jog.status().share, 0.3);
    const Vec3 wanted{way.velocity.begin()[0], way.velocity.begin()[1], way.velocity.begin()[2]};
    const Vec3 before = run.jog.pose().p;
    run.hold(tool_command(JogFrame::kBase, way.velocity), 0.2, 0.002);
    const Vec3 gone = run.jog.pose().p - before;
    EXPECT_GT(dot(gone, wanted), 0.99 * norm(gone) * norm(wanted)) << "straight where it was sent";
  }
}

/// The wrist of a six-joint arm goes from one side of its singularity to the other without any
/// other joint noticing.
TEST(JogBoundary, bend_goes_through_the_wrist_singularity) {
  for (const char* robot : {"robot-arm-2", "puma560"}) {
    JogRun run(robot);
    const auto q = from_degrees({20, -30, -40, 0, 12, 5});
    run.start(q);
    // About the axis of the bend.
    TaskJacobian J;
    JointArray at{};
    std::copy(q.begin(), q.end(), at.begin());
    run.jog.space().look(JogFrame::kTool, at, J);
    JogCommand command;
    command.frame = JogFrame::kTool;
    for (std::size_t k = 0; k < 6; ++k) {
      command.velocity.push_back(-0.2 * J.column[4][k] / run.jog.space().scale(k));
    }
    run.hold(command, 5, 0.002);
    ASSERT_FALSE(HasFatalFailure());
    EXPECT_LT(run.jog.setpoint().q[4], from_deg(-12));
    for (const std::size_t j : {0U, 1U, 2U, 3U, 5U}) {
      EXPECT_NEAR(run.jog.setpoint().q[j], q[j], from_deg(2)) << "J" << j + 1;
    }
  }
}

TEST(JogBoundary, joint_outside_of_its_limits_goes_back_in_and_no_farther_out) {
  JogRun run("robot-arm-2");
  auto q = run.home();
  const Joint& joint = run.model.joints[1];
  q[1] = joint.upper + from_deg(3);
  std::vector<motion::AxisState> states;
  for (const double value : q) states.push_back({value, 0, 0});
  ASSERT_FALSE(run.jog.start(states, run.now));
  JogCommand command;
  command.velocity.resize(6);
  const auto drive = [&](double velocity, double seconds) {
    command.velocity[1] = velocity;
    for (double t = 0; t < seconds; t += 0.002) {
      ASSERT_FALSE(run.jog.command(command, run.now));
      run.now += from_seconds(0.002);
      ASSERT_FALSE(run.jog.step(run.now));
      ASSERT_LE(run.jog.setpoint().q[1], q[1] + 1e-12);
    }
  };
  drive(0.2, 1);
  EXPECT_EQ(run.jog.setpoint().q[1], q[1]);
  drive(-0.2, 3);
  EXPECT_LT(run.jog.setpoint().q[1], joint.upper);
  drive(0.2, 5);
  EXPECT_LT(run.jog.setpoint().q[1], q[1] + 1e-12);
}

TEST(JogBoundary, tool_drives_a_joint_outside_of_its_limits_only_inwards) {
  JogRun run("robot-arm-2");
  std::vector<motion::AxisState> states;
  for (const double q : from_degrees({0, 20, -60, 30, 40, 361})) states.push_back({q, 0, 0});
  for (const double turn : {0.2, -0.2}) {
    ASSERT_FALSE(run.jog.start(states, run.now));
    const auto command = tool_command(JogFrame::kTool, {0.01, 0, 0, 0, 0, turn});
    double least = states[5].q;
    for (int k = 0; k < 1500; ++k) {
      ASSERT_FALSE(run.jog.command(command, run.now));
      run.now += from_seconds(0.002);
      ASSERT_FALSE(run.jog.step(run.now));
      ASSERT_LE(run.jog.setpoint().q[5], states[5].q + 1e-12);
      least = std::min(least, run.jog.setpoint().q[5]);
    }
    EXPECT_EQ(turn < 0, least < from_deg(360));
  }
}

/// After homing it lies folded, its forearm in its upper arm, and opening leads deeper at first.
TEST(JogBoundary, robot_that_overlaps_can_be_driven_out_by_its_joints_slowly) {
  JogRun run("robot-arm-2", true);
  const CollisionModel collision(run.model);
  const auto folded = from_degrees({-169, -89, -134, -169, -119, -359});
  const double depth = collision.distance(folded).distance;
  ASSERT_LT(depth, -0.03);
  JogCommand command;
  command.velocity.resize(6);
  for (std::size_t j = 0; j < 6; ++j) {
    run.start(folded);
    for (double& velocity : command.velocity) velocity = 0;
    command.velocity[j] = run.limits[j].velocity;
    run.hold(command, 0.5, 0.002);
    ASSERT_FALSE(HasFatalFailure());
    EXPECT_EQ(run.jog.status().reason, JogReason::kOverlap) << "J" << j + 1;
    EXPECT_LT(run.jog.status().distance, -0.03);
    EXPECT_LE(std::abs(run.last.qd[j]), 0.1 * run.limits[j].velocity * (1 + 1e-9));
    EXPECT_GT(run.last.q[j] - folded[j], from_deg(0.1)) << "J" << j + 1;
  }
  // Up with the upper arm while the elbow opens, until it is clear, and quick again.
  run.start(folded);
  command.velocity = {0, run.limits[1].velocity, run.limits[2].velocity, 0, 0, 0};
  double deepest = depth;
  for (int k = 0; k < 600 && run.jog.overlap(); ++k) {
    deepest = std::min(deepest, run.jog.overlap().value_or(0));
    run.hold(command, 0.1, 0.01);
    ASSERT_FALSE(HasFatalFailure());
  }
  EXPECT_LT(deepest, depth - 1e-3) << "deeper before it is out";
  EXPECT_FALSE(run.jog.overlap());
  run.hold(command, 3, 0.01);
  EXPECT_GT(run.last.qd[2], 0.5 * run.limits[2].velocity);
  // Now there is no way back in.
  for (double& number : command.velocity) number = -number;
  for (int k = 0; k < 30; ++k) {
    run.hold(command, 1, 0.01);
    ASSERT_FALSE(HasFatalFailure());
    const std::span q(run.jog.setpoint().q.data(), run.joints());
    ASSERT_GE(collision.distance(q).distance, collision.margin() - Jog::kOverlapDepth);
  }
  EXPECT_EQ(run.jog.status().reason, JogReason::kContact);
}

/// Along a line from home, as far as the platform may go.
PoseBT last_allowed(const JogRun& run, const Vec3& turn, const Vec3& shift, double short_of) {
  const ToolSpace& tool = run.jog.space().tool();
  const PoseBT X_home = tool.home();
  const auto at = [&](double s) {
    return PoseBT{rotation_from_vector(s * turn) * X_home.R, X_home.p + s * shift};
  };
  double inside = 0;
  double outside = 1;
  for (int k = 0; k < 60; ++k) {
    const double s = (inside + outside) / 2;
    const auto X_BP = relabel<frame::Base, frame::Platform>(at(s));
    (tool.hexapod()->check(X_BP, run.model.joints).empty() ? inside : outside) = s;
  }
  return at(inside - short_of);
}

TEST(JogBoundary, platform_slides_along_its_walls_and_comes_back) {
  const struct {
    const char* what;
    Vec3 turn, shift, along;
    JogReason reason;
  } kWalls[] = {
      {"leg length", {}, {0, 0, 0.2}, {1, 0, 0}, JogReason::kJointLimit},
      {"shift", {}, {0.3, 0, 0}, {0, 1, 0}, JogReason::kNone},
      {"tilt", {0.9, 0, 0}, {}, {0, 0, -1}, JogReason::kNone},
      {"turn", {0, 0, 1.5}, {}, {0, 0, -1}, JogReason::kNone},
  };
  for (const auto& wall : kWalls) {
    SCOPED_TRACE(wall.what);
    JogRun run("hexapod");
    run.X_near = last_allowed(run, wall.turn, wall.shift, 2e-6);
    const ToolSpace& tool = run.jog.space().tool();
    const auto legs = tool.inverse_near(tool.point(run.X_near), {});
    run.start({legs->begin(), legs->begin() + kLegs});
    const double speed = 4e-6;
    const Vec3 v =
        speed * (norm(wall.shift) > 0 ? normalized(wall.shift) : Vec3{}) + speed * wall.along;
    const Vec3 w = 10 * speed * (norm(wall.turn) > 0 ? normalized(wall.turn) : Vec3{});
    const auto command = tool_command(JogFrame::kBase, {v.x, v.y, v.z, w.x, w.y, w.z});
    const Vec3 start = run.jog.pose().p;
    bool met = false;
    for (int k = 0; k < 50; ++k) {
      run.hold(command, 0.1, 0.005);
      ASSERT_FALSE(HasFatalFailure());
      const JogReason reason = run.jog.status().reason;
      met = met || reason == wall.reason ||
            (wall.reason == JogReason::kNone &&
             (reason == JogReason::kJointLimit || reason == JogReason::kPoseLimit));
    }
    EXPECT_TRUE(met);
    EXPECT_GT(dot(run.jog.pose().p - start, wall.along), 0.2 * 5 * speed);
    const auto X_BP = relabel<frame::Base, frame::Platform>(run.jog.pose());
    EXPECT_TRUE(tool.hexapod()->check(X_BP, run.model.joints).empty());
    const PoseBT X_stuck = run.jog.pose();
    run.hold(tool_command(JogFrame::kBase, {-v.x, -v.y, -v.z, -w.x, -w.y, -w.z}), 2, 0.005);
    EXPECT_GT(run.jog.status().share, 0.9);
    EXPECT_LT(dot(run.jog.pose().p - X_stuck.p, v), 0);
  }
}

TEST(JogBoundary, robot_stops_before_it_touches_its_table_and_goes_up_again) {
  for (const char* robot : {"robot-arm-2", "puma560", "learm", "bigrobotarm", "maxarm"}) {
    SCOPED_TRACE(robot);
    JogRun run(robot, true);
    const CollisionModel collision(run.model);
    test::Random random(7);
    int touched = 0;
    for (int attempt = 0; attempt < 40 && touched < 3; ++attempt) {
      const auto q = run.random_place(random);
      if (!collision.clear(q, collision.margin() + 0.01)) continue;
      run.start(q);
      const auto down = tool_command(JogFrame::kBase, {0, 0, -run.tool_speed()});
      double least = 1;
      for (int k = 0; k < 300; ++k) {
        run.hold(down, 0.02, 0.004);
        ASSERT_FALSE(HasFatalFailure());
        const auto& at = run.jog.setpoint();
        least = std::min(least, collision.distance({at.q.data(), run.joints()}).distance);
        if (run.jog.status().reason == JogReason::kContact && run.jog.at_rest()) break;
      }
      EXPECT_GE(least, collision.margin() - 2e-3) << testing::PrintToString(q);
      if (run.jog.status().reason != JogReason::kContact) continue;
      ++touched;
      run.settle(0.004);
      const double low = run.jog.pose().p.z;
      run.hold(tool_command(JogFrame::kBase, {0, 0, run.tool_speed()}), 2, 0.004);
      EXPECT_GT(run.jog.pose().p.z, low + 1e-4) << testing::PrintToString(q);
    }
    EXPECT_GT(touched, 0);
  }
}

}  // namespace
}  // namespace sinew::planning
