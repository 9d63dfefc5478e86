#include <gtest/gtest.h>

#include "cli/process.h"
#include "cli/rendered_arm.h"
#include "sinew/calibration/robot_tip.h"
#include "sinew/config/camera_file.h"
#include "sinew/kinematics/serial_arm.h"

namespace sinew::test {
namespace {

using PoseSheet = Pose<frame::Base, frame::Table>;

const PoseSheet kX_BS{rotation_z(-kPi / 2) * rotation_y(0.01), {0.23, 0.004, 0.003}};

/// Joints with which the closed jaws of a LeArm touch a point.
JointVector touch_joints(const Vec3& p_B) {
  const RobotModel& model = robot("learm");
  const auto& geometry = std::get<SerialGeometry>(model.geometry);
  const kinematics::SerialArm arm(geometry, model.joints, kinematics::tool_pose(geometry, 0.0));
  const auto found = arm.inverse_nearest_pitch(p_B, geometry.pitch_preferred);
  if (!found) ADD_FAILURE() << "out of reach";
  return found ? found->branches[0].q : JointVector{};
}

TaughtPoint touched(const std::string& name, const Vec3& p_B) {
  TaughtPoint point;
  point.name = name;
  point.robot = "learm";
  point.place = touch_joints(p_B);
  return point;
}

Vec3 mark(const std::string& name) {
  for (const auto& other : marks_of(*vision::table_sheet("a4"))) {
    if (other.name == name) return other.p_B;
  }
  ADD_FAILURE() << name;
  return {};
}

/// Marks of a sheet at kX_BS, touched with 0.5 mm (standard deviation).
TaughtPoints touches(const std::vector<std::string>& names, std::uint64_t seed,
                     double sigma = 0.5e-3) {
  Random random(seed);
  TaughtPoints points;
  for (const std::string& name : names) {
    const Vec3 error{normal(random), normal(random), normal(random)};
    points.push_back(touched(name, kX_BS * mark(name) + sigma * error));
  }
  return points;
}

class CameraTouch : public ::testing::Test {
 protected:
  Arguments touch(const TaughtPoints& points, const Arguments& more = {}) {
    Arguments all{"camera", "touch", "--robot", "learm", "--points"};
    all.push_back(folder_.file("points.toml", points_text(points)));
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// The sentence of a call that must end with exit code 1.
  std::string refusal(const TaughtPoints& points, const Arguments& more = {}) {
    const Ended ended = sinew(touch(points, more));
    EXPECT_EQ(ended.exit, 1) << ended.out << ended.err;
    EXPECT_TRUE(ended.out.empty()) << ended.out;
    return ended.err;
  }
  std::string wrong(const Arguments& more, const TaughtPoints& points = {}) {
    const Ended ended = sinew(touch(points, more));
    EXPECT_EQ(ended.exit, 2) << ended.out << ended.err;
    return ended.err;
  }

  ScratchFolder folder_;
};

void expect_part(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text << "has no: " << part;
}

const std::vector<std::string> kFour{"cross1", "cross2", "cross3", "cross4"};

TEST_F(CameraTouch, sheet_is_found_within_the_error_that_is_said) {
  int inside = 0;
  constexpr int kCases = 20;
  for (std::uint64_t seed = 1; seed <= kCases; ++seed) {
    auto names = kFour;
    if (seed % 2 == 0) names.pop_back();
    const Json json = answer(touch(touches(names, seed), {"--json"}));
    const Json& at = json["sheet_in_base"];
    const auto& q = at["quaternion_wxyz"];
    const PoseSheet found{rotation_from_quaternion({q[0], q[1], q[2], q[3]}),
                          {from_mm(at["x_mm"]), from_mm(at["y_mm"]), from_mm(at["z_mm"])}};
    double worst = 0;
    for (const double x : {-0.105, 0.105}) {
      for (const double y : {-0.1485, 0.1485}) {
        const Vec3 p{x, y, 0};
        worst = std::max(worst, norm(found * p - kX_BS * p));
      }
    }
    const double said = from_mm(json["error_95_mm"].get<double>());
    inside += worst <= said ? 1 : 0;
    EXPECT_LT(worst, names.size() == 4 ? 3e-3 : 5e-3);
    EXPECT_LT(said, names.size() == 4 ? 6e-3 : 12e-3);
    EXPECT_LT(json["rms_mm"].get<double>(), 1.5);
    EXPECT_TRUE(json.contains("next")) << "not all marks are touched";
    EXPECT_LT(json["next"]["error_mm"].get<double>(), json["error_95_mm"].get<double>());
  }
  EXPECT_GE(inside, 17) << "95 % of " << kCases;
}

TEST_F(CameraTouch, lines_for_the_cell_are_in_its_frame) {
  const std::string cell = folder_.file("cell.toml",
                                        "title = \"bench\"\n[[robot]]\nname = \"left\"\n"
                                        "robot = \"learm\"\nx_mm = 1000\nrz_deg = 90\n");
  auto arguments = touch(touches(kFour, 1, 0), {"--cell", cell});
  arguments[3] = "left";
  const Ended ended = sinew(arguments);
  EXPECT_EQ(ended.exit, 0) << ended.err;
  expect_part(ended.out, "for the [[camera]] table of " + cell +
                             ":\nx_mm = 996\ny_mm = 230\n"
                             "z_mm = 3\n");
  expect_part(ended.out, "error at the far corner of the sheet: ");
  expect_part(ended.out, "sinew teach left");
  arguments.push_back("--json");
  const Json json = answer(arguments);
  EXPECT_NEAR(json["camera_table"]["rz_deg"].get<double>(), 0, 0.01);
  EXPECT_NEAR(json["sheet_in_cell"]["x_mm"].get<double>(), 996, 0.01);
  EXPECT_NEAR(json["sheet_in_base"]["x_mm"].get<double>(), 230, 0.01);
  arguments[3] = "right";
  const Ended none = sinew(arguments);
  EXPECT_EQ(none.exit, 2);
  expect_part(none.err, "has no robot 'right', or several; its robots are left");
  arguments[3] = "learm";
  EXPECT_EQ(answer(arguments)["robot"], "left") << "the only one of that kind";
}

TEST_F(CameraTouch, the_place_of_the_sheet_goes_into_the_cameras_file) {
  const std::string cell = folder_.file(
      "cell.toml",
      "title = \"bench\"\n[[robot]]\nname = \"left\"\nrobot = \"learm\"\n"
      "[[camera]]\nname = \"top\"\ndevice = \"table.png\"\ncalibration = \"camera.toml\"\n");
  vision::TableCamera camera;
  camera.name = "top";
  camera.model = vision::pinhole(640, 480, 1);
  camera.X_WC.p = {0, 0, 0.5};
  const std::string file = folder_.file("camera.toml", camera_text(camera));
  auto arguments = touch(touches(kFour, 1), {"--camera", file});
  expect_part(sinew(arguments).err, "--camera: --cell is missing");
  arguments.insert(arguments.end(), {"--cell", cell});
  arguments[3] = "left";
  const Ended ended = sinew(arguments);
  EXPECT_EQ(ended.exit, 0) << ended.err;
  expect_part(ended.out, file + ": [table]");
  const auto kept = read_camera(text_of(file), file);
  ASSERT_TRUE(kept && kept->touched);
  EXPECT_EQ(kept->touched->robot, "left");
  EXPECT_LT(norm(kept->touched->X_BW.p - kX_BS.p), 3e-3);
  EXPECT_EQ(kept->model.width, 640) << "all else is as it was";
  // A cell without that robot does not begin with it.
  std::string other = text_of(cell);
  other.replace(other.find("left"), 4, "right");
  const Ended wrong = sinew(
      {"plan", folder_.file("p.sinew", "look\n"), "--in-cell", folder_.file("other.toml", other)});
  EXPECT_EQ(wrong.exit, 2);
  expect_part(wrong.err,
              "[table] is in the base of 'left', and the cell has no robot of that name");
}

TEST_F(CameraTouch, a_pin_that_stands_out_of_the_tool_counts) {
  constexpr double kPin = 0.02;  // m
  TaughtPoints points;
  const RobotModel& arm = robot("learm");
  for (const std::string& name : kFour) {
    const auto q = calibration::joints_for_tip(arm, {0, kPin}, kX_BS * mark(name), {0, 0, -1});
    ASSERT_TRUE(q) << name;
    EXPECT_LT(norm(calibration::tip_at(arm, *q, {0, kPin}) - kX_BS * mark(name)), 1e-6);
    TaughtPoint point;
    point.name = name;
    point.robot = "learm";
    point.place = *q;
    points.push_back(point);
  }
  const Json json = answer(touch(points, {"--pin-mm", "20", "--json"}));
  EXPECT_LT(json["rms_mm"].get<double>(), 0.05);
  EXPECT_NEAR(json["sheet_in_base"]["x_mm"].get<double>(), 230, 0.1);
  expect_part(wrong({"--pin-mm", "301"}, points), "--pin-mm: is 0 to 300 mm");
}

TEST_F(CameraTouch, marks_by_other_names_of_joints_and_beside_the_sheet) {
  auto points = touches({"cross1", "cross3"}, 1, 0);
  points[0].name = "first";
  points.push_back(touched("corner", kX_BS * Vec3{-0.105, -0.1, 0}));
  points.push_back(touched("elsewhere", {0.2, 0.1, 0.1}));
  const JointVector q = touch_joints(kX_BS * mark("tag581"));
  std::string joints = "tag581=";
  for (std::size_t j = 0; j < q.size(); ++j) {
    joints += (j == 0 ? "" : ",") + std::to_string(to_deg(q[j]));
  }
  const Json json = answer(touch(points, {"--mark", "first=cross1", "--mark", "corner=-105mm,-10cm",
                                          "--touch", joints, "--json"}));
  ASSERT_EQ(json["marks"].size(), 4U);
  EXPECT_EQ(json["marks"][0]["mark"], "cross1");
  EXPECT_EQ(json["marks"][0]["point"], "first");
  EXPECT_EQ(json["marks"][3]["mark"], "tag581");
  EXPECT_LT(json["rms_mm"].get<double>(), 0.05) << "it lies half a degree off level";
  EXPECT_NEAR(json["sheet_in_base"]["x_mm"].get<double>(), 230, 0.01);
}

TEST_F(CameraTouch, too_few_marks_and_marks_on_a_line_are_refused_with_one_to_add) {
  expect_part(refusal(touches({"cross1", "cross3"}, 1)),
              "too few marks: 2 (cross1, cross3), at least 3 needed, not on one line. Touch more "
              "of cross2, cross4, cross5, tag580");
  expect_part(refusal(touches({"cross1", "cross2"}, 1)),
              "sinew teach learm cross3 --points " + folder_.at("points.toml"));
  expect_part(refusal({touched("elsewhere", {0.2, 0.1, 0.1})}), "no touched mark");
  expect_part(refusal(touches({"cross5", "tag580", "tag583"}, 1)),
              "cross5, tag580, tag583 are nearly on one line");
}

TEST_F(CameraTouch, a_position_or_a_mark_that_comes_twice_is_refused) {
  auto points = touches(kFour, 1);
  points[1].place = points[0].place;
  expect_part(refusal(points),
              "the tool was at the same position for cross1 and cross2: 0.0 mm apart");
  points = touches(kFour, 1);
  points.push_back(points[2]);
  points.back().name = "again";
  expect_part(refusal(points, {"--mark", "again=cross3"}),
              "cross3 is given twice, by point cross3 and by point again");
}

TEST_F(CameraTouch, points_of_another_robot_or_without_joints_are_refused) {
  auto points = touches(kFour, 1);
  points[2].robot = "maxarm";
  expect_part(refusal(points), "point cross3 is of maxarm, not of learm");
  points = touches(kFour, 1);
  points[0].place = ToolPlace{{0.2, 0, 0}, {}, {}, {}};
  expect_part(refusal(points), "point cross1 has the tool's position and no joints");
  points = touches(kFour, 1);
  std::get<JointVector>(points[3].place).push_back(0);
  expect_part(refusal(points), "point cross4 has 6 joints, learm has 5");
}

TEST_F(CameraTouch, marks_in_mirrored_order_are_refused) {
  auto points = touches(kFour, 1);
  std::swap(points[0].name, points[1].name);
  std::swap(points[2].name, points[3].name);
  expect_part(refusal(points), "the marks are in mirrored order");
  points = touches({"cross1", "cross2", "cross4"}, 1);
  std::swap(points[0].name, points[2].name);
  const std::string three = refusal(points, {"--limit-mm", "100"});
  expect_part(three, "the marks are in mirrored order");
}

TEST_F(CameraTouch, residuals_that_are_too_large_name_their_reason) {
  auto points = touches({"cross1", "cross2", "cross3", "cross4", "cross5"}, 1);
  const Vec3 off = kX_BS * mark("cross3") + Vec3{0.01, 0.02, 0};
  points[2] = touched("cross3", off);
  const std::string wrong = refusal(points);
  expect_part(wrong, "mm rms (limit 5 mm). cross3 is off by 2");
  expect_part(wrong, "Touch it again: sinew teach learm cross3");
  const Json lenient = answer(touch(points, {"--limit-mm", "20", "--json"}));
  EXPECT_EQ(lenient["wrong"]["mark"], "cross3");
  EXPECT_NEAR(lenient["wrong"]["off_mm"][1].get<double>(), 20, 4);

  points = touches({"cross1", "cross2", "cross3", "cross4", "cross5"}, 1);
  std::swap(points[3].name, points[4].name);
  expect_part(refusal(points), "With cross5 and cross4 exchanged they fit");
  expect_part(refusal(touches(kFour, 1), {"--paper", "a3"}), "shorter than those of a3 paper");
}

TEST_F(CameraTouch, a_print_that_was_scaled_is_warned_of) {
  TaughtPoints points;
  for (const std::string& name : kFour)
    points.push_back(touched(name, kX_BS * (0.97 * mark(name))));
  const Ended ended = sinew(touch(points));
  EXPECT_EQ(ended.exit, 0) << ended.err;
  expect_part(ended.out, "touched distances are 3.0 % shorter than printed ones");
}

TEST_F(CameraTouch, options_that_make_no_sense_are_refused) {
  EXPECT_EQ(sinew({"camera", "touch"}).exit, 2);
  expect_part(wrong({"--mark", "cross1"}), "--mark: 'cross1' is not of the form POINT=MARK");
  expect_part(wrong({"--mark", "nobody=cross1"}), "--mark: there is no point 'nobody'");
  expect_part(wrong({"--touch", "cross9=1,2,3,4,5"}), "--touch: there is no mark 'cross9'");
  expect_part(wrong({"--touch", "cross1=1,2"}), "--touch: 5 numbers are wanted");
  expect_part(wrong({"--limit-mm", "0"}), "--limit-mm: must be above 0");
  expect_part(wrong({"--paper", "a0"}), "--paper: 'a0'");
  expect_part(wrong({"--gripper-mm", "70"}), "--gripper-mm: 70 mm is outside");
  expect_part(wrong({"image.png"}), "camera touch takes no images");
  auto arguments = touch({});
  arguments[3] = "hexapod";
  expect_part(sinew(arguments).err, "hexapod is a platform: it has no tip");
  arguments[3] = "learm";
  arguments[5] = folder_.at("nowhere.toml");
  expect_part(sinew(arguments).err, "nowhere.toml");
}

}  // namespace
}  // namespace sinew::test
