// The inverses of all serial robots: round trips, branches, limits, singular and unreachable poses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/serial_test_robot.h"
#include "support/allocation_guard.h"

namespace sinew::kinematics {
namespace {

constexpr double kPoseTolerance = 1e-9;   // m and rad
constexpr double kJointTolerance = 1e-6;  // rad, away from singular poses

double largest_difference(std::span<const double> a, std::span<const double> b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// Every branch puts the tool at X, says the truth about its limits, and one of them is `made`.
void expect_branches(const SerialRobot& robot, const PoseBT& X, std::span<const double> made,
                     const Expected<IkBranches>& answer, std::uint64_t& singular) {
  ASSERT_TRUE(answer) << describe(answer.error());
  double nearest = 10;
  bool flagged = false;
  for (const IkBranch& branch : *answer) {
    const PoseBT X_branch = robot.arm.forward(branch.q);
    ASSERT_LE(position_error(X_branch, X), kPoseTolerance);
    ASSERT_LE(angle_between(X_branch.R, X.R), kPoseTolerance);
    ASSERT_EQ(branch.within_limits, limit_violations(robot.model.joints, branch.q).empty());
    nearest = std::min(nearest, largest_difference(branch.q, made));
    flagged |= branch.singular != 0;
  }
  singular += flagged ? 1 : 0;
  if (!flagged) {
    ASSERT_LE(nearest, kJointTolerance);
  }
}

class SerialInverse : public testing::TestWithParam<const char*> {
 protected:
  SerialRobot robot_{GetParam()};
};
INSTANTIATE_TEST_SUITE_P(Robots, SerialInverse, testing::ValuesIn(kSerialRobots), test_name);

TEST_P(SerialInverse, finds_the_branch_that_made_the_pose) {
  std::uint64_t singular = 0;
  test::for_random_cases(100'000, [&](test::Random& random) {
    const JointVector q = robot_.random_joints(random);
    const PoseBT X = robot_.arm.forward(q);
    expect_branches(robot_, X, q, robot_.arm.inverse(X, q), singular);
  });
  EXPECT_LT(singular, 200U) << "random poses are hardly ever singular";
}

TEST_P(SerialInverse, near_singular_poses_are_flagged_and_still_exact) {
  std::uint64_t singular = 0;
  test::for_random_cases(100'000, [&](test::Random& random) {
    JointVector q = robot_.random_joints(random);
    // Straight wrist, straight elbow or both, to within 1e-12 .. 1e-5 rad.
    const double tiny = std::pow(10, random.uniform(-12, -5)) * (random.chance(0.5) ? 1 : -1);
    const bool elbow = GetParam() == std::string("learm") || GetParam() == std::string("scara");
    const std::size_t wrist = elbow ? 2 : 4;
    q[wrist] = random.chance(0.1) ? 0 : tiny;
    const PoseBT X = robot_.arm.forward(q);
    const auto answer = robot_.arm.inverse(X, q);
    expect_branches(robot_, X, q, answer, singular);
    const auto flagged = [](const IkBranch& branch) { return branch.singular != 0; };
    ASSERT_TRUE(std::any_of(answer->begin(), answer->end(), flagged));
  });
  EXPECT_EQ(singular, 100'000U);
}

TEST_P(SerialInverse, turns_of_the_joints_follow_the_reference) {
  test::for_random_cases(10'000, [&](test::Random& random) {
    const JointVector q = robot_.random_joints(random);
    const auto answer = robot_.arm.inverse(robot_.arm.forward(q), q);
    ASSERT_TRUE(answer);
    for (const IkBranch& branch : *answer) {
      for (std::size_t i = 0; i < q.size(); ++i) {
        const Joint& joint = robot_.model.joints[i];
        const bool near = std::abs(branch.q[i] - q[i]) <= kPi + 1e-9;
        const bool moved_inside = within_limits(joint, branch.q[i]);
        ASSERT_TRUE(near || moved_inside) << i;
      }
    }
  });
}

TEST_P(SerialInverse, numeric_solver_agrees_with_the_closed_form) {
  // A 5R arm's pose is reachable here because it comes from joints.
  const SerialChain& chain = robot_.arm.chain();
  std::uint64_t solved = 0;
  std::uint64_t asked = 0;
  test::for_random_cases(20'000, [&](test::Random& random) {
    const JointVector q = robot_.random_joints(random);
    const JointVector start = robot_.random_joints(random);
    const PoseBF X = chain.forward(q);
    const auto answer = inverse_numeric(chain, robot_.model.joints, X, start);
    ++asked;
    if (!answer) return random.discard();
    ++solved;
    const PoseBF X_found = chain.forward(answer->q);
    ASSERT_LE(norm(X_found.p - X.p), kPoseTolerance);
    ASSERT_LE(angle_between(X_found.R, X.R), kPoseTolerance);
    ASSERT_TRUE(limit_violations(robot_.model.joints, answer->q).empty());
  });
  EXPECT_GE(static_cast<double>(solved), 0.999 * static_cast<double>(asked)) << solved;
}

TEST_P(SerialInverse, nothing_allocates) {
  test::Random random(3);
  const JointVector q = robot_.random_joints(random);
  const PoseBT X = robot_.arm.forward(q);
  const test::AllocationCounter allocations;
  const auto answer = robot_.arm.inverse(X, q);
  const auto pitched = robot_.arm.inverse_nearest_pitch(X.p, kPi);
  const auto numeric =
      inverse_numeric(robot_.arm.chain(), robot_.model.joints,
                      X * robot_.arm.tool().inverse() * Pose<frame::Flange, frame::Flange>{}, q);
  EXPECT_EQ(allocations.count(), 0U);
  EXPECT_TRUE(answer);
  EXPECT_TRUE(numeric);
  EXPECT_TRUE(pitched.has_value() || !describe(pitched.error()).empty());
}

TEST_P(SerialInverse, far_targets_are_refused_with_the_missing_length) {
  const auto answer = robot_.arm.inverse({rotation_y(kPi / 2), {10, 0, 0}});
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, ErrorCode::kOutOfReach);
  EXPECT_GT(answer.error().measured - answer.error().limit, 8) << describe(answer.error());
}

TEST(SixR, wrist_on_the_first_axis_keeps_the_joint_it_has) {
  const SerialRobot robot("robot-arm-2");
  const JointVector q{0.7, 0, 0, 0.3, 0.5, -0.2};
  for (const double height : {0.55, 0.7}) {
    const Rotation R = robot.arm.forward(q).R;
    const double d6 = robot.geometry.rows[5].d;
    const PoseBT X{R, Vec3{0, 0, height} + d6 * R.z};
    const auto answer = robot.arm.inverse(X, q);
    ASSERT_TRUE(answer) << describe(answer.error());
    for (const IkBranch& branch : *answer) {
      EXPECT_TRUE(branch.singular & kShoulderBit);
      EXPECT_LE(position_error(robot.arm.forward(branch.q), X), kPoseTolerance);
      EXPECT_LE(angle_between(robot.arm.forward(branch.q).R, X.R), kPoseTolerance);
    }
    EXPECT_NEAR((*answer)[0].q[0], q[0], 1e-9);
  }
}

TEST(SixR, straight_arm_on_the_edge_of_its_reach_is_accepted) {
  const SerialRobot robot("robot-arm-2");
  const auto& rows = robot.geometry.rows;
  JointVector q{0.1, -0.5, 0, 0.4, 0.6, 0.2};
  q[2] = std::atan2(rows[3].d, rows[2].a);  // forearm in line with the upper arm
  const PoseBT X = robot.arm.forward(q);
  const auto answer = robot.arm.inverse(X, q);
  ASSERT_TRUE(answer) << describe(answer.error());
  for (const IkBranch& branch : *answer) {
    EXPECT_LE(position_error(robot.arm.forward(branch.q), X), kPoseTolerance);
  }
  EXPECT_TRUE((*answer)[0].singular & kElbowBit);
}

TEST(SixR, any_offsets_and_signs_of_the_structure_are_solved) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const auto right = [&] { return random.chance(0.5) ? kPi / 2 : -kPi / 2; };
    const auto length = [&] { return random.uniform(-0.2, 0.2); };
    const auto offset = [&] { return random.uniform(-kPi, kPi); };
    SerialGeometry geometry;
    geometry.rows = {{length(), length(), right(), offset()},
                     {length(), random.uniform(0.1, 0.5), 0, offset()},
                     {length(), length(), right(), offset()},
                     {random.uniform(0.1, 0.5), 0, right(), offset()},
                     {0, 0, right(), offset()},
                     {length(), length(), offset(), offset()}};
    std::vector<Joint> joints(6);
    JointVector q;
    for (Joint& joint : joints) {
      joint.lower = -2 * kPi;
      joint.upper = 2 * kPi;
      q.push_back(random.uniform(-kPi, kPi));
    }
    const auto solver = SixR::match(geometry, joints);
    ASSERT_TRUE(solver);
    const SerialChain chain(geometry);
    const PoseBF X = chain.forward(q);
    const auto answer = solver->inverse(X, q);
    ASSERT_TRUE(answer) << describe(answer.error());
    double nearest = 10;
    for (const IkBranch& branch : *answer) {
      const PoseBF X_branch = chain.forward(branch.q);
      ASSERT_LE(norm(X_branch.p - X.p), kPoseTolerance);
      ASSERT_LE(angle_between(X_branch.R, X.R), kPoseTolerance);
      nearest = std::min(nearest, branch.singular != 0 ? 0 : largest_difference(branch.q, q));
    }
    ASSERT_LE(nearest, kJointTolerance);
  });
}

TEST(NumericIk, straight_chain_is_in_reach_of_its_own_links) {
  SerialGeometry planar;
  planar.rows = {{0, 0.2, 0, 0}, {0, 0.18, 0, 0}, {0, 0.1021, 0, 0}};
  std::vector<Joint> joints(3);
  for (Joint& joint : joints) {
    joint.lower = -kPi;
    joint.upper = kPi;
  }
  const SerialChain chain(planar);
  test::for_random_cases(2'000, [&](test::Random& random) {
    const JointVector q{random.uniform(-3, 3), 0, 0};
    const auto answer = inverse_numeric(chain, joints, chain.forward(q), q);
    ASSERT_TRUE(answer) << describe(answer.error());
  });
}

TEST(SixR, other_structures_are_left_to_the_numeric_solver) {
  const SerialRobot robot("robot-arm-2");
  SerialGeometry bent = robot.geometry;
  bent.rows[4].d = 0.01;  // the wrist axes miss each other
  EXPECT_FALSE(SixR::match(bent, robot.model.joints));
  const SerialArm arm(bent, robot.model.joints, tool_pose(bent));
  test::Random random(5);
  const PoseBT X = arm.forward(robot.random_joints(random));
  const auto answer = arm.inverse(X);
  ASSERT_TRUE(answer) << describe(answer.error());
  EXPECT_LE(position_error(arm.forward((*answer)[0].q), X), kPoseTolerance);
}

TEST(FiveRPitch, straight_down_ring_of_learm_is_as_narrow_as_documented) {
  // Height z, jaws 30 mm apart: inner and outer radius that are inside the limits, mm.
  struct Ring {
    double z_mm, inner_mm, outer_mm;
  };
  const SerialRobot robot("learm");
  const SerialArm arm(robot.geometry, robot.model.joints, tool_pose(robot.geometry, 0.030));
  for (const auto& [z_mm, inner_mm, outer_mm] :
       {Ring{0, 126, 176}, Ring{15, 116, 159}, Ring{20, 112, 152}}) {
    double inner = 0;
    double outer = 0;
    for (int quarter = 200; quarter < 1600; ++quarter) {
      const double r_mm = 0.25 * quarter;
      const auto answer = arm.inverse_at_pitch({from_mm(r_mm), 0, from_mm(z_mm)}, kPi);
      const bool inside = answer && std::any_of(answer->begin(), answer->end(),
                                                [](const IkBranch& b) { return b.within_limits; });
      if (!inside) continue;
      if (inner == 0) inner = r_mm;
      outer = r_mm;
    }
    EXPECT_NEAR(inner, inner_mm, 1.0) << z_mm;
    EXPECT_NEAR(outer, outer_mm, 1.0) << z_mm;
  }
}

TEST(FiveRPitch, lateral_offset_is_left_to_the_numeric_solver) {
  const SerialRobot robot("learm");
  SerialGeometry offset = robot.geometry;
  offset.rows[1].d = 0.02;
  EXPECT_FALSE(FiveRPitch::match(offset, robot.model.joints));
  const SerialArm arm(offset, robot.model.joints, tool_pose(offset));
  test::for_random_cases(200, [&](test::Random& random) {
    const PoseBT X = arm.forward(robot.random_joints(random));
    const auto answer = arm.inverse(X);
    ASSERT_TRUE(answer) << describe(answer.error());
    ASSERT_LE(position_error(arm.forward((*answer)[0].q), X), kPoseTolerance);
    ASSERT_LE(angle_between(arm.forward((*answer)[0].q).R, X.R), kPoseTolerance);
  });
}

TEST(FiveRPitch, point_behind_the_base_is_reached_with_the_roll_as_it_is) {
  const SerialRobot robot("learm");
  const Vec3 p{-0.2, 0.05, 0.2};
  const auto answer = robot.arm.inverse_nearest_pitch(p, kPi, JointVector{0, 0, 0, 0, 0.3});
  ASSERT_TRUE(answer) << describe(answer.error());
  bool inside = false;
  for (const IkBranch& branch : answer->branches) {
    EXPECT_LE(norm(robot.arm.forward(branch.q).p - p), kPoseTolerance);
    EXPECT_EQ(branch.q[4], 0.3);
    inside |= branch.within_limits;
  }
  EXPECT_TRUE(inside);
}

TEST(FiveRPitch, both_families_of_a_pose_turn_the_roll_by_half_a_turn) {
  const SerialRobot robot("learm");
  const auto answer = robot.arm.inverse(robot.arm.forward(JointVector{0.4, 0.3, 0.5, 0.2, 0.1}));
  ASSERT_TRUE(answer);
  ASSERT_EQ(answer->size(), 4U);
  EXPECT_NEAR(std::abs((*answer)[2].q[0] - (*answer)[0].q[0]), kPi, 1e-12);
  EXPECT_NEAR(std::abs((*answer)[2].q[4] - (*answer)[0].q[4]), kPi, 1e-12);
}

TEST(FiveRPitch, pose_out_of_the_arms_plane_is_refused_by_its_angle) {
  const SerialRobot robot("learm");
  const PoseBT X{rotation_y(from_deg(90)), {0.2, 0.1, 0.2}};
  const auto answer = robot.arm.inverse(X);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, ErrorCode::kApproachOutOfPlane);
  EXPECT_NEAR(answer.error().measured, std::atan2(0.1, 0.2), 1e-12);
}

TEST(FiveRPitch, chosen_pitch_is_the_smallest_tilt_that_the_limits_allow) {
  const SerialRobot robot("learm");
  std::uint64_t found = 0;
  test::for_random_cases(2'000, [&](test::Random& random) {
    const Vec3 p{random.uniform(0.08, 0.35), random.uniform(-0.15, 0.15), random.uniform(0, 0.2)};
    const auto answer = robot.arm.inverse_nearest_pitch(p, kPi);
    if (!answer) return random.discard();
    ++found;
    const double tilt = std::abs(answer->pitch - kPi);
    if (tilt < 1e-3) return random.discard();
    // A thousandth of a radian nearer to straight down there is no branch inside the limits.
    for (const double side : {-1.0, 1.0}) {
      const auto nearer = robot.arm.inverse_at_pitch(p, kPi + side * (tilt - 1e-3));
      ASSERT_FALSE(nearer && std::any_of(nearer->begin(), nearer->end(),
                                         [](const IkBranch& b) { return b.within_limits; }));
    }
  });
  EXPECT_GT(found, 500U);
}

TEST(FiveRRoll, in_plane_target_leaves_the_forearm_unrolled) {
  const SerialRobot robot("bigrobotarm");
  const auto answer = robot.arm.inverse_at_pitch({0.3, 0.1, 0.2}, from_deg(120));
  ASSERT_TRUE(answer);
  bool unrolled = false;
  for (const IkBranch& branch : *answer) unrolled |= std::abs(branch.q[3]) < 1e-9;
  EXPECT_TRUE(unrolled);
}

TEST(FiveRRoll, approach_out_of_the_plane_is_met_by_rolling_the_forearm) {
  const SerialRobot robot("bigrobotarm");
  test::for_random_cases(100'000, [&](test::Random& random) {
    const JointVector q = robot.random_joints(random);
    const PoseBT X = robot.arm.forward(q);
    const auto solver = FiveRRoll::match(robot.geometry, robot.model.joints);
    const auto answer = solver->inverse({X.p, X.R.z}, q);
    ASSERT_TRUE(answer);
    double nearest = 10;
    for (const IkBranch& branch : *answer) {
      const PoseBT X_branch = robot.arm.forward(branch.q);
      ASSERT_LE(position_error(X_branch, X), kPoseTolerance);
      ASSERT_LE(norm(X_branch.R.z - X.R.z), kPoseTolerance);
      nearest = std::min(nearest, branch.singular != 0 ? 0 : largest_difference(branch.q, q));
    }
    ASSERT_LE(nearest, kJointTolerance);
  });
}

TEST(FiveRRoll, roll_that_is_not_free_is_refused_with_the_roll_it_would_be) {
  const SerialRobot robot("bigrobotarm");
  PoseBT X = robot.arm.forward(JointVector{0.2, 0.3, 0.4, 0.5, 0.6});
  X.R = X.R * rotation_z(0.1);
  const auto answer = robot.arm.inverse(X);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, ErrorCode::kRollNotFree);
  EXPECT_NEAR(answer.error().measured, 0.1, 1e-9);
}

TEST(FiveRRoll, straight_wrist_lists_no_joints_twice) {
  const SerialRobot robot("bigrobotarm");
  const JointVector q{0, from_deg(-1.8), from_deg(-45), from_deg(-67.5), 0};
  const auto answer = robot.arm.inverse(robot.arm.forward(q), q);
  ASSERT_TRUE(answer) << describe(answer.error());
  for (std::size_t i = 0; i < answer->size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT(largest_difference((*answer)[i].q, (*answer)[j].q), 1e-3) << i << " " << j;
    }
  }
}

TEST(FiveRRoll, straight_up_arm_is_solved_with_base_and_roll_where_they_are) {
  const SerialRobot robot("bigrobotarm");
  const JointVector q{0.25, 0, 0, -0.5, 0};
  const auto answer = robot.arm.inverse(robot.arm.forward(q), q);
  ASSERT_TRUE(answer) << describe(answer.error());
  EXPECT_LE(largest_difference((*answer)[0].q, q), 1e-6);
}

}  // namespace
}  // namespace sinew::kinematics
