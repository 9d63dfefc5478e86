#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/program_plan.h"
#include "support/robots.h"

/// Rows that name taught points, and rows that say how far from where the machine is.
namespace sinew::program {
namespace {

using planning::PoseBT;

TaughtPoint of_joints(const char* name, const char* robot, std::initializer_list<double> deg) {
  TaughtPoint point{.name = name, .robot = robot, .place = {}, .source = "", .taught_at = ""};
  JointVector q;
  for (const double value : deg) q.push_back(from_deg(value));
  point.place = q;
  return point;
}
TaughtPoint of_tool(const char* name, const char* robot, const ToolPlace& place) {
  return {.name = name, .robot = robot, .place = place, .source = "", .taught_at = ""};
}

const TaughtPoints& points() {
  static const TaughtPoints all{
      of_joints("ready", "puma560", {0, 20, -70, 0, 60, 0}),
      of_joints("lean", "puma560", {20, 10, -60, 0, 50, 0}),
      of_tool("bin", "puma560", {{0.65, 0.05, 0.35}, {}, {}, {}}),
      of_tool("turned", "puma560",
              {{0.65, 0.05, 0.35}, rotation_from_fixed_xyz({0.1, 0, 0.2}), {}, {}}),
      of_joints("ready_arm", "learm", {0, 20, 40, 40, 0}),
      of_tool("part", "learm", {{0.24, 0.02, 0.2}, {}, from_deg(100), 0.0}),
      of_joints("short", "learm", {1, 2, 3}),
      of_joints("up", "maxarm", {90, 110, 30}),
  };
  return all;
}

std::expected<Program, std::vector<Complaint>> read(std::string_view text, std::string_view robot) {
  Surroundings around;
  around.points = &points();
  return parse(text, "p.sinew", test::robot(robot), around);
}

std::string complaint(std::string_view text, std::string_view robot = "puma560") {
  const auto program = read(text, robot);
  if (program) return "";
  EXPECT_EQ(program.error().size(), 1U);
  return to_text(program.error().front());
}

/// Where a program ends, and the tool there.
struct Ended {
  JointVector q;
  PoseBT X_BT;
};
Ended end_of(std::string_view text, std::string_view robot) {
  const RobotModel& model = test::robot(robot);
  const auto program = read(text, robot);
  if (!program) {
    ADD_FAILURE() << to_text(program.error().front());
    return {};
  }
  const auto plan = make_plan(*program, model, home_joints(model));
  if (!plan) {
    ADD_FAILURE() << text << ": line " << plan.error().line << " " << describe(plan.error().error);
    return {};
  }
  Ended ended;
  for (const Order& order : plan->orders) {
    if (const auto* move = std::get_if<MoveOrder>(&order.what)) ended.q = move->q;
  }
  const planning::ToolSpace space(model);
  ended.X_BT = *space.forward({ended.q.data(), ended.q.size()}, space.home());
  return ended;
}

TEST(NamedPoints, joint_and_move_go_to_the_very_joints_that_were_taught) {
  for (const char* row :
       {"joint to=lean", "move to=lean", "joint to=ready\nmove to=lean speed=50%"}) {
    const Ended ended = end_of(row, "puma560");
    const auto& taught = std::get<JointVector>(points()[1].place);
    for (std::size_t i = 0; i < taught.size(); ++i) EXPECT_EQ(ended.q[i], taught[i]) << row;
  }
}

TEST(NamedPoints, line_ends_where_the_tool_is_at_the_taught_joints) {
  const Ended taught = end_of("joint to=lean", "puma560");
  const Ended line = end_of("joint to=ready\nline to=lean", "puma560");
  EXPECT_NEAR(norm(line.X_BT.p - taught.X_BT.p), 0, 1e-8);
  EXPECT_NEAR(angle_between(line.X_BT.R, taught.X_BT.R), 0, 1e-7);
  const Ended above = end_of("joint to=ready\nline to=lean dz=50mm", "puma560");
  EXPECT_NEAR(norm(above.X_BT.p - taught.X_BT.p - Vec3{0, 0, 0.05}), 0, 1e-8);
}

TEST(NamedPoints, offset_in_the_tools_frame_lies_along_the_tool_at_the_point) {
  const Ended taught = end_of("joint to=lean", "puma560");
  const Ended before = end_of("joint to=ready\nmove to=lean frame=tool dz=-30mm", "puma560");
  EXPECT_NEAR(norm(before.X_BT.p - taught.X_BT.p + 0.03 * taught.X_BT.R.z), 0, 1e-8);
  const Ended pulled = end_of("joint to=lean\nline frame=tool dz=-30mm", "puma560");
  EXPECT_NEAR(norm(pulled.X_BT.p - before.X_BT.p), 0, 1e-8);
  EXPECT_NEAR(angle_between(pulled.X_BT.R, taught.X_BT.R), 0, 1e-7);
}

TEST(NamedPoints, position_keeps_the_orientation_and_a_pose_brings_its_own) {
  const Ended start = end_of("joint to=ready", "puma560");
  const Ended bin = end_of("joint to=ready\nmove to=bin", "puma560");
  EXPECT_NEAR(norm(bin.X_BT.p - Vec3{0.65, 0.05, 0.35}), 0, 1e-8);
  EXPECT_NEAR(angle_between(bin.X_BT.R, start.X_BT.R), 0, 1e-7);
  const Ended turned = end_of("joint to=ready\nmove to=turned", "puma560");
  EXPECT_NEAR(angle_between(turned.X_BT.R, rotation_from_fixed_xyz({0.1, 0, 0.2})), 0, 1e-7);
}

TEST(NamedPoints, arcs_and_splines_go_through_them) {
  const auto program = read("arc via=bin to=turned\nspline bin 600mm,0mm,300mm turned", "puma560");
  ASSERT_TRUE(program) << to_text(program.error().front());
  const auto& arc = std::get<ToolMoveStep>(program->steps[0].what);
  EXPECT_EQ(arc.p_via_BT, (Vec3{0.65, 0.05, 0.35}));
  EXPECT_TRUE(arc.to.R_BT);
  const auto& spline = std::get<SplineStep>(program->steps[1].what);
  ASSERT_EQ(spline.through->size(), 3U);
  EXPECT_EQ((*spline.through)[2], (Vec3{0.65, 0.05, 0.35}));
}

TEST(NamedPoints, five_joints_take_pitch_and_roll_and_a_palletizer_its_position) {
  const Ended part = end_of("joint to=ready_arm\nmove to=part", "learm");
  const planning::ToolSpace space(test::robot("learm"));
  EXPECT_NEAR(space.point(part.X_BT).attitude[0], from_deg(100), 1e-7);
  const Ended up = end_of("joint to=up", "maxarm");
  const Ended above = end_of("move to=up dz=10mm", "maxarm");
  EXPECT_NEAR(norm(above.X_BT.p - up.X_BT.p - Vec3{0, 0, 0.01}), 0, 1e-8);
}

TEST(RelativeRows, differences_count_from_where_the_row_before_ends) {
  const Ended start = end_of("joint to=ready", "puma560");
  const Ended moved =
      end_of("joint to=ready\nline dx=10mm dz=-5mm\nline dx=-20mm\nmove dy=30mm", "puma560");
  EXPECT_NEAR(norm(moved.X_BT.p - start.X_BT.p - Vec3{-0.01, 0.03, -0.005}), 0, 1e-8);
  const Ended blended = end_of(
      "joint to=ready\nline dx=10mm dz=-5mm blend=2mm\nline dx=-20mm blend=2mm\nmove dy=30mm",
      "puma560");
  EXPECT_NEAR(norm(moved.X_BT.p - blended.X_BT.p), 0, 1e-8);
  const Ended joints =
      end_of("joint to=ready\njoint d.J1=5deg d.J3=-10deg\njoint d.J1=5deg", "puma560");
  const auto& ready = std::get<JointVector>(points()[0].place);
  EXPECT_NEAR(joints.q[0], ready[0] + from_deg(10), 1e-12);
  EXPECT_NEAR(joints.q[2], ready[2] - from_deg(10), 1e-12);
  const Ended beside = end_of("joint to=ready d.J1=5deg", "puma560");
  EXPECT_NEAR(beside.q[0], ready[0] + from_deg(5), 1e-12);
}

TEST(RelativeRows, turns_count_about_the_axes_of_their_frame) {
  const Ended start = end_of("joint to=ready", "puma560");
  const Ended base = end_of("joint to=ready\nmove drz=20deg", "puma560");
  EXPECT_NEAR(angle_between(base.X_BT.R, rotation_z(from_deg(20)) * start.X_BT.R), 0, 1e-7);
  const Ended tool = end_of("joint to=ready\nmove frame=tool drz=20deg", "puma560");
  EXPECT_NEAR(angle_between(tool.X_BT.R, start.X_BT.R * rotation_z(from_deg(20))), 0, 1e-7);
  EXPECT_NEAR(norm(tool.X_BT.p - start.X_BT.p), 0, 1e-8);
  const planning::ToolSpace space(test::robot("learm"));
  const Ended arm = end_of("joint to=ready_arm", "learm");
  const Ended pitched = end_of("joint to=ready_arm\nmove dpitch=-5deg", "learm");
  EXPECT_NEAR(space.point(pitched.X_BT).attitude[0] - space.point(arm.X_BT).attitude[0],
              from_deg(-5), 1e-7);
}

TEST(RelativeRows, machine_that_does_not_know_where_it_stands_takes_no_difference) {
  const auto program = read("joint J1=1deg J2=1deg J3=1deg J4=1deg d.J5=1deg", "learm");
  ASSERT_TRUE(program);
  const auto plan = make_plan(*program, test::robot("learm"), std::nullopt);
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().error.code, ErrorCode::kPositionUnknown);
  EXPECT_EQ(plan.error().error.index, 4);
}

TEST(NamedPoints, a_broken_point_refuses_only_the_rows_that_use_it) {
  TaughtPoints all = points();
  all.push_back({.name = "broken", .robot = "", .place = {}, .source = "", .taught_at = ""});
  all.back().wrong = "points.toml:3:1: y_mm is missing";
  Surroundings around;
  around.points = &all;
  const RobotModel& robot = test::robot("puma560");
  EXPECT_TRUE(parse("move to=ready", "p.sinew", robot, around));
  const auto used = parse("move to=ready\nmove to=broken", "p.sinew", robot, around);
  ASSERT_FALSE(used);
  ASSERT_EQ(used.error().size(), 1U);
  EXPECT_EQ(to_text(used.error()[0]),
            "p.sinew:2:6: 'broken' cannot be used: points.toml:3:1: y_mm is missing");
  // A file that is no TOML at all.
  all.assign(1, {.name = "", .robot = "", .place = {}, .source = "", .taught_at = ""});
  all.back().wrong = "points.toml:1:8: no TOML";
  EXPECT_TRUE(parse("move x=500mm", "p.sinew", robot, around));
  EXPECT_FALSE(parse("move to=ready", "p.sinew", robot, around));
}

TEST(NamedPoints, faults_are_told_with_what_would_be_right) {
  const struct {
    const char* text;
    const char* complaint;
  } kCases[] = {
      {"line to=lead", "p.sinew:1:6: 'lead' is no taught point; did you mean lean?"},
      {"line to=nowhere",
       "p.sinew:1:6: 'nowhere' is no taught point; there are ready lean bin turned"},
      {"line to=part", "p.sinew:1:6: 'part' is a point of learm, not of puma560"},
      {"joint to=bin",
       "p.sinew:1:7: 'bin' is a place of the tool; write move to=bin, which finds the joints"},
      {"joint J1=3deg to=lean",
       "p.sinew:1:15: to= names all joints; beside it a joint takes a difference, as in "
       "d.waist=5deg"},
      {"joint to=lean J1=3deg", "p.sinew:1:15: 'J1' is named twice"},
      {"joint d.J1=1deg d.J1=1deg", "p.sinew:1:17: 'd.J1' is named twice"},
      {"joint d.J9=1deg",
       "p.sinew:1:7: 'd.J9' is no joint of this robot; it has d.waist d.shoulder d.elbow "
       "d.forearm_roll d.wrist_bend d.flange_roll"},
      {"line to=bin x=3mm",
       "p.sinew:1:1: to= names the place already; beside it write differences, as in dz=50mm"},
      {"line to=bin to=lean", "p.sinew:1:13: 'to' is named twice"},
      {"line x=3mm dx=3mm", "p.sinew:1:1: x and dx are one number: write their sum"},
      {"line x=3mm frame=tool",
       "p.sinew:1:1: frame= says along whose axes differences count; it needs one, as in dz=20mm"},
      {"line dx=3mm frame=hand", "p.sinew:1:13: 'hand': a frame is base or tool"},
      {"line dx=3mm frame=tool frame=tool", "p.sinew:1:24: 'frame' is named twice"},
      {"line dx=200m", "p.sinew:1:6: 'dx' is farther away than 100 m"},
      {"arc via=nobody to=bin",
       "p.sinew:1:5: 'nobody' is no taught point; there are ready lean bin turned"},
  };
  for (const auto& c : kCases) EXPECT_EQ(complaint(c.text), c.complaint) << c.text;
  EXPECT_EQ(complaint("joint to=short", "learm"),
            "p.sinew:1:7: 'short' has 3 joints, learm has 5 joints");
  EXPECT_TRUE(complaint("move to=up drz=3deg", "maxarm")
                  .starts_with("p.sinew:1:12: 'drz' is nothing that this row takes"));
  const auto alone = parse("line to=bin", "p.sinew", test::robot("puma560"));
  ASSERT_FALSE(alone);
  EXPECT_EQ(to_text(alone.error().front()),
            "p.sinew:1:6: 'bin': there is no points.toml beside the program");
}

}  // namespace
}  // namespace sinew::program
