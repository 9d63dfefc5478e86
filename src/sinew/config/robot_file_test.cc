#include "sinew/config/robot_file.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/config/builtin_robots.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"

namespace sinew {
namespace {

using Lines = std::vector<std::string>;

/// One joint, one row: the smallest robot there is. The numbers on the right are line numbers.
constexpr std::string_view kOneJoint =
    R"(id = "one"
title = "One joint"
[geometry]
kind = "serial"
[[geometry.dh]]
theta_offset_deg = 0
d_mm = 95
a_mm = 0
alpha_deg = -90
source = "s"
[tool]
xyz_mm = [0, 0, 10]
rpy_deg = [0, 0, 0]
source = "s"
[[joint]]
name = "elbow"
lower_deg = -30
upper_deg = 60
velocity_deg_s_max = 10
acceleration_deg_s2_max = 20
jerk_deg_s3_max = 30
home_deg = 0
source = "s"
[device]
protocol = "ideal"
)";

/// `text` with its only occurrence of `from` turned into `to`.
std::string with(std::string_view text, std::string_view from, std::string_view to) {
  std::string changed(text);
  const std::size_t at = changed.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  EXPECT_EQ(changed.find(from, at + 1), std::string::npos) << from << " stands there twice";
  if (at != std::string::npos) changed.replace(at, from.size(), to);
  return changed;
}

Lines complaints(const std::string& text) {
  const auto model = read_robot(text, "r.toml");
  Lines lines;
  if (!model) {
    for (const Complaint& complaint : model.error()) lines.push_back(to_text(complaint));
  }
  return lines;
}

Lines complaints_with(std::string_view from, std::string_view to) {
  return complaints(with(kOneJoint, from, to));
}

std::string builtin(std::string_view id) {
  const auto found = std::ranges::find(builtin_robots(), id, &BuiltinRobot::id);
  return std::string(found->text);
}

TEST(RobotFile, smallest_robot_arrives_in_si) {
  const auto model = read_robot(kOneJoint, "r.toml");
  ASSERT_TRUE(model.has_value()) << to_text(model.error().front());
  EXPECT_EQ(model->id, "one");
  EXPECT_EQ(model->title, "One joint");
  const auto& geometry = std::get<SerialGeometry>(model->geometry);
  ASSERT_EQ(geometry.rows.size(), 1U);
  EXPECT_DOUBLE_EQ(geometry.rows[0].d, 0.095);
  EXPECT_DOUBLE_EQ(geometry.rows[0].alpha, -kPi / 2);
  EXPECT_DOUBLE_EQ(geometry.X_FT.p.z, 0.010);
  ASSERT_EQ(model->joints.size(), 1U);
  const Joint& joint = model->joints[0];
  EXPECT_EQ(joint.name, "elbow");
  EXPECT_EQ(joint.kind, JointKind::kRevolute);
  EXPECT_DOUBLE_EQ(joint.lower, from_deg(-30));
  EXPECT_DOUBLE_EQ(joint.upper, from_deg(60));
  EXPECT_DOUBLE_EQ(joint.velocity_max, from_deg(10));
  EXPECT_DOUBLE_EQ(joint.acceleration_max, from_deg(20));
  EXPECT_DOUBLE_EQ(joint.jerk_max, from_deg(30));
  EXPECT_EQ(model->device.protocol, "ideal");
  EXPECT_EQ(model->device.baud, 1'000'000U);
  EXPECT_EQ(model->device.capability.motion, MotionKind::kStream);
}

TEST(RobotFile, table_and_limits_are_enough) {
  constexpr std::string_view kLeast = R"(id = "least"
title = "Two joints"
source = "measured"
joint = [
  { name = "a", lower_deg = -30, upper_deg = 60, velocity_deg_s_max = 10 },
  { name = "b", lower_deg = 20, upper_deg = 60, velocity_deg_s_max = 20, home_deg = 30 },
]
[geometry]
kind = "serial"
dh = [
  { theta_offset_deg = 0, d_mm = 0, a_mm = 100, alpha_deg = 0 },
  { theta_offset_deg = 0, d_mm = 0, a_mm = 100, alpha_deg = 0, source = "assumed" },
]
)";
  const auto file = read_robot_file(kLeast, "r.toml");
  ASSERT_TRUE(file) << to_text(file.error().front());
  const RobotModel& model = file->model;
  EXPECT_EQ(model.device.protocol, "ideal");
  EXPECT_TRUE(model.device.settings.is<IdealDevice>());
  EXPECT_EQ(model.device.capability.motion, MotionKind::kStream);
  EXPECT_EQ(model.device.capability.feedback, PositionFeedback::kMeasured);
  EXPECT_NEAR(model.joints[0].acceleration_max, from_deg(40), 1e-12);
  EXPECT_NEAR(model.joints[0].jerk_max, from_deg(400), 1e-12);
  EXPECT_EQ(model.joints[0].home, 0);
  EXPECT_NEAR(model.joints[1].home, from_deg(30), 1e-12);
  const auto source_of = [&](std::string_view key) {
    const auto found = std::ranges::find(file->sources, key, &Provenance::key);
    return found == file->sources.end() ? std::string() : found->source;
  };
  EXPECT_EQ(source_of("joint.a.lower_deg"), "measured");
  EXPECT_EQ(source_of("geometry.dh[2].a_mm"), "assumed");
  EXPECT_EQ(source_of("joint.a.acceleration_max"), "assumed: full speed in 0.25 s");
  EXPECT_EQ(source_of("joint.b.jerk_max"), "assumed: full acceleration in 0.1 s");
  // A home that is not given is the limit that is nearest to 0.
  const auto without = read_robot(with(kLeast, ", home_deg = 30", ""), "r.toml");
  ASSERT_TRUE(without);
  EXPECT_NEAR(without->joints[1].home, from_deg(20), 1e-12);
  EXPECT_EQ(complaints(with(kLeast, "source = \"measured\"\n", "")).front(),
            "r.toml:4:3: joint.a.source: missing: write where these numbers come from, or "
            "\"assumed\"");
  EXPECT_EQ(complaints(std::string(kLeast) + "[device]\nprotocol = \"none\"\n").size(), 1U);
  const auto slow =
      read_robot(std::string(kLeast) + "[device]\nprotocol = \"ideal\"\nbaud = 57600\n", "r.toml");
  ASSERT_TRUE(slow);
  EXPECT_NEAR(to_seconds(slow->device.capability.segment), 0.061, 0.001);
  EXPECT_EQ(
      complaints(std::string(kLeast) + "[device]\nprotocol = \"ideal\"\nbaud = 9600\n").size(), 1U);
  EXPECT_EQ(complaints(with(kLeast, "source = \"measured\"", "source = {}")).front(),
            "r.toml:3:10: source: must be a string here: it counts for every table that has none");
}

TEST(RobotFile, every_fault_is_told_at_its_place_with_its_remedy) {
  const struct {
    const char* from;
    const char* to;
    const char* complaint;
  } kCases[] = {
      {"upper_deg = 60", "  uper_deg = 60",
       "r.toml:18:3: joint.elbow.uper_deg: unknown key; did you mean `upper_deg`?"},
      {"d_mm = 95", "d = 95",
       "r.toml:7:1: geometry.dh[1].d: missing unit: write `d_mm`, `d_m` or `d_in`"},
      {"d_mm = 95", "d_cm = 9.5",
       "r.toml:7:1: geometry.dh[1].d_cm: unknown key; did you mean `d_mm`?"},
      {"d_mm = 95\n", "", "r.toml:5:1: geometry.dh[1].d: missing: write `d_mm`, `d_m` or `d_in`"},
      {"d_mm = 95", "d_mm = 95\nd_m = 0.095",
       "r.toml:8:1: geometry.dh[1].d_m: the same quantity stands in `d_mm` already; keep one"},
      {"d_mm = 95", "d_mm = \"95\"",
       "r.toml:7:8: geometry.dh[1].d_mm: must be a number, not a string"},
      {"d_mm = 95", "d_mm = nan",
       "r.toml:7:8: geometry.dh[1].d_mm: must be -10000 to 10000 mm, not nan"},
      {"d_mm = 95", "d_mm = +inf",
       "r.toml:7:8: geometry.dh[1].d_mm: must be -10000 to 10000 mm, not inf"},
      {"d_mm = 95", "d_m = 95", "r.toml:7:7: geometry.dh[1].d_m: must be -10 to 10 m, not 95"},
      {"lower_deg = -30", "lower_deg = 70",
       "r.toml:18:13: joint.elbow.upper_deg: limits reversed or equal: must be above the lower "
       "limit, 70 deg"},
      {"lower_deg = -30", "lower_deg = 60",
       "r.toml:18:13: joint.elbow.upper_deg: limits reversed or equal: must be above the lower "
       "limit, 60 deg"},
      {"velocity_deg_s_max = 10", "velocity_deg_s_max = 0",
       "r.toml:19:22: joint.elbow.velocity_deg_s_max: must be above 0 and at most 3600 deg/s, not "
       "0"},
      {"velocity_deg_s_max = 10", "velocity_max = 10",
       "r.toml:19:1: joint.elbow.velocity_max: missing unit: write `velocity_deg_s_max` or "
       "`velocity_rad_s_max`"},
      {"home_deg = 0", "home_deg = 61",
       "r.toml:22:12: joint.elbow.home_deg: must be inside the joint's limits, -30 deg to 60 deg"},
      {"\"elbow\"", "\"J3\"",
       "r.toml:16:8: joint[1].name: must be lower-case letters, digits and _, begin with a letter, "
       "and not look like j1, which every robot has"},
      {"\"elbow\"", "\"j3\"",
       "r.toml:16:8: joint[1].name: must be lower-case letters, digits and _, begin with a letter, "
       "and not look like j1, which every robot has"},
      {"\"one\"", "\"One\"",
       "r.toml:1:6: id: must be lower-case letters, digits and - between them"},
      {"\"serial\"", "\"seriel\"",
       "r.toml:4:8: geometry.kind: must be `serial`, `palletizer` or `hexapod`, not `seriel`; did "
       "you mean `serial`?"},
      {"\"ideal\"", "\"ideel\"",
       "r.toml:25:12: device.protocol: must be `ideal`, `bigrobotarm`, `lsc`, `maxarm`, `icp`, "
       "`axis_registers`, `axis_link`, `arm_link`, `grbl` or `feetech`, not `ideel`; did you mean "
       "`ideal`?"},
      {"\"ideal\"",
       "\"bigrobotarm\"\nmotion = \"point_to_point\"\nfeedback = \"none\"\nbaud = 250000\n"
       "source = \"s\"",
       "r.toml:25:12: device.protocol: this wire drives 5 joints, the robot has 1"},
      {"[tool]\n", "[tol]\n", "r.toml:11:2: tol: unknown key; did you mean `tool`?"},
      {"[0, 0, 10]", "[0, 0]", "r.toml:12:10: tool.xyz_mm: must have three numbers, not 2"},
      {"source = \"s\"\n[tool]", "[tool]",
       "r.toml:5:1: geometry.dh[1].source: missing: write where these numbers come from, or "
       "\"assumed\""},
      {"[geometry]\nkind = \"serial\"", "[geometry]\nkind = \"serial\"\npitch_preferred_deg = 180",
       "r.toml:5:1: geometry.pitch_preferred_deg: unknown key; known here are `source`, `kind` or "
       "`dh`"},
  };
  for (const auto& c : kCases) {
    const Lines lines = complaints_with(c.from, c.to);
    EXPECT_EQ(lines, Lines{c.complaint}) << c.from << " -> " << c.to;
  }
}

TEST(RobotFile, no_joint_is_faster_than_its_board_makes_steps) {
  std::string text = builtin("robot-arm-2");
  const std::string_view slow = "velocity_deg_s_max = 29.5";
  text.replace(text.find(slow), slow.size(), "velocity_deg_s_max = 30");
  const Lines lines = complaints(text);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_TRUE(
      lines[0].contains("joint: at its highest speed `base` takes 4533 microsteps a "
                        "second, and its board makes 4500: lower its speed"))
      << lines[0];
}

TEST(RobotFile, what_the_ideal_device_can_do_is_not_asked_for) {
  EXPECT_EQ(complaints_with("\"ideal\"", "\"ideal\"\nmotion = \"stream\""),
            Lines{"r.toml:26:1: device.motion: unknown key; known here are `source`, `protocol` or "
                  "`baud`"});
}

TEST(RobotFile, all_complaints_come_at_once_in_the_order_of_the_file) {
  std::string text = with(kOneJoint, "d_mm = 95", "d = 95");
  text = with(text, "upper_deg = 60", "upper_deg = true");
  text = with(text, "\"One joint\"", "\"\"");
  text = with(text, "\"ideal\"", "\"ideal\"\nbaud = true");
  EXPECT_EQ(complaints(text),
            (Lines{"r.toml:2:9: title: must be 1 to 120 bytes of text, not blank, without control "
                   "characters",
                   "r.toml:7:1: geometry.dh[1].d: missing unit: write `d_mm`, `d_m` or `d_in`",
                   "r.toml:18:13: joint.elbow.upper_deg: must be a number, not true or false",
                   "r.toml:26:8: device.baud: must be a whole number, not true or false"}));
}

TEST(RobotFile, syntax_error_is_told_with_its_place_and_alone) {
  const auto model = read_robot(with(kOneJoint, "[tool]", "[tool"), "r.toml");
  ASSERT_FALSE(model.has_value());
  ASSERT_EQ(model.error().size(), 1U);
  EXPECT_EQ(model.error()[0].file, "r.toml");
  EXPECT_EQ(model.error()[0].line, 11);
  const Lines twice = complaints_with("d_mm = 95", "d_mm = 95\nd_mm = 95");
  ASSERT_EQ(twice.size(), 1U);
  EXPECT_TRUE(twice[0].starts_with("r.toml:8:")) << twice[0];
}

TEST(RobotFile, two_joints_of_one_name_are_told_apart) {
  const std::string text = builtin("maxarm");
  EXPECT_EQ(complaints(with(text, "name = \"forearm\"", "name = \"base\"")),
            Lines{"r.toml:45:8: joint[3].name: joint 1 is called `base` already"});
}

TEST(RobotFile, joints_are_as_many_as_the_geometry_moves) {
  const std::string one(kOneJoint);
  const std::string joint =
      one.substr(one.find("[[joint]]"), one.find("[device]") - one.find("[[joint]]"));
  EXPECT_EQ(
      complaints(with(kOneJoint, "[device]", with(joint, "\"elbow\"", "\"other\"") + "[device]")),
      Lines{"r.toml:24:1: joint.other: the file has 2 of the 1 joints that the geometry moves"});
  EXPECT_EQ(complaints(with(kOneJoint, joint, "")),
            Lines{"r.toml:1:1: joint: missing: write `joint`"});

  std::string hexapod = builtin("hexapod");
  const std::size_t leg = hexapod.find("[[joint]]\nname = \"leg6\"");
  hexapod.erase(leg, hexapod.find("[device]") - leg);
  const Lines lines = complaints(hexapod);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_TRUE(
      lines[0].ends_with("joint.leg5: the file has 5 of the 6 joints that the geometry moves"))
      << lines[0];
}

TEST(RobotFile, rows_and_joints_beyond_the_bound_are_refused_without_harm) {
  const std::string one(kOneJoint);
  const std::string row =
      one.substr(one.find("[[geometry.dh]]"), one.find("[tool]") - one.find("[[geometry.dh]]"));
  std::string rows;
  for (int i = 0; i < 20; ++i) rows += row;
  EXPECT_EQ(complaints(with(kOneJoint, row, rows)),
            (Lines{"r.toml:53:1: geometry.dh[9]: one row too many: a chain has at most 8",
                   "r.toml:129:1: joint.elbow: the file has 1 of the 8 joints that the geometry "
                   "moves"}));
}

TEST(RobotFile, hexapod_home_outside_the_legs_is_refused_with_the_length) {
  const std::string text = with(builtin("hexapod"), "xyz_mm = [0, 0, 250]", "xyz_mm = [0, 0, 400]");
  const Lines lines = complaints(text);
  ASSERT_EQ(lines.size(), 6U);
  EXPECT_NE(lines[0].find("the home pose needs 411.726 mm of `leg1`, limits 195 mm to 345 mm"),
            std::string::npos)
      << lines[0];
}

TEST(RobotFile, bigrobotarm_settings_are_checked_per_joint) {
  const std::string text = builtin("bigrobotarm");
  const auto complaint = [&](std::string_view from, std::string_view to) {
    const Lines lines = complaints(with(text, from, to));
    if (lines.size() != 1) return "not one complaint but " + std::to_string(lines.size());
    return lines[0].substr(lines[0].find(": ") + 2);
  };
  EXPECT_EQ(complaint("[device.joint.elbow]", "[device.joint.elbo]"),
            "device.joint.elbo: unknown key; did you mean `elbow`?");
  EXPECT_EQ(complaint("steps_per_turn = 26000", "steps_per = 26000"),
            "device.joint.base.steps_per: missing unit: write `steps_per_turn`, `steps_per_deg` or "
            "`steps_per_rad`");
  EXPECT_EQ(complaint("steps_per_turn = 26000", "steps_per_turn = 0"),
            "device.joint.base.steps_per_turn: must be at least one per radian, either sign");
  EXPECT_EQ(complaint("multiplier_boot = 200", "multiplier_boot = 301"),
            "device.joint.base.multiplier_boot: must be 1 to 300, not 301");
  EXPECT_EQ(complaint("gripper_max = 180", "gripper_max = 256"),
            "device.gripper_max: must be 0 to 255, not 256");
  EXPECT_EQ(complaint("wire = \"byte\"", "wire = \"bytes\""),
            "device.wire: must be `byte`, `text`, `text2026` or `probe`, not `bytes`; did you mean "
            "`byte`?");
}

TEST(RobotFile, settings_of_every_wire_are_checked) {
  const auto complaint = [&](std::string_view robot, std::string_view from, std::string_view to) {
    const Lines lines = complaints(with(builtin(robot), from, to));
    if (lines.size() != 1) return "not one complaint but " + std::to_string(lines.size());
    return lines[0].substr(lines[0].find(": ") + 2);
  };
  EXPECT_EQ(complaint("learm", "servo_id = 5", "servo_id = 6"),
            "device.joint: servo 6 is named twice");
  EXPECT_EQ(complaint("learm", "servo_id = 1\n", "servo_id = 2\n"),
            "device.joint: servo 2 is named twice");
  EXPECT_EQ(complaint("learm", "closed = 2500", "closed = 1500"),
            "device.gripper.closed: must differ from open");
  EXPECT_EQ(complaint("learm", "profile = \"lsc6\"", "profile = \"lsc7\""),
            "device.profile: must be `lsc6`, `bus` or `esp32`, not `lsc7`; did you mean `lsc6`?");
  EXPECT_EQ(complaint("maxarm", "pulses_per_turn = -1500", "pulses_per_turn = 1"),
            "device.joint.shoulder.pulses_per_turn: must be at least one per radian, either sign");
  EXPECT_EQ(complaint("hexapod", "travel_per_turn_mm = 0.7", "travel_per_turn_mm = 0"),
            "device.travel_per_turn_mm: must be above 0 and at most 100 mm, not 0");
  EXPECT_EQ(complaint("hexapod", "i2c_address = 97", "i2c_address = 128"),
            "device.joint.leg1.i2c_address: must be 96 to 127, not 128");
  EXPECT_EQ(complaint("robot-arm-2", "select_gpio = 6", "select_gpio = 5"),
            "device.joint: boards 1 and 2 share select_gpio 5");
  EXPECT_EQ(complaint("robot-arm-2", "select_gpio = 6", "select_gpio = 6\nhoming_place = 1"),
            "device.joint: homing_place of the joints has to be each of 1 to 6 once, or to stand "
            "nowhere");
  EXPECT_EQ(complaint("robot-arm-2", "select_gpio = 6", "select_gpio = 6\nhoming_end = \"left\""),
            "device.joint.shoulder.homing_end: must be `lower` or `upper`, not `left`");
  EXPECT_EQ(complaint("robot-arm-2", "select_gpio = 6", "select_gpio = 6\nencoder_by = \"can\""),
            "device.joint.shoulder.encoder_by: must be `i2c` or `rs485`, not `can`");
  EXPECT_EQ(complaint("robot-arm-2", "select_gpio = 6", "select_gpio = 6\nencoder_by = \"rs485\""),
            "joint: `encoder_by` of `shoulder` is how its AS5600 is read, and "
            "[drive.shoulder] does not say joint_encoder = \"as5600\"");
  EXPECT_EQ(
      complaint("robot-arm-2", "\"deg_u32\"  #", "\"deg\"  #"),
      "device.angle_encoding: must be `deg_u32`, `mdeg_i32`, `f32_be` or `f32_le`, not `deg`");
  EXPECT_EQ(
      complaint("robot-arm-2", "0.77318\nbacklash_deg = 0.2\njoint_encoder = \"quadrature_600",
                "0.77318\nbacklash_deg = 0.2\njoint_encoder = \"as5601"),
      "drive.shoulder.joint_encoder: must be `none`, `quadrature_600` or `as5600`, not "
      "`as5601`; did you mean `as5600`?");
  EXPECT_EQ(complaint("robot-arm-2", "position_gain_per_s = 5.5", "position_gain = 5.5"),
            "control.shoulder.position_gain: missing unit: write `position_gain_per_s`");
  EXPECT_EQ(complaint("robot-arm-2", "position_gain_per_s = 5.5", "position_gain_per_s = 0"),
            "control.shoulder.position_gain_per_s: must be above 0 and at most 100 1/s, not 0");
  EXPECT_EQ(complaint("robot-arm-2", "zero_deg = -90", "zero = -90"),
            "device.joint.shoulder.zero: missing unit: write `zero_deg` or `zero_rad`");
}

TEST(RobotFile, motors_and_masses_of_every_kind_of_robot_are_read) {
  const auto learm = read_robot(builtin("learm"), "r");
  ASSERT_TRUE(learm.has_value());
  EXPECT_EQ(learm->dynamics.servos.size(), 5U);
  EXPECT_TRUE(learm->dynamics.drives.empty());
  EXPECT_NEAR(learm->dynamics.servos[1].no_load_speed, 6.2, 1e-12);
  EXPECT_NEAR(learm->dynamics.links[1].p_JC.x, -0.0525, 1e-12);
  const auto hexapod = read_robot(builtin("hexapod"), "r");
  ASSERT_TRUE(hexapod.has_value());
  ASSERT_EQ(hexapod->dynamics.links.size(), 1U);
  EXPECT_NEAR(hexapod->dynamics.links[0].mass, 1.2, 1e-12);
  EXPECT_NEAR(hexapod->dynamics.drives[5].gear_ratio, 2 * kPi / 0.7e-3, 1e-9);
  EXPECT_NEAR(hexapod->dynamics.drives[5].coulomb_friction, 45, 1e-12);
}

TEST(RobotFile, motors_and_masses_get_their_complaints) {
  const auto complained = [](std::string_view id, std::string_view from, std::string_view to) {
    const Lines lines = complaints(with(builtin(id), from, to));
    return lines.empty() ? std::string() : lines.front();
  };
  const std::string drive = "[drive.leg1]\nholding_torque_nm = 0.22\nmotors = 1\nlead_mm = 0";
  EXPECT_NE(complained("hexapod", drive + ".7", drive)
                .find("drive.leg1.lead_mm: must be above 0 and at most 1000 mm, not 0"),
            std::string::npos);
  const std::string servo = "[servo.base]\nstall_torque_nm = ";
  EXPECT_NE(complained("learm", servo + "1.7", servo + "-1")
                .find("servo.base.stall_torque_nm: must be above 0 and at most 1000 Nm, not -1"),
            std::string::npos);
  EXPECT_NE(complained("hexapod", "[link.platform]", "[link.leg1]").find("link"),
            std::string::npos);
}

TEST(RobotFile, robot_with_drives_and_servos_is_refused) {
  const std::string servos = [] {
    std::string text;
    for (const char* joint : {"base", "shoulder", "elbow", "wrist_rotate", "wrist"}) {
      text += std::string("[servo.") + joint +
              "]\nstall_torque_nm = 1\nno_load_speed_rad_s = 6\nfriction_nm = 0\nsource = \"x\"\n";
    }
    return text;
  }();
  const auto model =
      read_robot(with(builtin("bigrobotarm"), "[device]\n", servos + "[device]\n"), "r");
  ASSERT_FALSE(model.has_value());
  EXPECT_NE(to_text(model.error().front()).find("[drive] or [servo], not both"), std::string::npos);
}

TEST(RobotFile, registers_of_other_boards_may_stand_elsewhere_and_never_twice) {
  const std::string map =
      "[device.register]\nhoming = 0\nmove_angle = 1\ndiag_control = 3\ndiag_status = 4\n"
      "emergency_stop = 5\nsource = \"second firmware\"\n\n  [device.joint.base]";
  const auto model = read_robot(with(builtin("robot-arm-2"), "  [device.joint.base]", map), "r");
  ASSERT_TRUE(model.has_value()) << to_text(model.error().front());
  EXPECT_EQ(model->device.settings.get<AxisRegistersDevice>().registers,
            (AxisRegisterMap{0, 1, 3, 4, 5}));
  const Lines lines = complaints(with(builtin("robot-arm-2"), "  [device.joint.base]",
                                      with(map, "diag_status = 4", "diag_status = 3")));
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_TRUE(lines[0].ends_with("device.register: two registers have the same number"));
}

TEST(RobotFile, limits_may_stand_in_other_units_and_home_on_a_limit) {
  std::string text = with(kOneJoint, "upper_deg = 60", "upper_rad = 1.0471975511965976");
  text = with(text, "home_deg = 0", "home_deg = 60");
  const auto model = read_robot(text, "r.toml");
  ASSERT_TRUE(model.has_value()) << to_text(model.error().front());
  EXPECT_LE(model->joints[0].home, model->joints[0].upper);
  EXPECT_NEAR(model->joints[0].upper, from_deg(60), 1e-15);
}

TEST(RobotFile, bytes_that_are_no_text_are_refused) {
  EXPECT_EQ(complaints(""), (Lines{"r.toml:1:1: geometry: missing: write `geometry`",
                                   "r.toml:1:1: id: missing: write `id`",
                                   "r.toml:1:1: title: missing: write `title`"}));
  EXPECT_FALSE(read_robot(std::string(100, '\0'), "r").has_value());
  EXPECT_FALSE(read_robot("\xff\xfe", "r").has_value());
}

}  // namespace
}  // namespace sinew
