#include "sinew/kinematics/hexapod.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/hexapod_test_robot.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::kinematics {
namespace {

const HexapodGeometry kGeometry = test::default_hexapod_geometry();
const std::array<Joint, kLegs> kLegJoints = test::default_hexapod_legs();
const Hexapod kHexapod(kGeometry);

PoseBP yawed(double yaw_deg) {
  return {rotation_z(from_deg(yaw_deg)), {0, 0, 0.25}};
}

/// Poses far beyond what the machine can take.
PoseBP wide_pose(test::Random& random) {
  const Vec3 w{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
  return {rotation_from_vector(w),
          {random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), random.uniform(0.1, 0.4)}};
}

bool has(const HexapodViolations& violations, ErrorCode code, int leg) {
  return std::any_of(violations.begin(), violations.end(), [&](const Error& violation) {
    return violation.code == code && violation.index == leg;
  });
}

TEST(Hexapod, every_leg_of_the_default_geometry_at_250_mm_is_268_36_mm) {
  const JointVector legs = kHexapod.inverse(kGeometry.X_BP_home);
  ASSERT_EQ(legs.size(), kLegs);
  for (const double leg : legs) EXPECT_NEAR(to_mm(leg), 268.36, 0.005);
  EXPECT_TRUE(kHexapod.check(kGeometry.X_BP_home, kLegJoints).empty());
}

TEST(Hexapod, inverse_is_the_distance_between_the_anchors) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const PoseBP X_BP = wide_pose(random);
    const JointVector legs = kHexapod.inverse(X_BP);
    for (std::size_t i = 0; i < kLegs; ++i) {
      EXPECT_NEAR(legs[i], norm(X_BP * kGeometry.p_PA[i] - kGeometry.p_BA[i]), 1e-15);
    }
  });
}

TEST(Hexapod, moving_both_frames_with_their_anchors_changes_no_leg) {
  test::for_random_cases(10'000, [](test::Random& random) {
    const PoseBP X_BP = wide_pose(random);
    const PoseBP X_moved = wide_pose(random);
    const Pose<frame::World, frame::Base> X_WB = relabel<frame::World, frame::Base>(X_moved);
    HexapodGeometry moved = kGeometry;
    for (Vec3& anchor : moved.p_BA) anchor = X_WB * anchor;
    const JointVector legs =
        Hexapod(moved).inverse(relabel<frame::Base, frame::Platform>(X_WB * X_BP));
    for (std::size_t i = 0; i < kLegs; ++i) EXPECT_NEAR(legs[i], kHexapod.inverse(X_BP)[i], 1e-15);
  });
}

TEST(Hexapod, jacobian_is_the_slope_of_inverse) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const PoseBP X_BP = wide_pose(random);
    const HexapodJacobian J = kHexapod.jacobian(X_BP);
    const JointVector legs = kHexapod.inverse(X_BP);
    constexpr double kStep = 1e-5;
    for (std::size_t k = 0; k < kTwistSize; ++k) {
      const auto moved = [&](double step) {
        TwistArray twist{};
        twist[k] = step;
        return PoseBP{rotation_from_vector({twist[3], twist[4], twist[5]}) * X_BP.R,
                      X_BP.p + Vec3{twist[0], twist[1], twist[2]}};
      };
      const JointVector ahead = kHexapod.inverse(moved(kStep));
      const JointVector behind = kHexapod.inverse(moved(-kStep));
      for (std::size_t i = 0; i < kLegs; ++i) {
        // The third derivative of a leg grows with the inverse square of its length.
        const double tolerance = 1e-10 * (1 + 1 / (legs[i] * legs[i]));
        EXPECT_NEAR((ahead[i] - behind[i]) / (2 * kStep), J[i][k], tolerance) << i << " " << k;
      }
    }
  });
}

TEST(Hexapod, condition_number_grows_towards_a_yaw_of_90_deg) {
  struct Row {
    double yaw_deg, condition, tolerance;
  };
  // Printed to the digits that the tolerances stand for.
  constexpr std::array kRows{Row{0, 3.7, 0.05}, Row{30, 3.9, 0.06}, Row{60, 6.0, 0.05},
                             Row{80, 18, 0.5}, Row{89, 184, 0.5}};
  for (const Row& row : kRows) {
    for (const double sign : {1.0, -1.0}) {
      EXPECT_NEAR(kHexapod.dexterity(yawed(sign * row.yaw_deg)).condition, row.condition,
                  row.tolerance);
    }
  }
}

TEST(Hexapod, yaw_of_90_deg_is_singular) {
  for (const double yaw_deg : {90.0, -90.0}) {
    const HexapodDexterity dexterity = kHexapod.dexterity(yawed(yaw_deg));
    EXPECT_EQ(dexterity.condition, std::numeric_limits<double>::infinity());
    EXPECT_LT(dexterity.singular_value_min, 1e-15);
    EXPECT_TRUE(has(kHexapod.check(yawed(yaw_deg), kLegJoints), ErrorCode::kConditionNumber, -1));
  }
}

TEST(Hexapod, anchors_paired_at_the_same_angles_are_singular_at_every_yaw) {
  HexapodGeometry geometry = kGeometry;
  for (std::size_t i = 0; i < kLegs; ++i) geometry.p_PA[i] = (2.0 / 3) * geometry.p_BA[i];
  for (int yaw_deg = -180; yaw_deg <= 180; yaw_deg += 5) {
    EXPECT_GT(Hexapod(geometry).dexterity(yawed(yaw_deg)).condition, 1e12) << yaw_deg;
  }
}

TEST(Hexapod, condition_number_has_no_unit) {
  HexapodGeometry in_mm = kGeometry;
  for (Vec3& anchor : in_mm.p_BA) anchor = 1e3 * anchor;
  for (Vec3& anchor : in_mm.p_PA) anchor = 1e3 * anchor;
  in_mm.platform_radius *= 1e3;
  test::for_random_cases(10'000, [&](test::Random& random) {
    PoseBP X_BP = wide_pose(random);
    const double condition = kHexapod.dexterity(X_BP).condition;
    X_BP.p = 1e3 * X_BP.p;
    if (condition > 1e3) return random.discard();
    EXPECT_NEAR(Hexapod(in_mm).dexterity(X_BP).condition, condition, 1e-9 * condition);
  });
}

TEST(Hexapod, leg_limits_are_inclusive_and_name_the_leg) {
  PoseBP X_BP = kGeometry.X_BP_home;
  const double sideways = std::sqrt(std::pow(kHexapod.inverse(X_BP)[0], 2) - 0.25 * 0.25);
  for (const double length : {kLegJoints[0].lower, kLegJoints[0].upper}) {
    const double outward = length > 0.25 ? 1 : -1;
    X_BP.p.z = std::sqrt(length * length - sideways * sideways);
    EXPECT_TRUE(kHexapod.check(X_BP, kLegJoints).empty());
    X_BP.p.z += outward * 1e-6;
    const HexapodViolations violations = kHexapod.check(X_BP, kLegJoints);
    ASSERT_EQ(violations.size(), kLegs);
    for (std::size_t i = 0; i < kLegs; ++i) {
      EXPECT_EQ(violations[i].code, ErrorCode::kLegLength);
      EXPECT_EQ(violations[i].index, static_cast<int>(i));
      EXPECT_EQ(violations[i].limit, length);
      EXPECT_NEAR(violations[i].measured, kHexapod.inverse(X_BP)[i], 1e-15);
    }
  }
}

/// What check() should find, with an angle for every comparison.
std::vector<Error> expected_leg_violations(const PoseBP& X_BP) {
  std::vector<Error> expected;
  for (std::size_t i = 0; i < kLegs; ++i) {
    const auto leg = static_cast<std::int8_t>(i);
    const Vec3 leg_B = X_BP * kGeometry.p_PA[i] - kGeometry.p_BA[i];
    const double length = norm(leg_B);
    if (length < 0.195) expected.push_back({ErrorCode::kLegLength, leg, length, 0.195});
    if (length > 0.345) expected.push_back({ErrorCode::kLegLength, leg, length, 0.345});
    const double cardan = std::acos(leg_B.z / length);
    if (cardan > kPi / 4) expected.push_back({ErrorCode::kCardanAngle, leg, cardan, kPi / 4});
    const double from_skewer = std::acos(dot(leg_B, X_BP.R * kGeometry.skewer_axis_P[i]) / length);
    const double ball = std::abs(kPi / 2 - from_skewer);
    if (ball > from_deg(35)) {
      expected.push_back({ErrorCode::kBallAngle, leg, ball, from_deg(35)});
    }
  }
  return expected;
}

TEST(Hexapod, check_finds_each_leg_that_is_too_long_too_bent_or_too_tilted) {
  std::array<int, 3> found{};
  test::for_random_cases(100'000, [&](test::Random& random) {
    const PoseBP X_BP = wide_pose(random);
    const std::vector<Error> expected = expected_leg_violations(X_BP);
    const HexapodViolations violations = kHexapod.check(X_BP, kLegJoints);
    const bool ill = kHexapod.dexterity(X_BP).condition > 20;
    ASSERT_EQ(violations.size(), expected.size() + (ill ? 1 : 0));
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(violations[i].code, expected[i].code);
      EXPECT_EQ(violations[i].index, expected[i].index);
      EXPECT_NEAR(violations[i].measured, expected[i].measured, 1e-9);
      EXPECT_NEAR(violations[i].limit, expected[i].limit, 1e-15);
      // The three codes stand one after the other.
      found[static_cast<std::size_t>(expected[i].code) -
            static_cast<std::size_t>(ErrorCode::kLegLength)]++;
    }
    if (ill) {
      EXPECT_EQ(violations.back().code, ErrorCode::kConditionNumber);
    }
  });
  for (const int count : found) EXPECT_GT(count, 10'000);
}

TEST(Hexapod, pose_that_is_not_a_number_is_never_allowed) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(kHexapod.check({Rotation{}, {0, bad, 0.25}}, kLegJoints).empty());
    PoseBP X_BP = kGeometry.X_BP_home;
    X_BP.R.y.z = bad;
    EXPECT_FALSE(kHexapod.check(X_BP, kLegJoints).empty());
  }
}

TEST(Hexapod, nothing_is_taken_from_the_heap) {
  const PoseBP X_far{rotation_x(1), {0.3, 0, 0.1}};
  const test::AllocationCounter allocations;
  const JointVector legs = kHexapod.inverse(yawed(5));
  const auto found = kHexapod.forward(legs, kGeometry.X_BP_home);
  const auto refused = kHexapod.forward(legs, yawed(60));
  const HexapodViolations violations = kHexapod.check(X_far, kLegJoints);
  const HexapodJacobian J = kHexapod.jacobian(X_far);
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_TRUE(found);
  EXPECT_FALSE(refused);
  EXPECT_FALSE(violations.empty());
  EXPECT_NE(J[0][0], 0);
}

}  // namespace
}  // namespace sinew::kinematics
