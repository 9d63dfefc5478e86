#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "sinew/planning/jog/jog.h"
#include "sinew/planning/paths/motion_limits.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::planning {

inline constexpr std::array kJogRobots{"robot-arm-2", "puma560", "learm",
                                       "bigrobotarm", "maxarm",  "hexapod"};

inline std::string jog_robot_name(const testing::TestParamInfo<const char*>& robot) {
  std::string name = robot.param;
  for (char& letter : name) letter = letter == '-' ? '_' : letter;
  return name;
}

/// A robot of the product being jogged, with every limit looked at in every step.
struct JogRun {
  explicit JogRun(std::string_view id, bool avoid_contact = false)
      : model(test::robot(id)), jog(model, {.avoid_contact = avoid_contact}) {
    for (const Joint& joint : model.joints) {
      const double share = model.device.capability.limits_share;
      limits.push_back(
          {share * joint.velocity_max, share * joint.acceleration_max, share * joint.jerk_max});
      checks.emplace_back(limits.back(), motion::PositionRange{joint.lower, joint.upper});
    }
  }

  std::size_t joints() const { return limits.size(); }
  bool is_hexapod() const { return jog.space().tool().hexapod() != nullptr; }

  std::vector<double> home() {
    std::vector<double> q;
    if (!is_hexapod()) {
      for (const Joint& joint : model.joints) q.push_back(joint.home);
      return q;
    }
    const ToolSpace& tool = jog.space().tool();
    X_near = tool.home();
    const auto legs = tool.inverse_near(tool.point(X_near), {});
    q.assign(legs->begin(), legs->begin() + kLegs);
    return q;
  }

  /// At rest somewhere that the robot can be; every fourth joint exactly at a limit or at 0.
  std::vector<double> random_place(test::Random& random) {
    std::vector<double> q(joints());
    PoseBT X = jog.space().tool().home();
    do {
      if (is_hexapod()) {
        const auto some = [&](double scale) {
          return Vec3{random.uniform(-scale, scale), random.uniform(-scale, scale),
                      random.uniform(-scale, scale)};
        };
        const PoseBT X_home = jog.space().tool().home();
        const ToolSpace& tool = jog.space().tool();
        X = {rotation_from_vector(some(0.4)) * X_home.R, X_home.p + some(0.06)};
        const auto legs = tool.inverse_near(tool.point(X), {});
        q.assign(legs->begin(), legs->begin() + kLegs);
        continue;
      }
      for (std::size_t j = 0; j < joints(); ++j) {
        const Joint& joint = model.joints[j];
        q[j] = random.uniform(joint.lower, joint.upper);
        if (random.chance(0.1)) q[j] = std::clamp(0.0, joint.lower, joint.upper);
        if (random.chance(0.15)) q[j] = random.chance(0.5) ? joint.lower : joint.upper;
      }
    } while (!can_be(q, X));
    X_near = X;
    return q;
  }
  bool can_be(const std::vector<double>& q, const PoseBT& X) const {
    JointArray array{};
    for (std::size_t j = 0; j < joints(); ++j) {
      if (!within_limits(model.joints[j], q[j])) return false;
      array[j] = q[j];
    }
    return jog.space().violation(array, X) == 0;
  }

  void start(const std::vector<double>& q) {
    std::vector<motion::AxisState> states;
    for (const double value : q) states.push_back({value, 0, 0});
    if (!is_hexapod()) X_near = {};
    const auto error = jog.start(states, now, is_hexapod() ? &X_near : nullptr);
    ASSERT_FALSE(error) << describe(*error);
    last = jog.setpoint();
  }

  /// What this robot takes for quick: m/s.
  double tool_speed() const {
    double speed = 1;
    for (const auto& limit : limits) speed = std::min(speed, limit.velocity);
    return is_hexapod() ? speed : 0.5 * speed / jog.space().scale(0);
  }

  JogCommand random_command(test::Random& random) const {
    constexpr std::array kFrames{JogFrame::kJoint, JogFrame::kBase, JogFrame::kTool,
                                 JogFrame::kPlatform};
    JogCommand command;
    command.frame = kFrames[static_cast<std::size_t>(random.integer(0, is_hexapod() ? 3 : 2))];
    const std::size_t count = jog.space().numbers(command.frame);
    const bool point = command.frame != JogFrame::kJoint && random.chance(0.4);
    const double quick = std::pow(10, random.uniform(-1.5, 1));
    for (std::size_t k = 0; k < (point ? 3 : count); ++k) {
      double scale = command.frame == JogFrame::kJoint ? limits[k].velocity : tool_speed();
      if (command.frame != JogFrame::kJoint && k >= 3) scale *= 2 * jog.space().scale(0);
      command.velocity.push_back(random.chance(0.3) ? 0 : quick * scale * random.uniform(-1, 1));
    }
    return command;
  }

  /// One cycle, with everything held against its limits.
  void step(double seconds) {
    now += from_seconds(seconds);
    const double dt = to_seconds(from_seconds(seconds));
    const auto error = jog.step(now);
    ASSERT_FALSE(error) << describe(*error);
    const motion::AxisStates& state = jog.setpoint();
    double speeds = 0;
    for (std::size_t j = 0; j < joints(); ++j) {
      speeds += std::abs(state.qd[j]);
      const auto& [velocity, acceleration, jerk] = limits[j];
      constexpr double kRounding = 1 + 1e-9;
      ASSERT_TRUE(std::isfinite(state.q[j]) && std::isfinite(state.qd[j])) << "J" << j + 1;
      ASSERT_LE(std::abs(state.qd[j]), velocity * kRounding) << "J" << j + 1;
      ASSERT_LE(std::abs(state.qdd[j]), acceleration * kRounding) << "J" << j + 1;
      ASSERT_LE(std::abs(state.qdd[j] - last.qdd[j]), jerk * dt * kRounding + 1e-9 * acceleration)
          << "J" << j + 1;
      // Without jerk it would be here; what jerk makes of it is bounded.
      const double ahead = last.q[j] + dt * (last.qd[j] + dt / 2 * last.qdd[j]);
      ASSERT_LE(std::abs(state.q[j] - ahead), jerk * dt * dt * dt / 6 * kRounding + 1e-12)
          << "J" << j + 1;
      const Joint& joint = model.joints[j];
      const double rest = checks[j].stop({state.q[j], state.qd[j], state.qdd[j]}).target();
      for (const double q : {state.q[j], rest}) {
        ASSERT_GE(q, joint.lower - 1e-9) << "J" << j + 1;
        ASSERT_LE(q, joint.upper + 1e-9) << "J" << j + 1;
      }
    }
    shared_worst = std::max(shared_worst, speeds / shared_velocity(model));
    last = state;
  }

  /// Holds a command for so long, renewed as somebody with a stick does.
  void hold(const JogCommand& command, double seconds, double dt = 1e-3, double renew = 0.05) {
    double left = 0;
    for (double t = 0; t < seconds - 1e-9; t += dt) {
      if (left <= 1e-9) {
        ASSERT_FALSE(jog.command(command, now));
        left = renew;
      }
      step(dt);
      if (testing::Test::HasFatalFailure()) return;
      left -= dt;
    }
  }
  /// Until it stands still; how long that took, s.
  double settle(double dt = 1e-3) {
    jog.stop();
    double t = 0;
    for (; !jog.at_rest() && t < 60; t += dt) {
      step(dt);
      if (testing::Test::HasFatalFailure()) break;
    }
    EXPECT_TRUE(jog.at_rest());
    return t;
  }

  const RobotModel& model;
  Jog jog;
  std::vector<motion::AxisLimits> limits;
  std::vector<JogJoint> checks;
  Instant now{};
  PoseBT X_near;
  motion::AxisStates last{};
  double shared_worst = 0;  ///< of what all joints share, so far
};

}  // namespace sinew::planning
