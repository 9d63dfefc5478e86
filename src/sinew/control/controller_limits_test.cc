#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "sinew/control/controller_test_cell.h"
#include "sinew/core/error_code.h"
#include "sinew/planning/paths/motion_limits.h"

/// What bounds a controller holds its governor to: those of its robot, no others.
namespace sinew::control::test {
namespace {

/// Speeds up over `time` to `speed`, and comes to rest over as long.
PieceMotion pulse(const ControlCell& cell, std::size_t joint, double speed, double time) {
  const JointVector from = *cell.controller.reference();
  JointMove up{.q = from, .qd = {}, .duration = from_seconds(time)};
  up.qd.resize(from.size());
  up.q[joint] += speed * time / 2;
  up.qd[joint] = speed;
  JointMove down = up;
  down.q[joint] += speed * time / 2;
  down.qd[joint] = 0;
  return {from, {up, down}, cell.robot};
}

/// @return  how the motion ended
ControlEvent ended(std::size_t joint, double speed, double time) {
  ControlCell cell("learm");
  // Room to get up to speed.
  cell.robot.joints[joint].lower = -100;
  cell.robot.joints[joint].upper = 100;
  cell.make_ready();
  PieceMotion motion = pulse(cell, joint, speed, time);
  const std::uint32_t id = cell.give(Begin{&motion});
  EXPECT_TRUE(cell.run_until([&] { return cell.end_of(id).has_value(); }));
  return cell.end_of(id).value_or(ControlEvent{});
}

struct Bound {
  ErrorCode code;
  double speed;
  double time;
};

TEST(ControllerLimits, velocity_acceleration_and_jerk_are_those_of_the_robot) {
  const ControlCell cell("learm");
  const auto limits = planning::farthest_limits(cell.robot);
  int accelerations = 0;
  // Base and roll: they turn without coming near anything.
  for (const std::size_t joint : {0U, 4U}) {
    const auto& [v, a, j] = limits[joint];
    // Each well inside the other two.
    const double brief = std::min(a / j, std::sqrt(v / j));
    std::vector<Bound> bounds{
        {ErrorCode::kVelocityLimit, v, 2 * std::max(v / a, std::sqrt(2 * v / j))},
        {ErrorCode::kJerkLimit, j * brief * brief / 2, brief}};
    const double longer = 2.2 * a / j;
    if (1.05 * a * longer <= v) {
      bounds.push_back({ErrorCode::kAccelerationLimit, a * longer, longer});
    }
    accelerations += static_cast<int>(bounds.size()) - 2;
    for (const Bound& bound : bounds) {
      EXPECT_EQ(ended(joint, 0.99 * bound.speed, bound.time).kind, ControlEvent::Kind::kDone)
          << info(bound.code).name;
      const ControlEvent refused = ended(joint, 1.01 * bound.speed, bound.time);
      EXPECT_EQ(refused.error.code, bound.code);
      EXPECT_EQ(refused.error.index, static_cast<int>(joint));
      EXPECT_NEAR(refused.error.measured, 1.01, 0.001) << "times what is allowed";
    }
  }
  EXPECT_GT(accelerations, 0) << "of some joint the velocity leaves room for it";
}

}  // namespace
}  // namespace sinew::control::test
