#include "sinew/kinematics/palletizer.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/palletizer_test_robot.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::kinematics {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

const PalletizerGeometry kMaxArm = test::maxarm_geometry();
const std::array<Joint, 3> kJoints = test::maxarm_joints();

Vec3 point_mm(double x_mm, double y_mm, double z_mm) {
  return {from_mm(x_mm), from_mm(y_mm), from_mm(z_mm)};
}

/// Joints of an arm that nothing limits, to look at the bare geometry.
std::array<Joint, 3> unlimited_joints() {
  std::array<Joint, 3> joints = kJoints;
  for (Joint& joint : joints) {
    joint.lower = -kPi;
    joint.upper = kPi;
  }
  return joints;
}

/// A configuration inside the limits, elbow up, at least `bend_min` away from straight and folded,
/// with the nozzle outside of the radius that the firmware ignores.
JointVector random_configuration(test::Random& random, double bend_min) {
  while (true) {
    JointVector q;
    for (const Joint& joint : kJoints) q.push_back(random.uniform(joint.lower, joint.upper));
    const double bend = kPi - q[1] + q[2];
    const Vec3 p = forward(kMaxArm, q).p;
    const double r = dot(p, -forward(kMaxArm, q).R.y);
    if (bend > bend_min && bend < kPi - bend_min && r > kMaxArm.radius_min) return q;
  }
}

struct Vector {
  Vec3 p_mm;
  std::array<double, 3> q_deg;
  std::array<double, 3> pulses;
  std::array<double, 3> whole_pulses;
  Vec3 p_of_whole_pulses_mm;
};

// Computed from the lengths in the firmware; angles are printed to 1e-4 deg, the rest to 1e-3.
constexpr std::array kVectors{
    Vector{{0, -163, 212},
           {120, 90.0278, 0.3321},
           {500, 499.884, 501.384},
           {500, 499, 501},
           {0, -163.477, 212.221}},
    Vector{{120, -180, 85},
           {86.3099, 133.7099, 41.9294},
           {359.625, 317.875, 674.706},
           {359, 317, 674},
           {120.811, -180.194, 84.978}},
    Vector{{-120, -180, 85},
           {153.6901, 133.7099, 41.9294},
           {640.375, 317.875, 674.706},
           {640, 317, 674},
           {-120.056, -180.698, 84.978}},
    Vector{{0, -280, 75},
           {120, 164.8336, 18.1520},
           {500, 188.193, 575.634},
           {500, 188, 575},
           {0, -280.141, 75.248}},
    Vector{{160, 0, 200},
           {30, 88.9526, 5.3131},
           {125, 504.364, 522.138},
           {125, 504, 522},
           {160.203, 0, 200.083}},
    Vector{{150, -35, 90},
           {43.134, 112.7352, 54.8414},
           {179.725, 405.270, 728.506},
           {179, 405, 728},
           {150.469, -34.628, 90.112}},
    Vector{{0, -200, 120},
           {120, 118.2898, 34.1481},
           {500, 382.126, 642.284},
           {500, 382, 642},
           {0, -200.152, 120.104}},
    Vector{
        {0, -162.94, 212.8}, {120, 90, 0}, {500, 500, 500}, {500, 500, 500}, {0, -162.94, 212.8}},
};

std::array<double, 3> pulses_of(const JointVector& q) {
  return {to_deg(q[0]) / 0.24, (210 - to_deg(q[1])) / 0.24, (to_deg(q[2]) + 120) / 0.24};
}

JointVector angles_of_pulses(const std::array<double, 3>& pulses) {
  return {from_deg(pulses[0] * 0.24), from_deg(210 - pulses[1] * 0.24),
          from_deg(pulses[2] * 0.24 - 120)};
}

TEST(Palletizer, inverse_gives_the_angles_of_the_known_points) {
  for (const Vector& vector : kVectors) {
    const auto q = inverse(kMaxArm, kJoints, 1e-3 * vector.p_mm);
    ASSERT_TRUE(q) << describe(q.error());
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(to_deg((*q)[i]), vector.q_deg[i], 5.1e-5) << "joint " << i;
      EXPECT_NEAR(pulses_of(*q)[i], vector.pulses[i], 5.1e-4) << "joint " << i;
    }
  }
}

TEST(Palletizer, forward_gives_the_point_of_the_whole_pulses) {
  for (const Vector& vector : kVectors) {
    const Vec3 p = forward(kMaxArm, angles_of_pulses(vector.whole_pulses)).p;
    const Vec3 expected = 1e-3 * vector.p_of_whole_pulses_mm;
    EXPECT_NEAR(p.x, expected.x, 5.1e-7);
    EXPECT_NEAR(p.y, expected.y, 5.1e-7);
    EXPECT_NEAR(p.z, expected.z, 5.1e-7);
  }
}

TEST(Palletizer, home_of_the_vendor_that_sits_on_a_limit_is_accepted) {
  const auto q = inverse(kMaxArm, kJoints, point_mm(0, -162.94, 212.8));
  ASSERT_TRUE(q) << describe(q.error());
  EXPECT_NEAR((*q)[2], 0, 1e-12);
}

TEST(Palletizer, limits_are_inclusive_and_say_by_how_much_they_are_passed) {
  for (std::size_t i = 0; i < 3; ++i) {
    // One end of the range is moved onto the angle of joint i, which then goes 2 deg past it.
    for (const bool upper : {false, true}) {
      JointVector q{from_deg(100), from_deg(110), from_deg(50)};
      std::array<Joint, 3> joints = kJoints;
      (upper ? joints[i].upper : joints[i].lower) = q[i];
      EXPECT_TRUE(inverse(kMaxArm, joints, forward(kMaxArm, q).p));
      q[i] += upper ? from_deg(2) : from_deg(-2);
      const auto refused = inverse(kMaxArm, joints, forward(kMaxArm, q).p);
      ASSERT_FALSE(refused);
      EXPECT_EQ(refused.error().code, ErrorCode::kJointLimit);
      EXPECT_EQ(refused.error().index, static_cast<int>(i));
      EXPECT_NEAR(refused.error().measured, q[i], 1e-9);
      EXPECT_EQ(refused.error().limit, upper ? joints[i].upper : joints[i].lower);
    }
  }
}

TEST(Palletizer, points_above_and_behind_are_refused_with_the_joint_and_its_degrees) {
  const auto above = inverse(kMaxArm, kJoints, point_mm(0, -100, 240));
  ASSERT_FALSE(above);
  EXPECT_EQ(above.error().code, ErrorCode::kJointLimit);
  EXPECT_EQ(above.error().index, 2);
  EXPECT_NEAR(to_deg(above.error().measured), -17.06, 0.005);
  EXPECT_EQ(above.error().limit, 0);

  const auto behind = inverse(kMaxArm, kJoints, point_mm(100, 100, 100));
  ASSERT_FALSE(behind);
  EXPECT_EQ(behind.error().code, ErrorCode::kJointLimit);
  EXPECT_EQ(behind.error().index, 0);
  EXPECT_NEAR(to_deg(behind.error().measured), -15, 1e-9);
}

TEST(Palletizer, point_behind_on_the_left_is_past_the_upper_limit_of_the_base) {
  const auto refused = inverse(kMaxArm, kJoints, point_mm(-100, 100, 100));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().index, 0);
  EXPECT_NEAR(to_deg(refused.error().measured), 255, 1e-9);
  EXPECT_EQ(refused.error().limit, kJoints[0].upper);
}

TEST(Palletizer, point_out_of_reach_says_how_far) {
  // Straight out at shoulder height: L1 + L2 + L3 + L4 = 291.34 mm is the longest reach.
  EXPECT_TRUE(inverse(kMaxArm, kJoints, point_mm(0, -291.34, 84.4)));
  const auto refused = inverse(kMaxArm, kJoints, point_mm(0, -303.34, 84.4));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kOutOfReach);
  EXPECT_NEAR(refused.error().measured - refused.error().limit, from_mm(12), 1e-12);
  EXPECT_EQ(describe(refused.error()),
            "out of reach by 12 mm: needs 278.4 mm, the arm has 266.4 mm");
}

TEST(Palletizer, point_near_the_base_axis_is_too_close) {
  EXPECT_TRUE(inverse(kMaxArm, kJoints, point_mm(30, -40, 100)));
  const auto refused = inverse(kMaxArm, kJoints, point_mm(0, -49.9, 100));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooClose);
  EXPECT_NEAR(refused.error().measured, from_mm(49.9), 1e-15);
  EXPECT_EQ(refused.error().limit, from_mm(50));
}

TEST(Palletizer, point_inside_the_folded_arm_is_too_close) {
  PalletizerGeometry geometry = kMaxArm;
  geometry.radius_min = 0;
  // 5 mm in front of the shoulder; the folded arm cannot come nearer than L3 - L2 = 9.6 mm.
  const auto refused = inverse(geometry, unlimited_joints(), point_mm(0, -29.94, 84.4));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooClose);
  EXPECT_NEAR(refused.error().measured, from_mm(5), 1e-12);
  EXPECT_NEAR(refused.error().limit, from_mm(9.6), 1e-12);
}

TEST(Palletizer, target_that_is_not_a_number_is_refused) {
  for (const double bad : {kNotANumber, kInfinity, -kInfinity}) {
    EXPECT_FALSE(inverse(kMaxArm, kJoints, {bad, -0.2, 0.1}));
    EXPECT_FALSE(inverse(kMaxArm, kJoints, {0, bad, 0.1}));
    EXPECT_FALSE(inverse(kMaxArm, kJoints, {0, -0.2, bad}));
  }
}

TEST(Palletizer, tool_stays_level_and_turns_with_the_base) {
  EXPECT_LT(angle_between(forward(kMaxArm, JointVector{from_deg(120), 1.5, 0.3}).R, Rotation{}),
            1e-15);
  test::for_random_cases(100'000, [](test::Random& random) {
    const JointVector q = random_configuration(random, 0);
    const auto X_BT = forward(kMaxArm, q);
    EXPECT_NEAR(X_BT.R.z.z, 1, 1e-15);
    // The arm lies along the tool's -y: seen from the tool the base axis is straight behind it.
    const Vec3 p_TB = X_BT.inverse().p;
    EXPECT_NEAR(p_TB.x, 0, 1e-15);
    EXPECT_GT(p_TB.y, 0);
  });
}

TEST(Palletizer, inverse_of_forward_gives_the_joints_back) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const JointVector q = random_configuration(random, from_deg(0.5));
    const auto back = inverse(kMaxArm, kJoints, forward(kMaxArm, q).p);
    ASSERT_TRUE(back) << describe(back.error());
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR((*back)[i], q[i], 1e-9);
  });
}

TEST(Palletizer, forward_of_inverse_gives_every_point_back_or_says_why_not) {
  int accepted = 0;
  test::for_random_cases(200'000, [&](test::Random& random) {
    const Vec3 p{random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-0.2, 0.3)};
    const auto q = inverse(kMaxArm, kJoints, p);
    if (q) {
      ++accepted;
      EXPECT_LT(norm(forward(kMaxArm, *q).p - p), 1e-9);
      for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(within_limits(kJoints[i], (*q)[i]));
      return;
    }
    const Error& error = q.error();
    if (error.code == ErrorCode::kTooClose) {
      EXPECT_LT(error.measured, error.limit);
    } else if (error.code == ErrorCode::kOutOfReach) {
      EXPECT_GT(error.measured, error.limit);
    } else {
      ASSERT_EQ(error.code, ErrorCode::kJointLimit);
      EXPECT_FALSE(
          within_limits(kJoints.at(static_cast<std::size_t>(error.index)), error.measured));
    }
  });
  EXPECT_GT(accepted, 30'000);
}

// The maker's one-argument arc tangent folds the arm over for points behind its shoulder.
TEST(Palletizer, point_behind_the_shoulder_leans_the_arm_back) {
  PalletizerGeometry geometry = kMaxArm;
  geometry.radius_min = 0;
  const std::array<Joint, 3> joints = unlimited_joints();
  test::for_random_cases(100'000, [&](test::Random& random) {
    const double angle = random.uniform(-kPi, kPi);
    const double radius = random.uniform(0, from_mm(24.9));
    const Vec3 p{radius * std::cos(angle), radius * std::sin(angle), random.uniform(-0.15, 0.33)};
    const auto q = inverse(geometry, joints, p);
    if (!q) {
      EXPECT_TRUE(q.error().code == ErrorCode::kTooClose ||
                  q.error().code == ErrorCode::kOutOfReach);
      return;
    }
    EXPECT_LT(norm(forward(geometry, *q).p - p), 1e-9);
  });
}

TEST(Palletizer, forward_of_an_arm_turned_inside_out_puts_the_nozzle_behind_the_base) {
  // Upper arm level to the rear, forearm straight down: r = 8.14 - 128.4 + 16.8 = -103.46 mm.
  const auto X_BT = forward(kMaxArm, JointVector{from_deg(120), 0, from_deg(90)});
  EXPECT_NEAR(X_BT.p.x, 0, 1e-15);
  EXPECT_NEAR(X_BT.p.y, from_mm(103.46), 1e-15);
  EXPECT_NEAR(X_BT.p.z, from_mm(84.4 - 138), 1e-15);
}

TEST(Palletizer, straight_and_folded_arm_keep_their_position_to_a_nanometre) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const double bend = std::pow(10, random.uniform(-12, -3));
    const double shoulder = random.uniform(from_deg(125), from_deg(200));
    const JointVector q{random.uniform(0, from_deg(240)), shoulder,
                        random.chance(0.5) ? shoulder - kPi + bend : shoulder - bend};
    const Vec3 p = forward(kMaxArm, q).p;
    PalletizerGeometry geometry = kMaxArm;
    geometry.radius_min = 0;
    const auto back = inverse(geometry, unlimited_joints(), p);
    ASSERT_TRUE(back) << describe(back.error());
    EXPECT_LT(norm(forward(geometry, *back).p - p), 1e-9);
  });
}

TEST(Palletizer, jacobian_is_the_slope_of_forward) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const JointVector q = random_configuration(random, 0);
    const PalletizerJacobian J = jacobian(kMaxArm, q);
    constexpr double kStep = 1e-5;
    for (std::size_t i = 0; i < 3; ++i) {
      JointVector ahead = q;
      JointVector behind = q;
      ahead[i] += kStep;
      behind[i] -= kStep;
      const Vec3 slope = (0.5 / kStep) * (forward(kMaxArm, ahead).p - forward(kMaxArm, behind).p);
      EXPECT_LT(norm(slope - J[i]), 1e-10);
    }
  });
}

struct ReachRow {
  double z_mm;
  double r_min_mm;
  double r_max_mm;
};

TEST(Palletizer, reach_at_each_height_is_the_documented_one) {
  // Nearest and farthest radius that can be sent; 291.34 mm is the longest of all.
  constexpr std::array kReach{ReachRow{-100, 68.4, 203.9}, ReachRow{-50, 83.5, 254.9},
                              ReachRow{0, 79.5, 277.6},    ReachRow{60, 50, 290},
                              ReachRow{84, 50, 291.34},    ReachRow{140, 50, 279},
                              ReachRow{170, 67.2, 259},    ReachRow{190, 90, 236},
                              ReachRow{204, 116, 210},     ReachRow{210, 136, 190}};
  constexpr double kStepMm = 0.01;
  for (const ReachRow& row : kReach) {
    std::optional<double> nearest;
    double farthest = 0;
    int reached = 0;
    for (int i = 0; i <= 30'000; ++i) {
      const double r_mm = i * kStepMm;
      if (!inverse(kMaxArm, kJoints, point_mm(0, -r_mm, row.z_mm))) continue;
      if (!nearest) nearest = r_mm;
      farthest = r_mm;
      ++reached;
    }
    ASSERT_TRUE(nearest) << "z " << row.z_mm;
    // The table prints most rows to a whole millimetre.
    const auto printed = [](double mm) { return mm == std::round(mm) ? 0.51 : 0.06; };
    EXPECT_NEAR(*nearest, row.r_min_mm, printed(row.r_min_mm)) << "z " << row.z_mm;
    EXPECT_NEAR(farthest, row.r_max_mm, printed(row.r_max_mm)) << "z " << row.z_mm;
    EXPECT_EQ(reached, std::lround((farthest - *nearest) / kStepMm) + 1) << "a gap at " << row.z_mm;
  }
  for (int r_mm = 0; r_mm <= 300; ++r_mm) {
    EXPECT_FALSE(inverse(kMaxArm, kJoints, point_mm(0, -r_mm, 214)));
  }
}

TEST(Palletizer, links_lie_from_joint_to_joint_along_their_own_axis) {
  test::for_random_cases(20'000, [](test::Random& random) {
    JointVector q;
    for (const Joint& joint : kJoints) q.push_back(random.uniform(joint.lower, joint.upper));
    const auto X_BT = forward(kMaxArm, q);
    const PalletizerLinks X = palletizer_links(kMaxArm, q);
    for (const auto& link : X) {
      ASSERT_LE(norm(link.R.x - X_BT.R.x), 1e-15);
      ASSERT_LE(norm(cross(link.R.x, link.R.y) - link.R.z), 1e-15);
      ASSERT_NEAR(norm(link.R.y), 1, 1e-15);
    }
    const auto& [column, upper_arm, forearm, tool] = X;
    ASSERT_EQ(tool.p, X_BT.p);
    ASSERT_EQ(column.p, Vec3{});
    ASSERT_LE(norm(column * Vec3{0, -kMaxArm.shoulder_offset, kMaxArm.base_height} - upper_arm.p),
              1e-15);
    ASSERT_LE(norm(upper_arm * Vec3{0, -kMaxArm.upper_arm, 0} - forearm.p), 1e-15);
    const Vec3 wrist = forearm * Vec3{0, -kMaxArm.forearm, 0};
    ASSERT_LE(norm(tool * Vec3{0, kMaxArm.tool_offset, 0} - wrist), 1e-15);
  });
  // Forearm level and upper arm upright, as the page draws them at the vendor's home.
  const PalletizerLinks home = palletizer_links(kMaxArm, JointVector{2 * kPi / 3, kPi / 2, 0});
  EXPECT_LE(norm(home[2].R.y - Vec3{0, 1, 0}), 1e-15);
  EXPECT_LE(norm(home[1].R.y - Vec3{0, 0, -1}), 1e-15);
}

TEST(Palletizer, nothing_is_taken_from_the_heap) {
  const JointVector q{2, 1.8, 0.4};
  const test::AllocationCounter allocations;
  const auto X_BT = forward(kMaxArm, q);
  const PalletizerJacobian J = jacobian(kMaxArm, q);
  const PalletizerLinks X = palletizer_links(kMaxArm, q);
  const bool reached = inverse(kMaxArm, kJoints, X_BT.p).has_value();
  const bool refused = !inverse(kMaxArm, kJoints, Vec3{}).has_value();
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_TRUE(reached && refused);
  EXPECT_EQ(X.back().p, X_BT.p);
  EXPECT_GT(norm(J[0]), 0);
}

}  // namespace
}  // namespace sinew::kinematics
