// Chains with prismatic joints: the closed form of a SCARA, in every order of its joints, and the
// numeric solver on rails and gantries.
#include "sinew/kinematics/scara.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/serial_arm.h"
#include "support/property.h"

namespace sinew::kinematics {
namespace {

constexpr double kExact = 1e-9;  // m and rad

Joint joint(JointKind kind, double lower, double upper) {
  return {.name = "j", .kind = kind, .lower = lower, .upper = upper};
}

struct Arm {
  SerialGeometry geometry;
  std::vector<Joint> joints;
};

/// Vertical axes, some of them pointing down, with the slide anywhere and the tool tilted.
Arm random_scara(test::Random& random) {
  Arm arm;
  const std::int64_t slide = random.integer(0, 3);
  for (std::int64_t i = 0; i < 4; ++i) {
    DhRow row{.d = random.uniform(-0.2, 0.2),
              .a = random.uniform(0.05, 0.3) * (random.chance(0.2) ? -1 : 1),
              .alpha = random.chance(0.3) ? kPi : 0,
              .theta_offset = random.uniform(-kPi, kPi)};
    if (i == slide) row.kind = JointKind::kPrismatic;
    arm.geometry.rows.push_back(row);
    arm.joints.push_back(i == slide ? joint(JointKind::kPrismatic, -0.1, 0.2)
                                    : joint(JointKind::kRevolute, -kPi, kPi));
  }
  arm.geometry.X_FT.p = {random.uniform(-0.05, 0.05), 0.02, 0.1};
  arm.geometry.X_FT.R = rotation_from_fixed_xyz({random.uniform(-3, 3), random.uniform(-1, 1), 0});
  return arm;
}

JointVector random_joints(const Arm& arm, test::Random& random) {
  JointVector q;
  for (const Joint& one : arm.joints) q.push_back(random.uniform(one.lower, one.upper));
  return q;
}

TEST(Scara, branches_put_the_tool_where_it_was_in_any_order_of_the_joints) {
  std::uint64_t near_straight = 0;
  test::for_random_cases(50'000, [&](test::Random& random) {
    const Arm arm = random_scara(random);
    const SerialArm serial(arm.geometry, arm.joints, arm.geometry.X_FT);
    if (serial.solver() != SerialArm::Solver::kScara) return random.discard();
    const JointVector q = random_joints(arm, random);
    const PoseBT X = serial.forward(q);
    const auto branches = serial.inverse(X, q);
    ASSERT_TRUE(branches) << describe(branches.error());
    double nearest = 10;
    bool singular = false;
    for (const IkBranch& branch : *branches) {
      const PoseBT found = serial.forward(branch.q);
      ASSERT_LE(norm(found.p - X.p), kExact);
      ASSERT_LE(angle_between(found.R, X.R), kExact);
      ASSERT_EQ(branch.within_limits, limit_violations(arm.joints, branch.q).empty());
      singular |= branch.singular != 0;
      double off = 0;
      for (std::size_t i = 0; i < q.size(); ++i) off = std::max(off, std::abs(branch.q[i] - q[i]));
      nearest = std::min(nearest, off);
    }
    near_straight += singular ? 1 : 0;
    if (!singular) {
      ASSERT_LE(nearest, 1e-6);
    }
  });
  EXPECT_LT(near_straight, 500U);
}

class ScaraOfFourLinks : public testing::Test {
 protected:
  ScaraOfFourLinks() {
    arm_.geometry.rows = {{.d = 0.2, .a = 0.3},
                          {.a = 0.2},
                          {.kind = JointKind::kPrismatic},
                          {.d = -0.05, .alpha = kPi}};
    arm_.joints = {joint(JointKind::kRevolute, -2, 2), joint(JointKind::kRevolute, -2.5, 2.5),
                   joint(JointKind::kPrismatic, -0.1, 0), joint(JointKind::kRevolute, -3, 3)};
  }
  SerialArm serial() const { return {arm_.geometry, arm_.joints, arm_.geometry.X_FT}; }

  Arm arm_;
};

TEST_F(ScaraOfFourLinks, has_its_tool_where_a_drawing_has_it) {
  const PoseBT X = serial().forward(JointVector{kPi / 2, -kPi / 2, -0.04, 0.3});
  EXPECT_LE(norm(X.p - Vec3{0.2, 0.3, 0.11}), kExact);
  EXPECT_LE(angle_between(X.R, rotation_z(0.3) * rotation_x(kPi)), kExact);
}

TEST_F(ScaraOfFourLinks, refuses_what_it_cannot_have_and_says_by_how_much) {
  const Rotation down = rotation_x(kPi);
  const auto error = [&](const PoseBT& X) {
    const auto answer = serial().inverse(X);
    return answer ? Error{} : answer.error();
  };
  const Error far = error({down, {0.6, 0, 0.1}});
  EXPECT_EQ(far.code, ErrorCode::kOutOfReach);
  EXPECT_NEAR(far.measured - far.limit, 0.1, kExact);
  const Error near = error({down, {0.05, 0, 0.1}});
  EXPECT_EQ(near.code, ErrorCode::kTooClose);
  EXPECT_NEAR(near.limit - near.measured, 0.05, kExact);
  const Error tilted = error({rotation_y(0.2) * down, {0.4, 0, 0.1}});
  EXPECT_EQ(tilted.code, ErrorCode::kOrientationNotReachable);
  EXPECT_NEAR(tilted.measured, 0.2, kExact);
}

TEST_F(ScaraOfFourLinks, never_takes_a_turn_for_a_way_of_its_slide) {
  // 0.1 m below the limit, and further away by 2 pi m: the same to an angle.
  for (const double z : {0.05, 0.15 + 2 * kPi, 0.15 - 2 * kPi}) {
    const auto answer = serial().inverse({rotation_x(kPi), {0.4, 0, z}});
    ASSERT_TRUE(answer);
    for (const IkBranch& branch : *answer) {
      EXPECT_NEAR(branch.q[2], z - 0.15, kExact);
      EXPECT_EQ(branch.within_limits, z == 0.05);
    }
  }
}

TEST_F(ScaraOfFourLinks, names_the_slide_in_metres_where_it_is_what_is_outside) {
  const auto answer = serial().inverse({rotation_x(kPi), {0.4, 0, 0.03}});
  ASSERT_TRUE(answer);
  const Error error = nearest_violation(arm_.joints, *answer);
  EXPECT_EQ(error.code, ErrorCode::kLegLength);
  EXPECT_EQ(error.index, 2);
  EXPECT_NEAR(error.measured, -0.12, kExact);
}

TEST_F(ScaraOfFourLinks, is_none_with_a_tilted_axis_another_slide_or_two_axes_in_one) {
  const auto solver = [&](std::size_t row, auto change) {
    Arm other = arm_;
    change(other.geometry.rows[row]);
    for (std::size_t i = 0; i < 4; ++i) other.joints[i].kind = other.geometry.rows[i].kind;
    return SerialArm(other.geometry, other.joints, {}).solver();
  };
  using Solver = SerialArm::Solver;
  EXPECT_EQ(solver(0, [](DhRow&) {}), Solver::kScara);
  EXPECT_EQ(solver(0, [](DhRow& row) { row.alpha = 0.1; }), Solver::kNumeric);
  EXPECT_EQ(solver(1, [](DhRow& row) { row.kind = JointKind::kPrismatic; }), Solver::kNumeric);
  EXPECT_EQ(solver(2, [](DhRow& row) { row.kind = JointKind::kRevolute; }), Solver::kNumeric);
  EXPECT_EQ(solver(0, [](DhRow& row) { row.a = 0; }), Solver::kNumeric);
}

/// Three slides at right angles.
Arm gantry() {
  Arm arm;
  arm.geometry.rows = {{.alpha = kPi / 2, .kind = JointKind::kPrismatic},
                       {.alpha = kPi / 2, .theta_offset = kPi / 2, .kind = JointKind::kPrismatic},
                       {.kind = JointKind::kPrismatic}};
  for (int i = 0; i < 3; ++i) arm.joints.push_back(joint(JointKind::kPrismatic, -0.4, 0.6));
  return arm;
}

/// Six joints on a rail.
Arm on_a_rail() {
  Arm arm;
  arm.geometry.rows = {{.alpha = -kPi / 2, .kind = JointKind::kPrismatic},
                       {.d = 0.1, .alpha = kPi / 2},
                       {.a = 0.3},
                       {.a = 0.05, .alpha = kPi / 2},
                       {.d = 0.3, .alpha = -kPi / 2},
                       {.alpha = kPi / 2},
                       {.d = 0.08}};
  arm.joints.push_back(joint(JointKind::kPrismatic, -0.5, 0.5));
  for (int i = 0; i < 6; ++i) arm.joints.push_back(joint(JointKind::kRevolute, -2.8, 2.8));
  return arm;
}

TEST(SlidesInAnyChain, are_solved_by_numbers_inside_their_limits) {
  for (const Arm& arm : {gantry(), on_a_rail()}) {
    const SerialArm serial(arm.geometry, arm.joints, arm.geometry.X_FT);
    EXPECT_EQ(serial.solver(), SerialArm::Solver::kNumeric);
    test::for_random_cases(500, [&](test::Random& random) {
      const PoseBT X = serial.forward(random_joints(arm, random));
      const auto answer = serial.inverse(X, random_joints(arm, random));
      ASSERT_TRUE(answer) << describe(answer.error());
      const JointVector& q = (*answer)[0].q;
      ASSERT_LE(norm(serial.forward(q).p - X.p), kExact);
      ASSERT_LE(angle_between(serial.forward(q).R, X.R), kExact);
      ASSERT_TRUE(limit_violations(arm.joints, q).empty());
    });
  }
}

TEST(SlidesInAnyChain, count_in_how_far_a_chain_reaches) {
  const Arm arm = gantry();
  const SerialArm serial(arm.geometry, arm.joints, arm.geometry.X_FT);
  const auto answer = serial.inverse({Rotation{}, {3, 0, 0}});
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, ErrorCode::kOutOfReach);
  EXPECT_NEAR(answer.error().limit, 1.8, kExact);
}

}  // namespace
}  // namespace sinew::kinematics
