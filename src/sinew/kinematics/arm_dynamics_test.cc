#include "sinew/kinematics/arm_dynamics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>

#include "sinew/kinematics/serial_test_robot.h"
#include "support/allocation_guard.h"

namespace sinew::kinematics {
namespace {

JointVector random_vector(test::Random& random, std::size_t n, double most) {
  JointVector v;
  for (std::size_t i = 0; i < n; ++i) v.push_back(random.uniform(-most, most));
  return v;
}

/// A tensor that a real body can have: each moment at most the sum of the others.
Vec3 random_inertia(test::Random& random) {
  const double a = random.uniform(0, 0.02), b = random.uniform(0, 0.02),
               c = random.uniform(0, 0.02);
  return {b + c, a + c, a + b};
}

FixedVector<LinkMass, kMaxJoints> random_links(test::Random& random, std::size_t n) {
  FixedVector<LinkMass, kMaxJoints> links;
  for (std::size_t i = 0; i < n; ++i) {
    links.push_back(
        {random.uniform(0, 4),
         {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)},
         random_inertia(random)});
  }
  return links;
}

PayloadMass random_payload(test::Random& random) {
  return {random.uniform(0, 3),
          {random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(0, 0.2)}};
}

/// A robot of the product with masses that nobody tuned.
struct HeavyRobot {
  HeavyRobot(const char* id, test::Random& random)
      : robot(id),
        links(random_links(random, robot.geometry.rows.size())),
        payload(random_payload(random)),
        arm(robot.geometry, links) {
    arm.set_payload(payload);
  }
  std::size_t size() const { return links.size(); }

  SerialRobot robot;
  FixedVector<LinkMass, kMaxJoints> links;
  PayloadMass payload;
  ArmDynamics arm;
};

class ArmMasses : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(AllSerialRobots, ArmMasses, testing::ValuesIn(kSerialRobots), test_name);

TEST_P(ArmMasses, torque_agrees_with_kdl) {
  test::for_random_cases(300, [](test::Random& random) {
    const HeavyRobot heavy(GetParam(), random);
    const auto n = static_cast<unsigned>(heavy.size());
    KDL::Chain chain;
    for (unsigned i = 0; i < n; ++i) {
      const DhRow& row = heavy.robot.geometry.rows[i];
      const LinkMass& link = heavy.links[i];
      const KDL::Vector centre(link.p_JC.x, link.p_JC.y, link.p_JC.z);
      KDL::RigidBodyInertia body(
          link.mass, centre,
          KDL::RotationalInertia(link.inertia.x, link.inertia.y, link.inertia.z));
      if (i + 1 == n) {
        const Vec3& p = heavy.payload.p_FL;
        body = body + KDL::RigidBodyInertia(heavy.payload.mass, {p.x, p.y, p.z});
      }
      chain.addSegment(SerialRobot::kdl_segment(row, body));
    }
    KDL::ChainIdSolver_RNE solver(chain, {0, 0, -kGravity});
    const JointVector q = heavy.robot.random_joints(random);
    const JointVector qd = random_vector(random, n, 3), qdd = random_vector(random, n, 10);
    KDL::JntArray q_kdl(n), qd_kdl(n), qdd_kdl(n), torque_kdl(n);
    for (unsigned i = 0; i < n; ++i) {
      q_kdl(i) = q[i];
      qd_kdl(i) = qd[i];
      qdd_kdl(i) = qdd[i];
    }
    ASSERT_EQ(solver.CartToJnt(q_kdl, qd_kdl, qdd_kdl, KDL::Wrenches(n), torque_kdl), 0);
    const JointVector torque = heavy.arm.at(q).torque({qd, qdd});
    for (unsigned i = 0; i < n; ++i) ASSERT_NEAR(torque[i], torque_kdl(i), 1e-9) << "joint " << i;
  });
}

/// Kinetic energy from where forward kinematics puts every body a moment before and after: no
/// Jacobian, no velocity formula.
double kinetic_energy_by_positions(const HeavyRobot& heavy, const JointVector& q,
                                   const JointVector& qd) {
  constexpr double kMoment = 1e-5;  // s, either way
  double energy = 0;
  PoseBF before, after;
  const SerialChain& chain = heavy.arm.chain();
  const auto velocity = [&](const Vec3& p) { return (0.5 / kMoment) * (after * p - before * p); };
  for (std::size_t k = 0; k < q.size(); ++k) {
    before = relabel<frame::Base, frame::Base>(before) * chain.link(k, q[k] - kMoment * qd[k]);
    after = relabel<frame::Base, frame::Base>(after) * chain.link(k, q[k] + kMoment * qd[k]);
    const LinkMass& link = heavy.links[k];
    const Vec3 v = velocity(link.p_JC);
    const Vec3 w = (0.5 / kMoment) * rotation_vector(before.R.transposed() * after.R);
    energy += 0.5 * (link.mass * dot(v, v) + link.inertia.x * w.x * w.x +
                     link.inertia.y * w.y * w.y + link.inertia.z * w.z * w.z);
  }
  const Vec3 v = velocity(heavy.payload.p_FL);
  return energy + 0.5 * heavy.payload.mass * dot(v, v);
}

TEST_P(ArmMasses, kinetic_energy_is_that_of_moving_bodies) {
  test::for_random_cases(300, [](test::Random& random) {
    const HeavyRobot heavy(GetParam(), random);
    const JointVector q = heavy.robot.random_joints(random);
    const JointVector qd = random_vector(random, q.size(), 2);
    const double expected = kinetic_energy_by_positions(heavy, q, qd);
    EXPECT_NEAR(heavy.arm.at(q).kinetic_energy(qd), expected, 1e-6 * (1 + expected));
  });
}

/// d/dt dT/dqd - dT/dq + dV/dq with derivatives by differences of energies only.
double lagrangian_torque(const HeavyRobot& heavy, const JointVector& q, const JointVector& qd,
                         const JointVector& qdd, std::size_t i) {
  constexpr double kStep = 1e-3;
  const auto kinetic = [&](const JointVector& at, const JointVector& rate) {
    return heavy.arm.at(at).kinetic_energy(rate);
  };
  // T is quadratic in qd: a central difference over it is exact for any step.
  const auto momentum = [&](double t) {
    JointVector at = q, rate = qd;
    for (std::size_t k = 0; k < q.size(); ++k) {
      at[k] += t * qd[k] + 0.5 * t * t * qdd[k];
      rate[k] += t * qdd[k];
    }
    JointVector more = rate, less = rate;
    more[i] += 1;
    less[i] -= 1;
    return 0.5 * (kinetic(at, more) - kinetic(at, less));
  };
  const auto lagrangian = [&](double offset) {
    JointVector at = q;
    at[i] += offset;
    return kinetic(at, qd) - heavy.arm.at(at).potential_energy();
  };
  // Fourth order, so that a step well above rounding is exact enough.
  const auto slope = [&](const auto& f) {
    return (8 * (f(kStep) - f(-kStep)) - (f(2 * kStep) - f(-2 * kStep))) / (12 * kStep);
  };
  return slope(momentum) - slope(lagrangian);
}

TEST_P(ArmMasses, torque_is_what_lagrange_finds_in_the_energies) {
  test::for_random_cases(200, [](test::Random& random) {
    const HeavyRobot heavy(GetParam(), random);
    const JointVector q = heavy.robot.random_joints(random);
    const JointVector qd = random_vector(random, q.size(), 2);
    const JointVector qdd = random_vector(random, q.size(), 5);
    const JointVector torque = heavy.arm.at(q).torque({qd, qdd});
    for (std::size_t i = 0; i < q.size(); ++i) {
      ASSERT_NEAR(torque[i], lagrangian_torque(heavy, q, qd, qdd, i), 1e-7) << "joint " << i;
    }
  });
}

TEST_P(ArmMasses, power_of_the_joints_is_the_rise_of_the_energy) {
  test::for_random_cases(300, [](test::Random& random) {
    const HeavyRobot heavy(GetParam(), random);
    const std::size_t n = heavy.size();
    // Joints that swing as sines, each with its own frequency.
    const JointVector centre = heavy.robot.random_joints(random);
    const JointVector swing = random_vector(random, n, 0.8), rate = random_vector(random, n, 4);
    const auto position = [&](double t) {
      JointVector q = centre;
      for (std::size_t i = 0; i < n; ++i) q[i] += swing[i] * std::sin(rate[i] * t);
      return q;
    };
    const auto velocity = [&](double t) {
      JointVector qd = swing;
      for (std::size_t i = 0; i < n; ++i) qd[i] *= rate[i] * std::cos(rate[i] * t);
      return qd;
    };
    const auto energy = [&](double t) {
      const PlacedMasses placed = heavy.arm.at(position(t));
      return placed.potential_energy() + placed.kinetic_energy(velocity(t));
    };
    // Work from 0 to 1 s by Simpson's rule.
    constexpr int kPieces = 400;
    double work = 0;
    for (int k = 0; k <= kPieces; ++k) {
      const double t = 1.0 * k / kPieces;
      JointVector qdd = swing;
      for (std::size_t i = 0; i < n; ++i) qdd[i] *= -rate[i] * rate[i] * std::sin(rate[i] * t);
      const JointVector qd = velocity(t);
      const JointVector torque = heavy.arm.at(position(t)).torque({qd, qdd});
      double power = 0;
      for (std::size_t i = 0; i < n; ++i) power += torque[i] * qd[i];
      const bool end = k == 0 || k == kPieces;
      work += power * (end ? 1 : k % 2 == 1 ? 4 : 2) / (3.0 * kPieces);
    }
    EXPECT_NEAR(work, energy(1) - energy(0), 1e-6 * (1 + std::abs(work)));
  });
}

TEST_P(ArmMasses, mass_matrix_is_symmetric_positive_and_what_unit_accelerations_ask_for) {
  test::for_random_cases(300, [](test::Random& random) {
    const HeavyRobot heavy(GetParam(), random);
    const std::size_t n = heavy.size();
    const PlacedMasses placed = heavy.arm.at(heavy.robot.random_joints(random));
    JointVector still;
    still.resize(n);
    for (std::size_t j = 0; j < n; ++j) {
      JointVector unit = still;
      unit[j] = 1;
      const JointVector column = placed.torque({still, unit}, 0);
      for (std::size_t i = 0; i < n; ++i) {
        ASSERT_NEAR(placed.inertia(i, j), column[i], 1e-12);
        ASSERT_NEAR(placed.inertia(i, j), placed.inertia(j, i), 1e-12);
      }
    }
    const JointVector qd = random_vector(random, n, 1);
    double twice = 0;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) twice += qd[i] * placed.inertia(i, j) * qd[j];
    }
    ASSERT_GT(twice, 0);
    ASSERT_NEAR(twice, 2 * placed.kinetic_energy(qd), 1e-12 * (1 + twice));
  });
}

TEST_P(ArmMasses, weight_is_the_torque_at_rest_and_the_slope_of_the_potential_energy) {
  test::for_random_cases(300, [](test::Random& random) {
    const HeavyRobot heavy(GetParam(), random);
    const JointVector q = heavy.robot.random_joints(random);
    JointVector still;
    still.resize(q.size());
    const PlacedMasses placed = heavy.arm.at(q);
    const JointVector torque = placed.torque({still, still});
    for (std::size_t i = 0; i < q.size(); ++i) {
      ASSERT_NEAR(placed.weight(i), torque[i], 1e-11);
      constexpr double kStep = 1e-5;
      JointVector more = q, less = q;
      more[i] += kStep;
      less[i] -= kStep;
      const double slope =
          (heavy.arm.at(more).potential_energy() - heavy.arm.at(less).potential_energy()) /
          (2 * kStep);
      ASSERT_NEAR(placed.weight(i), slope, 1e-7);
    }
  });
}

SerialGeometry level_arm(std::initializer_list<double> lengths) {
  // Turned by 90 degrees about x at its root, so that joints turn in a vertical plane.
  SerialGeometry geometry;
  geometry.rows.push_back({0, 0, kPi / 2, 0});
  for (const double length : lengths) geometry.rows.push_back({0, length, 0, 0});
  return geometry;
}

TEST(ArmMassesByHand, pendulum_needs_m_g_l_cos_q_and_m_l_squared) {
  const SerialGeometry geometry = level_arm({0.5});
  ArmDynamics arm(geometry, {});
  arm.set_payload({2, {}});
  for (const double q : {-2.0, -0.3, 0.0, 0.7, 1.5}) {
    const JointVector torque =
        arm.at(JointVector{0.4, q}).torque({JointVector{0, 1.3}, JointVector{0, 2.5}});
    EXPECT_NEAR(torque[1], 2 * kGravity * 0.5 * std::cos(q) + 2 * 0.25 * 2.5, 1e-12);
    EXPECT_NEAR(torque[0], 0, 1e-12);
  }
}

TEST(ArmMassesByHand, two_links_agree_with_the_textbook) {
  // Point masses at the ends; J. Craig, Introduction to Robotics, 3rd ed., eq. (6.58).
  constexpr double l1 = 0.4, l2 = 0.3, m1 = 1.5, m2 = 0.8, g = kGravity;
  const SerialGeometry geometry = level_arm({l1, l2});
  ArmDynamics arm(geometry, std::array<LinkMass, 3>{LinkMass{}, LinkMass{m1, {}, {}}, LinkMass{}});
  arm.set_payload({m2, {}});
  test::for_random_cases(100, [&](test::Random& random) {
    const double q1 = random.uniform(-3, 3), q2 = random.uniform(-3, 3);
    const double v1 = random.uniform(-3, 3), v2 = random.uniform(-3, 3);
    const double a1 = random.uniform(-9, 9), a2 = random.uniform(-9, 9);
    const double c2 = std::cos(q2), s2 = std::sin(q2);
    const double c1 = std::cos(q1), c12 = std::cos(q1 + q2);
    const double torque1 = m2 * l2 * l2 * (a1 + a2) + m2 * l1 * l2 * c2 * (2 * a1 + a2) +
                           (m1 + m2) * l1 * l1 * a1 - m2 * l1 * l2 * s2 * v2 * v2 -
                           2 * m2 * l1 * l2 * s2 * v1 * v2 + m2 * l2 * g * c12 +
                           (m1 + m2) * l1 * g * c1;
    const double torque2 = m2 * l1 * l2 * c2 * a1 + m2 * l1 * l2 * s2 * v1 * v1 +
                           m2 * l2 * g * c12 + m2 * l2 * l2 * (a1 + a2);
    const JointVector torque =
        arm.at(JointVector{0, q1, q2}).torque({JointVector{0, v1, v2}, JointVector{0, a1, a2}});
    EXPECT_NEAR(torque[1], torque1, 1e-10);
    EXPECT_NEAR(torque[2], torque2, 1e-10);
  });
}

TEST(ArmMassesByHand, spinning_base_throws_a_level_pendulum_outwards) {
  // At rate w the joint holds m l^2 w^2 sin q cos q against the pull to the level, and the base
  // feels 2 m l^2 w q' sin q cos q while the pendulum moves.
  const SerialGeometry geometry = level_arm({0.5});
  ArmDynamics arm(geometry, {});
  arm.set_payload({2, {}});
  const double q = 0.6, w = 3, qd = -1.1;
  const JointVector torque =
      arm.at(JointVector{1, q}).torque({JointVector{w, qd}, JointVector{0, 0}}, 0);
  EXPECT_NEAR(torque[1], 2 * 0.25 * w * w * std::sin(q) * std::cos(q), 1e-12);
  EXPECT_NEAR(torque[0], -2 * 2 * 0.25 * w * qd * std::sin(q) * std::cos(q), 1e-12);
}

TEST(ArmMassesByHand, never_allocate) {
  const RobotModel& model = test::robot("robot-arm-2");
  ArmDynamics arm(std::get<SerialGeometry>(model.geometry), model.dynamics.links);
  JointVector q{0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  const JointVector qd{1, 1, 1, 1, 1, 1};
  double sum = 0;
  const test::AllocationCounter allocations;
  for (int i = 0; i < 1000; ++i) {
    q[1] += 1e-3;
    arm.set_payload(1e-3 * i);
    const PlacedMasses placed = arm.at(q);
    sum += placed.torque({qd, qd})[1] + placed.inertia(1, 2) + placed.kinetic_energy(qd);
  }
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace sinew::kinematics
