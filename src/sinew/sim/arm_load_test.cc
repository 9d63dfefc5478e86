#include "sinew/sim/arm_load.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/allocation_guard.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::sim {
namespace {

const SerialGeometry& geometry() {
  return std::get<SerialGeometry>(test::robot("robot-arm-2").geometry);
}

const Dynamics& dynamics() {
  return test::robot("robot-arm-2").dynamics;
}

JointVector random_joints(test::Random& random) {
  JointVector q;
  for (const Joint& joint : test::robot("robot-arm-2").joints) {
    q.push_back(random.uniform(joint.lower, joint.upper));
  }
  return q;
}

double energy_at(ArmLoad& load, JointVector q, std::size_t joint, double offset) {
  q[joint] += offset;
  load.update(q);
  return load.potential_energy();
}

TEST(ArmLoad, torque_is_the_slope_of_the_potential_energy) {
  ArmLoad load(geometry(), dynamics());
  test::for_random_cases(2'000, [&](test::Random& random) {
    load.set_payload(random.uniform(0, 3));
    const JointVector q = random_joints(random);
    for (std::size_t i = 0; i < q.size(); ++i) {
      constexpr double kStep = 1e-5;  // rad
      const double slope =
          (energy_at(load, q, i, kStep) - energy_at(load, q, i, -kStep)) / (2 * kStep);
      load.update(q);
      EXPECT_NEAR(load.torque(i), -slope, 1e-7) << "joint " << i;
    }
  });
}

/// Kinetic energy while joint `moving` turns with 1 rad/s, from positions a moment apart.
double kinetic_energy(const Dynamics& dynamics, double payload, const JointVector& q,
                      std::size_t moving) {
  const kinematics::SerialChain chain(geometry());
  constexpr double kStep = 1e-5;
  double energy = 0;
  kinematics::PoseBF before, after;
  for (std::size_t k = 0; k < q.size(); ++k) {
    const double turn = k == moving ? kStep : 0;
    before = relabel<frame::Base, frame::Base>(before) * chain.link(k, q[k] - turn);
    after = relabel<frame::Base, frame::Base>(after) * chain.link(k, q[k] + turn);
    const LinkMass& link = dynamics.links[k];
    const Vec3 v = (0.5 / kStep) * (after * link.p_JC - before * link.p_JC);
    const Vec3 w = (0.5 / kStep) * rotation_vector(before.R.transposed() * after.R);
    energy += 0.5 * (link.mass * dot(v, v) + link.inertia.x * w.x * w.x +
                     link.inertia.y * w.y * w.y + link.inertia.z * w.z * w.z);
  }
  const Vec3 v = (0.5 / kStep) * (after * geometry().X_FT.p - before * geometry().X_FT.p);
  return energy + 0.5 * payload * dot(v, v);
}

TEST(ArmLoad, inertia_is_twice_the_kinetic_energy_of_one_turning_joint) {
  ArmLoad load(geometry(), dynamics());
  test::for_random_cases(500, [&](test::Random& random) {
    const double payload = random.uniform(0, 3);
    load.set_payload(payload);
    const JointVector q = random_joints(random);
    load.update(q);
    for (std::size_t i = 0; i < q.size(); ++i) {
      EXPECT_NEAR(load.inertia(i), 2 * kinetic_energy(dynamics(), payload, q, i), 1e-6);
    }
  });
}

TEST(ArmLoad, joint_that_swings_freely_keeps_its_energy) {
  ArmLoad load(geometry(), dynamics());
  load.set_payload(1);
  test::for_random_cases(20, [&](test::Random& random) {
    const auto joint = static_cast<std::size_t>(random.integer(1, 5));
    JointVector q = random_joints(random);
    load.update(q);
    const double start = load.potential_energy();
    double qd = 0, kinetic_max = 0;
    constexpr double kStep = 1e-4;  // s; leapfrog
    for (int i = 0; i < 20'000; ++i) {
      qd += 0.5 * kStep * load.torque(joint) / load.inertia(joint);
      q[joint] += kStep * qd;
      load.update(q);
      qd += 0.5 * kStep * load.torque(joint) / load.inertia(joint);
      const double kinetic = 0.5 * load.inertia(joint) * qd * qd;
      kinetic_max = std::max(kinetic_max, kinetic);
      ASSERT_NEAR(load.potential_energy() + kinetic, start, 1e-4 * (kinetic_max + 0.01));
    }
  });
}

TEST(ArmLoad, stretched_arm_weighs_on_its_shoulder_by_hand_calculation) {
  // The upper arm lies along x, and so does the forearm; the elbow's 45 mm point up.
  ArmLoad load(geometry(), dynamics());
  const JointVector q{0, from_deg(-90), from_deg(90), 0, 0, 0};
  load.update(q);
  const kinematics::SerialChain chain(geometry());
  ASSERT_NEAR(chain.forward(q).p.x, 0.315 + 0.265 + 0.100, 1e-9);
  const double moment = 3.0 * (0.315 - 0.14) + 1.7 * (0.315 + 0.03) + 1.3 * (0.315 + 0.265 - 0.14) +
                        0.5 * (0.315 + 0.265 + 0.03) +
                        0.15 * (0.315 + 0.265 + 0.100 - 0.03);  // kg m
  EXPECT_NEAR(std::abs(load.torque(1)), moment * 9.80665, 1e-9);
}

TEST(ArmLoad, payload_pulls_at_its_lever) {
  ArmLoad load(geometry(), Dynamics{});
  load.set_payload(2);
  const JointVector q{0, 0, 0, 0, 0, 0};  // flange 365 mm in front of the shoulder's axis
  load.update(q);
  EXPECT_NEAR(std::abs(load.torque(1)), 2 * 9.80665 * 0.365, 1e-9);
  EXPECT_NEAR(load.torque(0), 0, 1e-12);
  EXPECT_NEAR(load.inertia(0), 2 * 0.365 * 0.365, 1e-9);
}

TEST(ArmLoad, torque_table_of_the_author_is_reproduced) {
  constexpr std::array kTable{15.0, 45.0, 30.0, 15.0, 9.5, 4.8};  // Nm
  for (std::size_t i = 0; i < kTable.size(); ++i) {
    const StepperDrive& drive = dynamics().drives[i];
    EXPECT_NEAR(drive.holding_torque * drive.motors * drive.gear_ratio * drive.gear_efficiency,
                kTable[i], 0.05);
  }
}

TEST(ArmLoad, never_allocates) {
  ArmLoad load(geometry(), dynamics());
  JointVector q{0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  const test::AllocationCounter allocations;
  for (int i = 0; i < 1000; ++i) {
    q[1] += 1e-3;
    load.update(q);
  }
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::sim
