// The tables of robots/*.toml against what their documents say the arms do.

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew {
namespace {

using test::Random;
using test::robot;
using BaseTool = Pose<frame::Base, frame::Tool>;
using Step = Pose<frame::Base, frame::Base>;  // one link; the tests only multiply them

constexpr double kTolerance = 1e-12;  // m and rotation matrix elements; rounding of ten products

Step link(const DhRow& row, double q) {
  const Rotation Rz = rotation_z(q + row.theta_offset);
  return {Rz * rotation_x(row.alpha), Rz * Vec3{row.a, 0, row.d}};
}

/// Product of the first `rows` links.
Step chain(const SerialGeometry& geometry, const JointVector& q, std::size_t rows) {
  Step X;
  for (std::size_t i = 0; i < rows; ++i) X = X * link(geometry.rows[i], q[i]);
  return X;
}

/// Tool pose with the jaws `width` m apart; the width means nothing to an arm without a gripper.
BaseTool tool_pose(const SerialGeometry& geometry, const JointVector& q, double width = 0) {
  Step X = chain(geometry, q, geometry.rows.size());
  X = X * Step{geometry.X_FT.R, geometry.X_FT.p};
  if (const auto& gripper = geometry.gripper) {
    const double open = width / gripper->width_max;
    X = X *
        Step{{},
             {0, 0, gripper->reach_closed + open * (gripper->reach_open - gripper->reach_closed)}};
  }
  return {X.R, X.p};
}

const SerialGeometry& serial(std::string_view id) {
  return std::get<SerialGeometry>(robot(id).geometry);
}

JointVector degrees(std::initializer_list<double> angles_deg) {
  JointVector q;
  for (const double angle_deg : angles_deg) q.push_back(from_deg(angle_deg));
  return q;
}

void expect_near(const Vec3& p, const Vec3& wanted, double tolerance) {
  EXPECT_LE(norm(p - wanted), tolerance) << p.x << " " << p.y << " " << p.z << ", wanted "
                                         << wanted.x << " " << wanted.y << " " << wanted.z;
}

void expect_near(const Rotation& R, const Rotation& wanted, double tolerance) {
  expect_near(R.x, wanted.x, tolerance);
  expect_near(R.y, wanted.y, tolerance);
  expect_near(R.z, wanted.z, tolerance);
}

JointVector random_joints(std::string_view id, Random& random) {
  JointVector q;
  for (const Joint& joint : robot(id).joints) q.push_back(random.uniform(joint.lower, joint.upper));
  return q;
}

TEST(Learm, zero_pose_stands_straight_up_with_the_tool_parallel_to_the_base) {
  const BaseTool open = tool_pose(serial("learm"), degrees({0, 0, 0, 0, 0}), 0.060);
  expect_near(open.p, {0, 0, 0.448}, kTolerance);
  expect_near(open.R, Rotation{}, kTolerance);
  expect_near(tool_pose(serial("learm"), degrees({0, 0, 0, 0, 0}), 0).p, {0, 0, 0.478}, kTolerance);
}

TEST(Learm, documented_poses_come_out) {
  const auto pose = [](std::initializer_list<double> q) {
    return tool_pose(serial("learm"), degrees(q), 0.060);
  };
  expect_near(pose({0, 90, 0, 0, 0}).p, {0.353, 0, 0.095}, kTolerance);
  expect_near(pose({0, 90, 0, 0, 0}).R.z, {1, 0, 0}, kTolerance);
  expect_near(pose({0, 0, 90, 90, 0}).p, {0.098, 0, 0.050}, kTolerance);
  expect_near(pose({0, 0, 90, 90, 0}).R.z, {0, 0, -1}, kTolerance);
  expect_near(pose({90, 90, 0, 0, 0}).p, {0, 0.353, 0.095}, kTolerance);
}

/// Rz(q1) Tz(a1) Ry(q2) Tz(a2) Ry(q3) Tz(a3) Ry(q4) Tz(95 + reach) Rz(q5): what the words "lean
/// forward, bend forward, roll" of the document mean, written without a DH table.
TEST(Learm, dh_table_is_the_chain_of_its_words) {
  test::for_random_cases(2000, [](Random& random) {
    const JointVector q = random_joints("learm", random);
    const double width = random.uniform(0, 0.060);
    const Step X = Step{rotation_z(q[0]), {0, 0, 0.095}} *
                   Step{rotation_y(q[1]), rotation_y(q[1]) * Vec3{0, 0, 0.105}} *
                   Step{rotation_y(q[2]), rotation_y(q[2]) * Vec3{0, 0, 0.098}} *
                   Step{rotation_y(q[3]), rotation_y(q[3]) * Vec3{0, 0, 0.180 - width / 2}} *
                   Step{rotation_z(q[4]), {}};
    const BaseTool X_BT = tool_pose(serial("learm"), q, width);
    expect_near(X_BT.p, X.p, kTolerance);
    expect_near(X_BT.R, X.R, kTolerance);
  });
}

/// Rz(b) Ry(s) Tz(L1) Ry(e) Tz(L2) Rz(wr) Ry(w) Tz(L3).
TEST(BigRobotArm, dh_table_is_the_chain_of_its_axes) {
  constexpr double kL1 = 0.22113, kL2 = 0.117952 + 0.105892, kL3 = 0.123035;  // m
  test::for_random_cases(2000, [](Random& random) {
    const JointVector q = random_joints("bigrobotarm", random);
    const Step X_BW = Step{rotation_z(q[0]), {}} *
                      Step{rotation_y(q[1]), rotation_y(q[1]) * Vec3{0, 0, kL1}} *
                      Step{rotation_y(q[2]), rotation_y(q[2]) * Vec3{0, 0, kL2}};
    const Step X = X_BW * Step{rotation_z(q[3]), {}} *
                   Step{rotation_y(q[4]), rotation_y(q[4]) * Vec3{0, 0, kL3}};
    const BaseTool X_BT = tool_pose(serial("bigrobotarm"), q);
    expect_near(X_BT.p, X.p, kTolerance);
    expect_near(X_BT.R, X.R, kTolerance);
    expect_near(chain(serial("bigrobotarm"), q, 4).p, X_BW.p, kTolerance);
  });
}

TEST(BigRobotArm, zero_pose_is_568_mm_tall_and_planar_formulas_hold) {
  const SerialGeometry& arm = serial("bigrobotarm");
  const BaseTool zero = tool_pose(arm, degrees({0, 0, 0, 0, 0}));
  expect_near(zero.p, {0, 0, 0.568009}, kTolerance);
  expect_near(zero.R, Rotation{}, kTolerance);
  test::for_random_cases(500, [&](Random& random) {
    JointVector q = random_joints("bigrobotarm", random);
    q[3] = 0;
    const double s = q[1], se = q[1] + q[2], sew = q[1] + q[2] + q[4];
    const double r = 0.22113 * std::sin(s) + 0.223844 * std::sin(se) + 0.123035 * std::sin(sew);
    const double h = 0.22113 * std::cos(s) + 0.223844 * std::cos(se) + 0.123035 * std::cos(sew);
    expect_near(tool_pose(arm, q).p, {r * std::cos(q[0]), r * std::sin(q[0]), h}, kTolerance);
  });
}

/// The closed-form inverse of docs/kinematics relies on this shape.
TEST(BigRobotArm, wrist_centre_is_the_origin_of_frame_4_and_the_shoulder_has_no_offset) {
  const SerialGeometry& arm = serial("bigrobotarm");
  for (const std::size_t i : {0U, 2U, 3U}) {
    EXPECT_DOUBLE_EQ(std::abs(arm.rows[i].alpha), kPi / 2) << "row " << i + 1;
    EXPECT_EQ(arm.rows[i].a, 0) << "row " << i + 1;
  }
  EXPECT_EQ(arm.rows[1].alpha, 0);
  EXPECT_EQ(arm.rows[1].d, 0);
  EXPECT_EQ(arm.rows[2].d, 0);
  EXPECT_EQ(arm.rows[4].a, 0);
  EXPECT_EQ(arm.rows[4].d, 0) << "the whole tool length stands in the tool's pose";
  EXPECT_EQ(arm.X_FT.p, (Vec3{0, 0, 0.123035}));
}

struct Reference {
  std::initializer_list<double> q_deg;
  Vec3 p_mm;
};

TEST(RobotArm2, reference_positions_of_its_model_come_out) {
  const Reference kCases[] = {
      {{0, 0, 0, 0, 0, 0}, {365, 0, 620}},
      {{30, -45, 60, 20, 40, -10}, {466.022046, 243.672288, 672.963154}},
      {{10, 20, 30, 40, 50, 60}, {32.673004, -44.238868, 874.891108}},
      {{-120, 30, -60, 100, -70, 200}, {14.005756, -160.824634, 436.299587}}};
  for (const Reference& c : kCases) {
    expect_near(tool_pose(serial("robot-arm-2"), degrees(c.q_deg)).p, 1e-3 * c.p_mm, 1e-9);
  }
  const BaseTool zero = tool_pose(serial("robot-arm-2"), degrees({0, 0, 0, 0, 0, 0}));
  expect_near(zero.R, {{0, 0, 1}, {0, -1, 0}, {1, 0, 0}}, kTolerance);
}

TEST(Puma560, textbook_poses_come_out) {
  const BaseTool zero = tool_pose(serial("puma560"), degrees({0, 0, 0, 0, 0, 0}));
  expect_near(zero.p, {0.4521, -0.15005, 0.4318}, kTolerance);
  expect_near(zero.R, Rotation{}, kTolerance);
  // "Nominal": the elbow bent back, the hand level; rounded as the textbook prints it.
  const BaseTool nominal = tool_pose(serial("puma560"), degrees({0, 45, 180, 0, 45, 0}));
  expect_near(nominal.p, {0.5963, -0.1501, -0.01435}, 1e-4);
  expect_near(nominal.R, {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}}, kTolerance);
}

/// The vendor's own forward kinematics at the home angles, and its IK vectors, to the printed
/// digit.
TEST(MaxArm, home_angles_put_the_nozzle_at_the_vendors_home) {
  const RobotModel& model = robot("maxarm");
  const auto& g = std::get<PalletizerGeometry>(model.geometry);
  const double b = g.base_front - model.joints[0].home;
  const double up = kPi - model.joints[1].home;
  const double down = -model.joints[2].home;
  const double r =
      g.shoulder_offset + g.upper_arm * std::cos(up) + g.forearm * std::cos(down) + g.tool_offset;
  const double z = g.base_height + g.upper_arm * std::sin(up) + g.forearm * std::sin(down);
  expect_near(Vec3{r * std::sin(b), -r * std::cos(b), z}, Vec3{0, -0.163, 0.212}, 1e-6);
  EXPECT_DOUBLE_EQ(g.radius_min, 0.050);
}

TEST(Hexapod, anchors_stand_at_their_angles_and_every_leg_is_268_mm_at_home) {
  const RobotModel& model = robot("hexapod");
  const auto& g = std::get<HexapodGeometry>(model.geometry);
  constexpr double kBase[] = {-10, 10, 110, 130, 230, 250};     // deg
  constexpr double kPlatform[] = {-50, 50, 70, 170, 190, 290};  // deg
  constexpr double kSkewer[] = {-60, 60, 60, 180, 180, 300};    // deg, centre of each pair
  for (std::size_t i = 0; i < kLegs; ++i) {
    expect_near(g.p_BA[i], rotation_z(from_deg(kBase[i])) * Vec3{0.150, 0, 0}, 1e-12);
    expect_near(g.p_PA[i], rotation_z(from_deg(kPlatform[i])) * Vec3{0.100, 0, 0}, 1e-12);
    expect_near(g.skewer_axis_P[i], rotation_z(from_deg(kSkewer[i])) * Vec3{1, 0, 0}, 1e-12);
    EXPECT_EQ(g.motor_axis_B[i], (Vec3{0, 0, 1}));
    EXPECT_NEAR(model.joints[i].home, 0.26836, 5e-6);
  }
  EXPECT_DOUBLE_EQ(g.cardan_angle_max, from_deg(45));
  EXPECT_DOUBLE_EQ(g.ball_angle_max, from_deg(35));
  EXPECT_EQ(g.condition_max, 20);
}

}  // namespace
}  // namespace sinew
