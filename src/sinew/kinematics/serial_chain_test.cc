#include "sinew/kinematics/serial_chain.h"

#include <gtest/gtest.h>

#include "sinew/core/units.h"
#include "sinew/kinematics/serial_test_robot.h"
#include "support/allocation_guard.h"

namespace sinew::kinematics {
namespace {

JointVector degrees(std::initializer_list<double> q_deg) {
  JointVector q;
  for (const double angle : q_deg) q.push_back(from_deg(angle));
  return q;
}

void expect_near_mm(const Vec3& p, const Vec3& expected_mm, double tolerance_mm) {
  EXPECT_LE(1e3 * norm(p - 1e-3 * expected_mm), tolerance_mm)
      << to_mm(p.x) << " " << to_mm(p.y) << " " << to_mm(p.z);
}

class SerialChains : public testing::TestWithParam<const char*> {
 protected:
  SerialRobot robot_{GetParam()};
};
INSTANTIATE_TEST_SUITE_P(Robots, SerialChains, testing::ValuesIn(kSerialRobots), test_name);

TEST_P(SerialChains, forward_and_jacobian_agree_with_kdl) {
  const KDL::Chain chain = robot_.kdl_chain();
  KDL::ChainFkSolverPos_recursive forward(chain);
  KDL::ChainJntToJacSolver jacobian(chain);
  const auto n = static_cast<unsigned>(robot_.geometry.rows.size());
  KDL::JntArray q_kdl(n);
  KDL::Frame frame;
  KDL::Jacobian J_kdl(n);
  test::for_random_cases(100'000, [&](test::Random& random) {
    const JointVector q = robot_.random_joints(random);
    for (unsigned i = 0; i < n; ++i) q_kdl(i) = q[i];
    forward.JntToCart(q_kdl, frame);
    jacobian.JntToJac(q_kdl, J_kdl);
    Jacobian J;
    const PoseBF X = robot_.arm.chain().forward(q, J);
    for (unsigned row = 0; row < 3; ++row) {
      const auto at = [&](const Vec3& v) { return std::array{v.x, v.y, v.z}[row]; };
      ASSERT_NEAR(at(X.p), frame.p(static_cast<int>(row)), 1e-9);
      ASSERT_NEAR(at(X.R.x), frame.M(static_cast<int>(row), 0), 1e-9);
      ASSERT_NEAR(at(X.R.y), frame.M(static_cast<int>(row), 1), 1e-9);
      ASSERT_NEAR(at(X.R.z), frame.M(static_cast<int>(row), 2), 1e-9);
      for (unsigned i = 0; i < n; ++i) {
        ASSERT_NEAR(at(J.v[i]), J_kdl(row, i), 1e-9);
        ASSERT_NEAR(at(J.w[i]), J_kdl(row + 3, i), 1e-9);
      }
    }
    ASSERT_LT(position_error(relabel<frame::Base, frame::Tool>(robot_.arm.chain().forward(q)),
                             relabel<frame::Base, frame::Tool>(X)),
              1e-15);
  });
}

TEST_P(SerialChains, jacobian_is_the_derivative_of_forward) {
  const double h = 1e-6;
  const SerialChain& chain = robot_.arm.chain();
  test::for_random_cases(100'000, [&](test::Random& random) {
    const JointVector q = robot_.random_joints(random);
    Jacobian J;
    chain.forward(q, J);
    const auto i =
        static_cast<std::size_t>(random.integer(0, static_cast<std::int64_t>(q.size()) - 1));
    JointVector before = q;
    JointVector after = q;
    before[i] -= h;
    after[i] += h;
    const PoseBF X_before = chain.forward(before);
    const PoseBF X_after = chain.forward(after);
    ASSERT_LT(norm((0.5 / h) * (X_after.p - X_before.p) - J.v[i]), 1e-8);
    const Vec3 w = (0.5 / h) * rotation_vector(X_after.R * X_before.R.transposed());
    ASSERT_LT(norm(w - J.w[i]), 1e-8);
  });
}

TEST_P(SerialChains, product_of_links_is_forward) {
  test::for_random_cases(1'000, [&](test::Random& random) {
    const JointVector q = robot_.random_joints(random);
    PoseBF X;
    for (std::size_t i = 0; i < q.size(); ++i) {
      const PoseBF X_link = robot_.arm.chain().link(i, q[i]);
      X = {X.R * X_link.R, X.R * X_link.p + X.p};
    }
    ASSERT_LT(norm(X.p - robot_.arm.chain().forward(q).p), 1e-14);
  });
}

TEST_P(SerialChains, nothing_allocates) {
  test::Random random(1);
  const JointVector q = robot_.random_joints(random);
  const test::AllocationCounter allocations;
  Jacobian J;
  const PoseBF X = robot_.arm.chain().forward(q, J);
  const Dexterity d = dexterity(J, robot_.arm.chain().reach(robot_.model.joints));
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_GE(d.manipulability, 0) << norm(X.p);
}

TEST(SerialChain, robot_arm_2_stands_where_its_reference_says) {
  const SerialRobot robot("robot-arm-2");
  const PoseBT X_home = robot.arm.forward(degrees({0, 0, 0, 0, 0, 0}));
  expect_near_mm(X_home.p, {365, 0, 620}, 1e-6);
  EXPECT_LT(norm(X_home.R.x - Vec3{0, 0, 1}) + norm(X_home.R.z - Vec3{1, 0, 0}), 1e-12);
  expect_near_mm(robot.arm.forward(degrees({30, -45, 60, 20, 40, -10})).p,
                 {466.022046, 243.672288, 672.963154}, 1e-6);
  expect_near_mm(robot.arm.forward(degrees({10, 20, 30, 40, 50, 60})).p,
                 {32.673004, -44.238868, 874.891108}, 1e-6);
  expect_near_mm(robot.arm.forward(degrees({-120, 30, -60, 100, -70, 200})).p,
                 {14.005756, -160.824634, 436.299587}, 1e-6);
}

TEST_P(SerialChains, frames_are_the_product_of_the_links_before_them) {
  const SerialChain& chain = robot_.arm.chain();
  std::vector<PoseBL> X(chain.size());
  test::for_random_cases(20'000, [&](test::Random& random) {
    const JointVector q = robot_.random_joints(random);
    const test::AllocationCounter allocations;
    chain.frames(q, X);
    ASSERT_EQ(allocations.count(), 0U);
    PoseBL product;
    for (std::size_t i = 0; i < chain.size(); ++i) {
      product = product * relabel<frame::Link, frame::Link>(chain.link(i, q[i]));
      ASSERT_LE(norm(X[i].p - product.p), 1e-14);
      ASSERT_LE(norm(X[i].R.x - product.R.x), 1e-14);
      ASSERT_LE(norm(X[i].R.y - product.R.y), 1e-14);
      ASSERT_LE(norm(X[i].R.z - product.R.z), 1e-14);
    }
    ASSERT_EQ(X.back().p, chain.forward(q).p);
  });
}

TEST(SerialChain, placeholder_table_of_robot_arm_2_gives_its_reference_positions) {
  // The maker's first table, with parallel axes 2, 3 and 4: no wrist, but forward must hold.
  SerialGeometry geometry;
  const double right = from_deg(90);
  geometry.rows = {{0.1, 0, right, 0}, {0, 0.25, 0, 0},   {0, 0.25, 0, 0},
                   {0, 0, right, 0},   {0, 0, -right, 0}, {0.08, 0, 0, 0}};
  const SerialChain chain(geometry);
  expect_near_mm(chain.forward(degrees({0, 0, 0, 0, 0, 0})).p, {500, -80, 100}, 1e-6);
  expect_near_mm(chain.forward(degrees({30, -45, 60, 20, 40, -10})).p,
                 {356.384147, 134.994329, -41.566960}, 1e-6);
  expect_near_mm(chain.forward(degrees({10, 20, 30, 40, 50, 60})).p,
                 {398.539212, 18.056924, 315.732591}, 1e-6);
  expect_near_mm(chain.forward(degrees({-120, 30, -60, 100, -70, 200})).p,
                 {-253.057954, -383.586010, 170.641778}, 1e-6);
}

TEST(SerialChain, manipulability_vanishes_where_the_wrist_is_straight) {
  const SerialRobot robot("robot-arm-2");
  Jacobian J;
  robot.arm.chain().forward(degrees({0, 0, 0, 0, 0, 0}), J);
  const Dexterity home = dexterity(J, robot.arm.chain().reach(robot.model.joints));
  EXPECT_LT(home.singular_value_min, 1e-12);
  EXPECT_LT(home.manipulability, 1e-12);
  robot.arm.chain().forward(degrees({0, 0, 0, 0, 60, 0}), J);
  EXPECT_GT(dexterity(J, robot.arm.chain().reach(robot.model.joints)).singular_value_min, 0.01);
}

}  // namespace
}  // namespace sinew::kinematics
