#include "sinew/control/path_motion.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/control/governor.h"
#include "sinew/planning/motion_planner.h"
#include "sinew/planning/paths/motion_limits.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::control {
namespace {

/// Its joints are so fast that a place is off by more than the governor's tolerance where a piece
/// is half a nanosecond longer than its motion.
RobotModel fast_arm() {
  RobotModel model = sinew::test::robot("puma560");
  model.collision = {};
  for (Joint& joint : model.joints) {
    joint.velocity_max *= 8;
    joint.acceleration_max *= 4;
  }
  return model;
}

TEST(PathMotion, pieces_of_a_fast_arm_pass_the_governor) {
  const RobotModel model = fast_arm();
  planning::MotionPlanner planner(model);
  planning::PlannedMotion planned = planner.make_motion();
  Governor governor(model, planning::motion_limits(model));
  sinew::test::for_random_cases(60, [&](sinew::test::Random& random) {
    const auto place = [&] {
      JointVector q;
      for (const Joint& joint : model.joints) q.push_back(random.uniform(joint.lower, joint.upper));
      return q;
    };
    const JointVector from = place(), to = place();
    const auto start = planner.place_at({from.data(), from.size()});
    ASSERT_TRUE(start);
    planning::Move move;
    planning::JointArray there{};
    std::ranges::copy(to, there.begin());
    move.way = planning::MoveJ{there};
    ASSERT_TRUE(planner.plan(*start, {&move, 1}, 0, planned));
    PathMotion motion(model);
    ASSERT_FALSE(motion.start(planned.path));
    governor.rest({from.data(), from.size()});
    while (const JointMove* piece = motion.next(Instant{})) {
      const auto passed = governor.pass(*piece);
      ASSERT_TRUE(passed) << describe(passed.error());
      motion.taken();
    }
    EXPECT_TRUE(motion.finished());
  });
}

}  // namespace
}  // namespace sinew::control
