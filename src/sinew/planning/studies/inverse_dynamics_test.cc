#include "sinew/planning/studies/inverse_dynamics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/kinematics/serial_arm.h"
#include "support/allocation_guard.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::planning {
namespace {

constexpr std::array kRobots{"robot-arm-2", "learm", "bigrobotarm", "maxarm", "hexapod"};

class RobotTorque : public testing::TestWithParam<const char*> {
 protected:
  /// Inside the workspace; legs near home, where every combination is a pose.
  JointVector random_joints(test::Random& random) const {
    JointVector q;
    for (const Joint& joint : model_.joints) {
      const bool leg = joint.kind == JointKind::kPrismatic;
      q.push_back(leg ? 0.26836 + random.uniform(-0.01, 0.01)
                      : random.uniform(joint.lower, joint.upper));
    }
    return q;
  }
  JointVector random_vector(test::Random& random, double most) const {
    JointVector v;
    for (std::size_t i = 0; i < model_.joints.size(); ++i) v.push_back(random.uniform(-most, most));
    return v;
  }
  JointVector still() const {
    JointVector q;
    q.resize(model_.joints.size());
    return q;
  }

  const RobotModel& model_ = test::robot(GetParam());
};
INSTANTIATE_TEST_SUITE_P(FiveRobots, RobotTorque, testing::ValuesIn(kRobots),
                         [](const testing::TestParamInfo<const char*>& robot) {
                           std::string name = robot.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(RobotTorque, parts_and_speed_make_up_the_whole) {
  test::for_random_cases(200, [&](test::Random& random) {
    const InverseDynamics dynamics(model_, random.uniform(0, 2));
    const JointVector q = random_joints(random);
    const JointVector qd = random_vector(random, 1), qdd = random_vector(random, 3);
    const auto parts = dynamics.parts(q);
    const auto whole = dynamics.torque(q, {qd, qdd});
    const auto by_speed = dynamics.torque(q, {qd, still()}, 0);
    ASSERT_TRUE(parts && whole && by_speed);
    for (std::size_t i = 0; i < q.size(); ++i) {
      double sum = parts->weight[i] + (*by_speed)[i];
      for (std::size_t j = 0; j < q.size(); ++j) sum += parts->inertia[i][j] * qdd[j];
      ASSERT_NEAR((*whole)[i], sum, 1e-9);
    }
  });
}

TEST_P(RobotTorque, payload_costs_what_lifting_it_gains) {
  // Virtual work of the payload alone: torque on joint i is m g times the rise of its point.
  test::for_random_cases(200, [&](test::Random& random) {
    const JointVector q = random_joints(random);
    const double mass = random.uniform(0.1, 2);
    const InverseDynamics with(model_, mass), without(model_, 0);
    const auto loaded = with.torque(q, {still(), still()});
    const auto bare = without.torque(q, {still(), still()});
    ASSERT_TRUE(loaded && bare);
    for (std::size_t i = 0; i < q.size(); ++i) {
      constexpr double kStep = 1e-6;
      JointVector more = q, less = q;
      more[i] += kStep;
      less[i] -= kStep;
      const auto high = with.payload_point(more), low = with.payload_point(less);
      ASSERT_TRUE(high && low);
      const double rise = (high->z - low->z) / (2 * kStep);
      EXPECT_NEAR((*loaded)[i] - (*bare)[i], mass * kinematics::kGravity * rise, 1e-6);
    }
  });
}

TEST_P(RobotTorque, largest_torque_by_speed_is_above_that_of_every_way) {
  test::for_random_cases(30, [&](test::Random& random) {
    const InverseDynamics dynamics(model_, 0.5);
    const JointVector q = random_joints(random);
    JointVector qd = random_vector(random, 1);
    for (double& rate : qd) rate = std::abs(rate);
    for (std::size_t i = 0; i < q.size(); ++i) {
      const auto most = dynamics.torque_by_speed(q, qd, i, std::nullopt);
      for (int k = 0; k < 40; ++k) {
        JointVector way = qd;
        for (double& rate : way) rate = random.chance(0.5) ? rate : -rate;
        const auto torque = dynamics.torque(q, {way, still()}, 0);
        ASSERT_TRUE(torque.has_value());
        EXPECT_LE((*torque)[i], most.down + 1e-12);
        EXPECT_LE(-(*torque)[i], most.up + 1e-12);
      }
    }
  });
}

TEST_P(RobotTorque, never_allocates) {
  InverseDynamics dynamics(model_, 0.1);
  JointVector q = still();
  for (std::size_t i = 0; i < q.size(); ++i) {
    q[i] = model_.joints[i].kind == JointKind::kPrismatic ? 0.26836 : model_.joints[i].home;
  }
  double sum = 0;
  const test::AllocationCounter allocations;
  for (int i = 0; i < 100; ++i) {
    dynamics.set_payload(1e-3 * i);
    sum += dynamics.torque(q, {still(), still()})->back() + dynamics.parts(q)->weight[0];
  }
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

TEST(RobotTorqueOfGripper, payload_hangs_between_closed_jaws) {
  const RobotModel& model = test::robot("learm");
  const auto& geometry = std::get<SerialGeometry>(model.geometry);
  const kinematics::SerialArm arm(geometry, model.joints, kinematics::tool_pose(geometry, 0.0));
  const JointVector q{0.3, 0.5, 0.2, -0.4, 0.1};
  const auto p = InverseDynamics(model, 1).payload_point(q);
  ASSERT_TRUE(p.has_value());
  EXPECT_NEAR(norm(*p - arm.forward(q).p), 0, 1e-12);
}

}  // namespace
}  // namespace sinew::planning
