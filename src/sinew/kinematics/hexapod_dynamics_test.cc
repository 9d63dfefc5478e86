#include "sinew/kinematics/hexapod_dynamics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/kinematics/hexapod_test_robot.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::kinematics {
namespace {

PoseBP random_pose(test::Random& random) {
  const auto of = [&](double most) { return random.uniform(-most, most); };
  return {rotation_from_vector({of(0.2), of(0.2), of(0.2)}), {of(0.03), of(0.03), 0.25 + of(0.03)}};
}

PlatformMass random_mass(test::Random& random) {
  const auto of = [&](double most) { return random.uniform(-most, most); };
  return {{random.uniform(0, 3), {of(0.05), of(0.05), of(0.05)}, {4e-3, 5e-3, 6e-3}},
          random.uniform(0, 5)};
}

/// Poses a moment apart on a screw motion through X_BP: velocity v of P's origin, rotation w, in B.
PoseBP after(const PoseBP& X_BP, const Vec3& v, const Vec3& w, double t) {
  return {rotation_from_vector(t * w) * X_BP.R, X_BP.p + t * v};
}

TEST(LegForces, work_of_the_legs_lifts_the_platform) {
  // Virtual work with leg lengths and heights only: no Jacobian, no wrench.
  const Hexapod hexapod(test::default_hexapod_geometry());
  test::for_random_cases(1000, [&](test::Random& random) {
    const PoseBP X_BP = random_pose(random);
    const PlatformMass mass = random_mass(random);
    const auto forces = leg_forces(hexapod, X_BP, mass, JointVector{0, 0, 0, 0, 0, 0});
    ASSERT_TRUE(forces.has_value());
    const auto of = [&] { return random.uniform(-1, 1); };
    const Vec3 v{of(), of(), of()}, w{10 * of(), 10 * of(), 10 * of()};
    constexpr double kStep = 1e-6;
    const PoseBP X0 = after(X_BP, v, w, -kStep);
    const PoseBP X1 = after(X_BP, v, w, kStep);
    const JointVector legs0 = hexapod.inverse(X0), legs1 = hexapod.inverse(X1);
    double work = 0;
    for (std::size_t i = 0; i < kLegs; ++i) work += (*forces)[i] * (legs1[i] - legs0[i]);
    const double lifted =
        kGravity *
        (mass.platform.mass * ((X1 * mass.platform.p_JC).z - (X0 * mass.platform.p_JC).z) +
         mass.payload * (X1.p.z - X0.p.z));
    EXPECT_NEAR(work / (2 * kStep), lifted / (2 * kStep), 1e-6);
  });
}

TEST(LegForces, level_platform_spreads_its_weight_evenly) {
  const HexapodGeometry geometry = test::default_hexapod_geometry();
  const Hexapod hexapod(geometry);
  const auto forces =
      leg_forces(hexapod, geometry.X_BP_home, {{1.2, {}, {}}, 0.3}, JointVector{0, 0, 0, 0, 0, 0});
  ASSERT_TRUE(forces.has_value());
  const double length = hexapod.inverse(geometry.X_BP_home)[0];
  for (const double force : *forces) {
    EXPECT_NEAR(force, 1.5 * kGravity / 6 * length / 0.25, 1e-9);
  }
}

TEST(LegForces, acceleration_adds_what_newton_and_euler_say) {
  const Hexapod hexapod(test::default_hexapod_geometry());
  test::for_random_cases(300, [&](test::Random& random) {
    const PoseBP X_BP = random_pose(random);
    const PlatformMass mass = random_mass(random);
    const auto of = [&](double most) { return random.uniform(-most, most); };
    const Vec3 a{of(2), of(2), of(2)}, alpha{of(9), of(9), of(9)};
    // From rest, lengths grow by t^2/2 of their acceleration.
    constexpr double kTime = 1e-3;
    const PoseBP X1 = after(X_BP, (kTime / 2) * a, (kTime / 2) * alpha, kTime);
    const PoseBP X0 = after(X_BP, (-kTime / 2) * a, (-kTime / 2) * alpha, kTime);
    const JointVector legs = hexapod.inverse(X1), back = hexapod.inverse(X0);
    JointVector qdd;
    for (std::size_t i = 0; i < kLegs; ++i) {
      qdd.push_back((legs[i] - back[i]) / (kTime * kTime));
    }
    const auto forces = leg_forces(hexapod, X_BP, mass, qdd, 0);
    ASSERT_TRUE(forces.has_value());
    // Sum of the legs' forces and moments on the platform, leg by leg.
    const HexapodGeometry geometry = test::default_hexapod_geometry();
    Vec3 force, moment;
    for (std::size_t i = 0; i < kLegs; ++i) {
      const Vec3 arm = X_BP.R * geometry.p_PA[i];
      const Vec3 f = (*forces)[i] * normalized(X_BP.p + arm - geometry.p_BA[i]);
      force = force + f;
      moment = moment + cross(arm, f);
    }
    const Vec3 r = X_BP.R * mass.platform.p_JC;
    const Vec3 f_C = mass.platform.mass * (a + cross(alpha, r));
    const Vec3 alpha_P = transposed_times(X_BP.R, alpha);
    const Vec3& I = mass.platform.inertia;
    const Vec3 spin = X_BP.R * Vec3{I.x * alpha_P.x, I.y * alpha_P.y, I.z * alpha_P.z};
    EXPECT_NEAR(norm(force - (f_C + mass.payload * a)), 0, 1e-5);
    EXPECT_NEAR(norm(moment - (cross(r, f_C) + spin)), 0, 1e-5);
  });
}

TEST(LegForces, singular_platform_is_refused) {
  // Base and platform in one plane: no leg pushes up.
  const Hexapod hexapod(test::default_hexapod_geometry());
  const auto forces =
      leg_forces(hexapod, {{}, {0, 0, 0}}, {{1, {}, {}}, 0}, JointVector{0, 0, 0, 0, 0, 0});
  ASSERT_FALSE(forces.has_value());
  EXPECT_EQ(forces.error().code, ErrorCode::kSingular);
}

TEST(LegForces, never_allocate) {
  const Hexapod hexapod(test::default_hexapod_geometry());
  const JointVector still{0, 0, 0, 0, 0, 0};
  PoseBP X_BP{{}, {0, 0, 0.25}};
  double sum = 0;
  const test::AllocationCounter allocations;
  for (int i = 0; i < 1000; ++i) {
    X_BP.p.x += 1e-5;
    sum += leg_forces(hexapod, X_BP, {{1, {}, {}}, 0}, still)->back();
  }
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_GT(sum, 0);
}

}  // namespace
}  // namespace sinew::kinematics
