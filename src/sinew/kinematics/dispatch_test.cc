// The version for wide vectors against the portable one. On a processor without them, and in a
// build with a sanitizer, both are the same.
#include "sinew/core/dispatch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/kinematics/serial_test_robot.h"

namespace sinew::kinematics {
namespace {

constexpr double kAgree = 1e-12;  // m and rad

void expect_same_pose(const PoseBF& A, const PoseBF& B) {
  ASSERT_LE(norm(A.p - B.p), kAgree);
  ASSERT_LE(norm(A.R.x - B.R.x), kAgree);
  ASSERT_LE(norm(A.R.y - B.R.y), kAgree);
  ASSERT_LE(norm(A.R.z - B.R.z), kAgree);
}

class WideVectors : public testing::TestWithParam<const char*> {
 protected:
  SerialRobot robot_{GetParam()};
};
INSTANTIATE_TEST_SUITE_P(Robots, WideVectors, testing::ValuesIn(kSerialRobots), test_name);

TEST_P(WideVectors, forward_and_jacobian_are_those_of_the_portable_version) {
  const SerialChain& chain = robot_.arm.chain();
  test::for_random_cases(100'000, [&](test::Random& random) {
    const JointVector q = robot_.random_joints(random);
    Jacobian J, J_portable;
    expect_same_pose(chain.forward(q), chain.forward_portable(q));
    expect_same_pose(chain.forward(q, J), chain.forward_portable(q, J_portable));
    ASSERT_EQ(J.size, J_portable.size);
    for (std::size_t i = 0; i < J.size; ++i) {
      ASSERT_LE(norm(J.v[i] - J_portable.v[i]), kAgree);
      ASSERT_LE(norm(J.w[i] - J_portable.w[i]), kAgree);
    }
  });
}

TEST(SixRWideVectors, every_branch_is_that_of_the_portable_version) {
  const SerialRobot robot("robot-arm-2");
  const auto solver = SixR::match(robot.geometry, robot.model.joints);
  ASSERT_TRUE(solver);
  std::uint64_t compared = 0;
  test::for_random_cases(100'000, [&](test::Random& random) {
    const JointVector q = robot.random_joints(random);
    const PoseBF X = robot.arm.chain().forward(q);
    const auto wide = solver->inverse(X, q);
    const auto portable = solver->inverse_portable(X, q);
    ASSERT_TRUE(wide && portable);
    ASSERT_EQ(wide->size(), portable->size());
    for (std::size_t k = 0; k < wide->size(); ++k) {
      const IkBranch& a = (*wide)[k];
      const IkBranch& b = (*portable)[k];
      expect_same_pose(robot.arm.chain().forward(a.q), robot.arm.chain().forward(b.q));
      ASSERT_EQ(a.singular, b.singular);
      // Rounding reaches the joints divided by the sines of the wrist's and the elbow's bend.
      if (std::abs(std::sin(a.q[4])) < 1e-2 || a.singular != 0) continue;
      for (std::size_t i = 0; i < 6; ++i) {
        ASSERT_NEAR(std::remainder(a.q[i] - b.q[i], 2 * kPi), 0, 100 * kAgree) << i;
      }
      ++compared;
    }
  });
  EXPECT_GT(compared, 600'000U);
}

}  // namespace
}  // namespace sinew::kinematics
