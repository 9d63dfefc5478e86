#include <gtest/gtest.h>

#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/model/left_out.h"
#include "sinew/planning/collision/collision.h"
#include "sinew/planning/collision/collision_test_robot.h"

// A joint that is left out may be anywhere: what is clear with it is clear wherever it is.

namespace sinew::planning {
namespace {

RobotModel arm_without(std::initializer_list<std::size_t> joints) {
  RobotModel model = test::robot("robot-arm-2");
  for (const std::size_t joint : joints) {
    model.device.settings.get<AxisRegistersDevice>().boards[joint].homing_place = kLeftOut;
  }
  return model;
}

std::span<const double> span_of(const JointVector& q) {
  return {q.data(), q.size()};
}

TEST(CollisionLeftOut, some_pose_is_as_near_as_the_robot_is_wherever_the_joint_is) {
  const RobotModel whole = test::robot("robot-arm-2");
  const CollisionModel exact(whole);
  const std::vector<std::vector<std::size_t>> kOut{{2}, {0}, {5}, {1, 3}, {1, 2, 3, 4, 5}};
  for (const auto& out : kOut) {
    RobotModel model = whole;
    for (const std::size_t joint : out) {
      model.device.settings.get<AxisRegistersDevice>().boards[joint].homing_place = kLeftOut;
    }
    const CollisionModel open(model);
    EXPECT_LE(open.poses(), CollisionModel::kPosesMax);
    EXPECT_GT(open.poses(), 1U);
    test::for_random_cases(60, [&](test::Random& random) {
      const JointVector q = random_joints(model, random);
      double nearest = 1e9;
      for (std::size_t pose = 0; pose < open.poses(); ++pose) {
        nearest = std::min(nearest, open.distance_in(pose, span_of(q)).distance);
      }
      EXPECT_LE(nearest, exact.distance(span_of(q)).distance + 1e-9);
    });
  }
}

/// A motion of the others from a place that is clear passes only where it is clear with the joint
/// wherever it could be there.
TEST(CollisionLeftOut, path_that_passes_touches_nothing_wherever_the_joint_was) {
  const RobotModel model = arm_without({2});
  const CollisionModel open(model), exact(test::robot("robot-arm-2"));
  int passed = 0, looked = 0, refused = 0;
  test::for_random_cases(150, [&](test::Random& random) {
    JointVector from = random_joints(model, random);
    JointVector to = from;
    for (std::size_t j = 0; j < to.size(); ++j) {
      if (j == 2) continue;
      to[j] = std::clamp(to[j] + random.uniform(-0.3, 0.3), model.joints[j].lower,
                         model.joints[j].upper);
    }
    JointPath path(6, 1);
    path.append_line(from, to, 1);
    const bool passes = !open.check_leaving(path);
    (passes ? passed : refused) += 1;
    for (int k = 0; passes && k < 20; ++k) {
      const double q2 = random.uniform(model.joints[2].lower, model.joints[2].upper);
      from[2] = to[2] = q2;
      const double begun = exact.distance(span_of(from)).distance;
      if (begun < exact.margin()) continue;
      for (int step = 1; step <= 20; ++step) {
        JointVector at = from;
        for (std::size_t j = 0; j < at.size(); ++j) at[j] += step / 20.0 * (to[j] - from[j]);
        // No nearer than it was, but for what counts as at the margin.
        ASSERT_GE(exact.distance(span_of(at)).distance, 0) << "joint at " << q2;
        ++looked;
      }
    }
  });
  EXPECT_GT(passed, 10);
  EXPECT_GT(refused, 10);
  EXPECT_GT(looked, 1000);
}

TEST(CollisionLeftOut, arm_that_stands_up_may_turn_and_may_not_bow_to_the_table) {
  const RobotModel model = arm_without({2});
  const CollisionModel open(model);
  const auto passes = [&](const JointVector& from, const JointVector& to) {
    JointPath path(6, 1);
    path.append_line(from, to, 1);
    return !open.check_leaving(path);
  };
  const auto place = [&](double shoulder) { return degrees({0, shoulder, 0, 0, 0, 0}); };
  EXPECT_TRUE(passes(place(0), degrees({60, 0, 0, 0, 0, 0})));
  EXPECT_TRUE(passes(place(-80), place(0)));
  EXPECT_FALSE(passes(place(0), place(-80))) << "the forearm may hang down";
}

TEST(CollisionLeftOut, overlap_that_the_joint_has_no_part_in_excuses_nothing) {
  const RobotModel model = arm_without({5});
  const CollisionModel open(model), exact(test::robot("robot-arm-2"));
  // The forearm reaches into the table.
  JointVector from = degrees({0, -80, -60, 0, 0, 0}), to = degrees({0, -88, -60, 0, 0, 0});
  ASSERT_LT(exact.distance(span_of(from)).distance, -0.02);
  JointPath path(6, 1);
  path.append_line(from, to, 1);
  EXPECT_TRUE(exact.check_leaving(path));
  EXPECT_TRUE(open.check_leaving(path));
}

}  // namespace
}  // namespace sinew::planning
