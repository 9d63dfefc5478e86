#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/hexapod.h"
#include "sinew/kinematics/hexapod_test_robot.h"
#include "support/property.h"

namespace sinew::kinematics {
namespace {

const HexapodGeometry kGeometry = test::default_hexapod_geometry();
const std::array<Joint, kLegs> kLegJoints = test::default_hexapod_legs();
const Hexapod kHexapod(kGeometry);

PoseBP yawed(double yaw_deg) {
  return {rotation_z(from_deg(yaw_deg)), {0, 0, 0.25}};
}

Vec3 random_vector(test::Random& random, double bound) {
  return {random.uniform(-bound, bound), random.uniform(-bound, bound),
          random.uniform(-bound, bound)};
}

/// A pose that passes every check of the machine.
PoseBP workspace_pose(test::Random& random) {
  while (true) {
    const PoseBP X_BP{rotation_from_vector(random_vector(random, 0.6)),
                      Vec3{0, 0, 0.245} + random_vector(random, 0.08)};
    if (kHexapod.check(X_BP, kLegJoints).empty()) return X_BP;
  }
}

PoseBP nudged(test::Random& random, const PoseBP& X_BP, double shift, double turn) {
  return {rotation_from_vector(random_vector(random, turn)) * X_BP.R,
          X_BP.p + random_vector(random, shift)};
}

double leg_error(const JointVector& legs, const PoseBP& X_BP) {
  const JointVector got = kHexapod.inverse(X_BP);
  double worst = 0;
  for (std::size_t i = 0; i < kLegs; ++i) worst = std::max(worst, std::abs(got[i] - legs[i]));
  return worst;
}

void expect_same_pose(const PoseBP& X, const PoseBP& Y, double tolerance) {
  EXPECT_LT(norm(X.p - Y.p), tolerance);
  EXPECT_LT(angle_between(X.R, Y.R), tolerance);
}

struct Start {
  double shift;  // m
  double turn;   // rad
  int iterations;
};

TEST(HexapodForward, of_inverse_gives_every_pose_of_the_workspace_back) {
  constexpr std::uint64_t kCases = 100'000;
  for (const Start& start : {Start{0.0003, 0.003, 1}, Start{0.003, 0.03, 2}, Start{0.02, 0.2, 4}}) {
    std::uint64_t slow = 0;
    test::for_random_cases(kCases, [&](test::Random& random) {
      const PoseBP X_BP = workspace_pose(random);
      const JointVector legs = kHexapod.inverse(X_BP);
      const auto found = kHexapod.forward(legs, nudged(random, X_BP, start.shift, start.turn));
      ASSERT_TRUE(found) << describe(found.error());
      expect_same_pose(found->X_BP, X_BP, 1e-9);
      if (found->iterations > start.iterations) ++slow;
      EXPECT_LE(found->residual, kHexapodResidual);
      EXPECT_LT(leg_error(legs, found->X_BP), 1.1e-12);
    });
    // Near the border of the workspace about one far start in a million needs 5 or 6.
    EXPECT_LE(slow, kCases / 10'000);
  }
}

TEST(HexapodForward, of_random_legs_has_these_legs) {
  int found_count = 0;
  test::for_random_cases(100'000, [&](test::Random& random) {
    JointVector legs;
    for (std::size_t i = 0; i < kLegs; ++i) legs.push_back(random.uniform(0.245, 0.295));
    const auto found = kHexapod.forward(legs, kGeometry.X_BP_home);
    // Some such sets belong to no pose, others to one that is turned too far.
    if (!found) return random.discard();
    ++found_count;
    EXPECT_LT(leg_error(legs, found->X_BP), 1.1e-12);
    EXPECT_LE(angle_between(found->X_BP.R, Rotation{}), kHexapodTurnMax + 1e-9);
  });
  EXPECT_GT(found_count, 80'000);
}

TEST(HexapodForward, every_answer_has_the_legs_and_is_near_the_last_pose) {
  std::array<int, 2> outcomes{};
  test::for_random_cases(100'000, [&](test::Random& random) {
    const PoseBP X_BP = workspace_pose(random);
    const JointVector legs = kHexapod.inverse(X_BP);
    const PoseBP X_BP_last = nudged(random, X_BP, 0.08, 0.9);
    const auto found = kHexapod.forward(legs, X_BP_last);
    outcomes[found ? 1 : 0]++;
    if (found) {
      EXPECT_LT(leg_error(legs, found->X_BP), 1.1e-12);
      EXPECT_LE(angle_between(found->X_BP.R, X_BP_last.R), kHexapodTurnMax + 1e-9);
    } else if (found.error().code == ErrorCode::kAmbiguousAssembly) {
      EXPECT_GT(found.error().measured, found.error().limit);
    } else if (found.error().code == ErrorCode::kNotConverged) {
      EXPECT_GT(found.error().measured, kHexapodResidual);
    } else {
      EXPECT_EQ(found.error().code, ErrorCode::kSingular);
    }
  });
  for (const int count : outcomes) EXPECT_GT(count, 1000);
}

TEST(HexapodForward, answer_turned_by_more_than_30_deg_is_ambiguous) {
  const JointVector legs = kHexapod.inverse(yawed(40));
  const auto refused = kHexapod.forward(legs, yawed(9));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kAmbiguousAssembly);
  EXPECT_NEAR(to_deg(refused.error().measured), 31, 1e-6);
  EXPECT_EQ(refused.error().limit, kHexapodTurnMax);
  const auto found = kHexapod.forward(legs, yawed(11));
  ASSERT_TRUE(found) << describe(found.error());
  expect_same_pose(found->X_BP, yawed(40), 1e-9);
}

TEST(HexapodForward, mirrored_platform_below_the_base_is_ambiguous) {
  // The same legs fit a platform below the base with the same rotation. Nearly flat starts find
  // it; the platform has not turned then, but its legs have.
  int mirrored = 0;
  test::for_random_cases(20'000, [&](test::Random& random) {
    const PoseBP X_BP_last = nudged(random, {Rotation{}, {0, 0, 0.08}}, 0.07, 0.5);
    const auto found = kHexapod.forward(kHexapod.inverse(yawed(0)), X_BP_last);
    if (found || found.error().code != ErrorCode::kAmbiguousAssembly) return random.discard();
    if (found.error().index < 0) return random.discard();
    ++mirrored;
    EXPECT_GT(found.error().measured, 2 * kGeometry.cardan_angle_max);
  });
  EXPECT_GT(mirrored, 10);
}

TEST(HexapodForward, legs_that_close_no_platform_are_refused) {
  // Five legs of the home pose and a sixth of half their length.
  JointVector legs = kHexapod.inverse(kGeometry.X_BP_home);
  legs[2] *= 0.2;
  const auto refused = kHexapod.forward(legs, kGeometry.X_BP_home);
  ASSERT_FALSE(refused);
}

TEST(HexapodForward, length_that_is_no_length_is_refused_with_its_leg) {
  for (const double bad : {0.0, -0.268, std::nan("")}) {
    for (std::size_t i = 0; i < kLegs; ++i) {
      JointVector legs = kHexapod.inverse(kGeometry.X_BP_home);
      legs[i] = bad;
      const auto refused = kHexapod.forward(legs, kGeometry.X_BP_home);
      ASSERT_FALSE(refused);
      EXPECT_EQ(refused.error().code, ErrorCode::kLegLength);
      EXPECT_EQ(refused.error().index, static_cast<int>(i));
    }
  }
  JointVector legs = kHexapod.inverse(kGeometry.X_BP_home);
  legs[3] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(kHexapod.forward(legs, kGeometry.X_BP_home));
  EXPECT_FALSE(kHexapod.forward(kHexapod.inverse(kGeometry.X_BP_home),
                                {Rotation{}, {0, std::nan(""), 0.25}}));
}

TEST(HexapodForward, start_on_a_singularity_is_refused) {
  for (const Vec3& p : {Vec3{0, 0, 0.25}, Vec3{0.013, -0.007, 0.23}}) {
    const auto refused = kHexapod.forward(kHexapod.inverse(yawed(80)), {yawed(90).R, p});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kSingular);
    EXPECT_LT(refused.error().measured, 1e-14);
  }
}

TEST(HexapodForward, is_exact_up_to_a_condition_number_of_100) {
  test::for_random_cases(20'000, [](test::Random& random) {
    PoseBP X_BP = yawed(random.uniform(70, 88) * (random.chance(0.5) ? 1 : -1));
    X_BP = nudged(random, X_BP, 0.02, 0.01);
    if (kHexapod.dexterity(X_BP).condition > 100) return random.discard();
    const auto found =
        kHexapod.forward(kHexapod.inverse(X_BP), nudged(random, X_BP, 0.0003, 0.003));
    ASSERT_TRUE(found) << describe(found.error());
    expect_same_pose(found->X_BP, X_BP, 1e-9);
  });
}

// Condition numbers above 1e6 are called near-singular here: the legs are still met, the pose is
// not determined by them any more, and check() refuses every one of these poses.
TEST(HexapodForward, near_a_singularity_the_legs_are_met_and_the_pose_is_flagged) {
  int found_count = 0;
  test::for_random_cases(20'000, [&](test::Random& random) {
    const double off_deg = std::pow(10, random.uniform(-9, -4.3)) * (random.chance(0.5) ? 1 : -1);
    const PoseBP X_BP = yawed(90 + off_deg);
    EXPECT_GT(kHexapod.dexterity(X_BP).condition, 1e6);
    EXPECT_LT(kHexapod.dexterity(X_BP).condition, 1e12);
    const HexapodViolations violations = kHexapod.check(X_BP, kLegJoints);
    ASSERT_FALSE(violations.empty());
    EXPECT_EQ(violations.back().code, ErrorCode::kConditionNumber);
    const JointVector legs = kHexapod.inverse(X_BP);
    const auto found = kHexapod.forward(legs, nudged(random, X_BP, 1e-4, 1e-3));
    if (!found) return;
    ++found_count;
    EXPECT_LT(leg_error(legs, found->X_BP), 1.1e-12);
  });
  EXPECT_GT(found_count, 1000);
}

TEST(HexapodForward, tracking_for_a_long_time_stays_a_rotation_and_loses_nothing) {
  PoseBP X_BP_last = kGeometry.X_BP_home;
  for (int i = 0; i < 300'000; ++i) {
    const double t = 1e-3 * i;
    const PoseBP X_BP{
        rotation_from_vector(
            {0.2 * std::sin(t), 0.15 * std::cos(1.3 * t), 0.2 * std::sin(0.7 * t)}),
        {0.02 * std::cos(t), 0.02 * std::sin(1.1 * t), 0.25 + 0.02 * std::sin(0.9 * t)}};
    const auto found = kHexapod.forward(kHexapod.inverse(X_BP), X_BP_last);
    if (i == 0 && !found) continue;
    ASSERT_TRUE(found) << i << " " << describe(found.error());
    X_BP_last = found->X_BP;
    if (i % 100 == 0) expect_same_pose(X_BP_last, X_BP, 1e-10);
  }
  const Rotation identity = X_BP_last.R * X_BP_last.R.transposed();
  EXPECT_LT(norm(identity.x - Vec3{1, 0, 0}), 1e-14);
  EXPECT_LT(norm(identity.y - Vec3{0, 1, 0}), 1e-14);
  EXPECT_LT(norm(identity.z - Vec3{0, 0, 1}), 1e-14);
}

/// Forward kinematics in another formulation: position and quaternion as seven free numbers, true
/// lengths, a numeric Jacobian, no constant shared with the code under test.
class Oracle {
 public:
  using Vector7 = Eigen::Matrix<double, 7, 1>;
  using Matrix7 = Eigen::Matrix<double, 7, 7>;

  explicit Oracle(const JointVector& legs) : legs_(legs) {}

  static Vector7 state(const PoseBP& X_BP) {
    const auto wxyz = quaternion_wxyz(X_BP.R);
    Vector7 x;
    x << X_BP.p.x, X_BP.p.y, X_BP.p.z, wxyz[0], wxyz[1], wxyz[2], wxyz[3];
    return x;
  }
  static PoseBP pose(const Vector7& x) {
    return {rotation_from_quaternion({x(3), x(4), x(5), x(6)}), {x(0), x(1), x(2)}};
  }

  std::optional<PoseBP> solve(Vector7 x) const {
    for (int iteration = 0; iteration < 50; ++iteration) {
      const Vector7 f = residual(x);
      if (f.norm() < 1e-13) return pose(x);
      Matrix7 slope;
      constexpr double kStep = 1e-6;
      for (Eigen::Index k = 0; k < 7; ++k) {
        const Vector7 step = kStep * Vector7::Unit(k);
        slope.col(k) = (residual(x + step) - residual(x - step)) / (2 * kStep);
      }
      x -= slope.partialPivLu().solve(f);
    }
    return std::nullopt;
  }

 private:
  Vector7 residual(const Vector7& x) const {
    const Eigen::Quaterniond q(x(3), x(4), x(5), x(6));
    Vector7 f;
    for (std::size_t i = 0; i < kLegs; ++i) {
      const Vec3& a = kGeometry.p_PA[i];
      const Vec3& b = kGeometry.p_BA[i];
      const Eigen::Vector3d leg = x.head<3>() +
                                  q.toRotationMatrix() * Eigen::Vector3d(a.x, a.y, a.z) -
                                  Eigen::Vector3d(b.x, b.y, b.z);
      f(static_cast<Eigen::Index>(i)) = leg.norm() - legs_[i];
    }
    f(6) = q.squaredNorm() - 1;
    return f;
  }

  JointVector legs_;
};

/// Of the assemblies that many starts around the last pose lead to, the one turned least from it.
std::optional<PoseBP> nearest_assembly(test::Random& random, const Oracle& oracle,
                                       const PoseBP& X_BP_last) {
  std::optional<PoseBP> nearest;
  for (int start = 0; start < 8; ++start) {
    const PoseBP X_start =
        start == 0 ? X_BP_last : nudged(random, X_BP_last, 0.04, 0.1 * static_cast<double>(start));
    const auto X_BP = oracle.solve(Oracle::state(X_start));
    if (!X_BP || X_BP->p.z < 0) continue;
    if (!nearest || angle_between(X_BP->R, X_BP_last.R) < angle_between(nearest->R, X_BP_last.R)) {
      nearest = X_BP;
    }
  }
  return nearest;
}

TEST(HexapodForward, agrees_with_a_multi_start_solver_in_quaternions) {
  test::for_random_cases(4'000, [](test::Random& random) {
    const PoseBP X_BP = workspace_pose(random);
    const JointVector legs = kHexapod.inverse(X_BP);
    const PoseBP X_BP_last = nudged(random, X_BP, 0.02, 0.2);
    const auto expected = nearest_assembly(random, Oracle(legs), X_BP_last);
    const auto found = kHexapod.forward(legs, X_BP_last);
    ASSERT_TRUE(expected);
    ASSERT_TRUE(found) << describe(found.error());
    expect_same_pose(found->X_BP, *expected, 1e-9);
  });
}

}  // namespace
}  // namespace sinew::kinematics
