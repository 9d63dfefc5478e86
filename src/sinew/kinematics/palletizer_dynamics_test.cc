#include "sinew/kinematics/palletizer_dynamics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/kinematics/palletizer_test_robot.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::kinematics {
namespace {

/// A palletizer with masses that nobody tuned.
struct HeavyPalletizer {
  explicit HeavyPalletizer(test::Random& random)
      : geometry(test::maxarm_geometry()), payload(random.uniform(0, 1)), dynamics(geometry, {}) {
    const auto offset = [&] { return random.uniform(-0.1, 0.1); };
    for (std::size_t i = 0; i < kPalletizerJoints; ++i) {
      const double a = random.uniform(0, 1e-3), b = random.uniform(0, 1e-3);
      const double c = random.uniform(0, 1e-3);
      links.push_back(
          {random.uniform(0, 0.5), {offset(), offset(), offset()}, {b + c, a + c, a + b}});
    }
    dynamics = PalletizerDynamics(geometry, links);
    dynamics.set_payload(payload);
  }

  PalletizerGeometry geometry;
  FixedVector<LinkMass, kMaxJoints> links;
  double payload;
  PalletizerDynamics dynamics;
};

/// Where a link is in base B, from the drawing in docs/kinematics/maxarm.md and elementary
/// rotations only.
Pose<frame::Base, frame::Flange> link_pose(const PalletizerGeometry& g, const JointVector& q,
                                           std::size_t link) {
  const Rotation turn = rotation_z(g.base_front - q[0]);
  if (link == 0) return {turn, {}};
  // The arm's plane: its outward direction is -y of the turned base, so x' = -y, y' = z, z' = -x.
  const Rotation plane = turn * Rotation{{0, -1, 0}, {0, 0, 1}, {-1, 0, 0}};
  const Vec3 shoulder = plane * Vec3{g.shoulder_offset, g.base_height, 0};
  const Rotation upper = plane * rotation_z(kPi - q[1]);
  const Vec3 elbow = shoulder + upper * Vec3{g.upper_arm, 0, 0};
  if (link == 1) return {upper, elbow};
  const Rotation fore = plane * rotation_z(-q[2]);
  return {fore, elbow + fore * Vec3{g.forearm, 0, 0}};
}

JointVector moved(const JointVector& q, const JointVector& qd, double t) {
  JointVector at = q;
  for (std::size_t i = 0; i < q.size(); ++i) at[i] += t * qd[i];
  return at;
}

/// From positions a moment before and after.
double kinetic_energy(const HeavyPalletizer& heavy, const JointVector& q, const JointVector& qd) {
  constexpr double kMoment = 1e-4;  // s, either way
  const JointVector before = moved(q, qd, -kMoment), after = moved(q, qd, kMoment);
  double energy = 0;
  for (std::size_t i = 0; i < kPalletizerJoints; ++i) {
    const auto X0 = link_pose(heavy.geometry, before, i), X1 = link_pose(heavy.geometry, after, i);
    const LinkMass& link = heavy.links[i];
    const Vec3 v = (0.5 / kMoment) * (X1 * link.p_JC - X0 * link.p_JC);
    const Vec3 w = (0.5 / kMoment) * rotation_vector(X0.R.transposed() * X1.R);
    energy += 0.5 * (link.mass * dot(v, v) + link.inertia.x * w.x * w.x +
                     link.inertia.y * w.y * w.y + link.inertia.z * w.z * w.z);
  }
  const Vec3 v =
      (0.5 / kMoment) * (forward(heavy.geometry, after).p - forward(heavy.geometry, before).p);
  return energy + 0.5 * heavy.payload * dot(v, v);
}

double potential_energy(const HeavyPalletizer& heavy, const JointVector& q) {
  double moment = heavy.payload * forward(heavy.geometry, q).p.z;
  for (std::size_t i = 0; i < kPalletizerJoints; ++i) {
    moment += heavy.links[i].mass * (link_pose(heavy.geometry, q, i) * heavy.links[i].p_JC).z;
  }
  return kGravity * moment;
}

JointVector random_joints(test::Random& random) {
  JointVector q;
  for (const Joint& joint : test::maxarm_joints()) {
    q.push_back(random.uniform(joint.lower, joint.upper));
  }
  return q;
}

JointVector random_rates(test::Random& random, double most) {
  return {random.uniform(-most, most), random.uniform(-most, most), random.uniform(-most, most)};
}

/// d/dt dT/dqd - dT/dq + dV/dq, all derivatives by differences.
double lagrangian_torque(const HeavyPalletizer& heavy, const JointVector& q, const JointVector& qd,
                         const JointVector& qdd, std::size_t i) {
  constexpr double kStep = 2e-3;
  const auto momentum = [&](double t) {
    JointVector at = q, more = qd, less = qd;
    for (std::size_t k = 0; k < q.size(); ++k) {
      at[k] += t * qd[k] + 0.5 * t * t * qdd[k];
      more[k] += t * qdd[k] + (k == i ? 1 : 0);
      less[k] += t * qdd[k] - (k == i ? 1 : 0);
    }
    return 0.5 * (kinetic_energy(heavy, at, more) - kinetic_energy(heavy, at, less));
  };
  const auto lagrangian = [&](double offset) {
    JointVector at = q;
    at[i] += offset;
    return kinetic_energy(heavy, at, qd) - potential_energy(heavy, at);
  };
  const auto slope = [&](const auto& f) {
    return (8 * (f(kStep) - f(-kStep)) - (f(2 * kStep) - f(-2 * kStep))) / (12 * kStep);
  };
  return slope(momentum) - slope(lagrangian);
}

TEST(PalletizerMasses, torque_is_what_lagrange_finds_in_the_energies) {
  test::for_random_cases(300, [](test::Random& random) {
    const HeavyPalletizer heavy(random);
    const JointVector q = random_joints(random);
    const JointVector qd = random_rates(random, 2), qdd = random_rates(random, 5);
    const JointVector torque = heavy.dynamics.torque(q, {qd, qdd});
    for (std::size_t i = 0; i < q.size(); ++i) {
      ASSERT_NEAR(torque[i], lagrangian_torque(heavy, q, qd, qdd, i), 1e-6) << "joint " << i;
    }
    ASSERT_NEAR(heavy.dynamics.potential_energy(q), potential_energy(heavy, q), 1e-12);
  });
}

TEST(PalletizerMasses, weight_is_held_as_by_hand) {
  // Rods with their centres half way and a nozzle: lever times weight, level distances only.
  const PalletizerGeometry g = test::maxarm_geometry();
  const std::array<LinkMass, 3> links{LinkMass{0.3, {}, {}},
                                      LinkMass{0.12, {-g.upper_arm / 2, 0, 0}, {}},
                                      LinkMass{0.10, {-g.forearm / 2, 0, 0}, {}}};
  PalletizerDynamics dynamics(g, links);
  dynamics.set_payload(0.08);
  const JointVector still{0, 0, 0};
  for (const double lean : {30.0, 90.0, 130.0}) {
    const JointVector q{1, from_deg(lean), from_deg(25)};
    const JointVector torque = dynamics.torque(q, {still, still});
    EXPECT_NEAR(torque[0], 0, 1e-12);
    EXPECT_NEAR(torque[1], kGravity * g.upper_arm * (0.06 + 0.10 + 0.08) * std::cos(from_deg(lean)),
                1e-12);
    EXPECT_NEAR(torque[2], -kGravity * g.forearm * (0.05 + 0.08) * std::cos(from_deg(25)), 1e-12);
  }
}

TEST(PalletizerMasses, never_allocate) {
  PalletizerDynamics dynamics(test::maxarm_geometry(), {});
  JointVector q{1, 1, 1};
  double sum = 0;
  const test::AllocationCounter allocations;
  for (int i = 0; i < 1000; ++i) {
    q[2] += 1e-3;
    dynamics.set_payload(1e-3 * i);
    sum += dynamics.torque(q, {q, q})[1];
  }
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace sinew::kinematics
