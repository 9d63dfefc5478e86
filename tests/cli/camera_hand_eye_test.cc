#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "cli/process.h"
#include "cli/rendered_arm.h"

namespace sinew::test {
namespace {

/// The camera beside the gripper, looks ahead along the tool; the sheet lies before the base.
ArmScene camera_on_arm(const std::string& target) {
  ArmScene scene;
  scene.board = target == "sheet" ? *vision::table_sheet("a4") : *vision::calibration_board("a4");
  scene.X_FC = {rotation_z(from_deg(92)) * rotation_x(from_deg(-8)), {0.048, 0.006, -0.02}};
  scene.X_BS = {rotation_z(from_deg(-88)) * rotation_x(from_deg(0.5)), {0.235, 0.01, 0.002}};
  return scene;
}

/// The camera on a stand before the arm; a tag on the gripper.
ArmScene tag_on_arm() {
  ArmScene scene;
  scene.board = vision::single_tag(vision::TagFamily::k36h11, 7, 0.04);
  scene.on_arm = false;
  scene.X_BC = relabel<frame::Base, frame::Camera>(
      render::looking_at({0.16, -0.03, 0.55}, {0.18, 0.01, 0.1}));
  scene.X_FS = {rotation_y(-kPi / 2 + 0.5) * rotation_x(0.1) * rotation_z(0.3),
                {-0.03, 0.004, -0.03}};
  return scene;
}

Pose<frame::Base, frame::Camera> pose_of(const Json& json) {
  const auto& q = json["quaternion_wxyz"];
  return {rotation_from_quaternion({q[0], q[1], q[2], q[3]}),
          {from_mm(json["x_mm"]), from_mm(json["y_mm"]), from_mm(json["z_mm"])}};
}

Arguments hand_eye(const ScratchFolder& folder, const std::vector<std::string>& images,
                   const Arguments& more) {
  Arguments all{"camera", "hand-eye"};
  all.insert(all.end(), images.begin(), images.end());
  const Arguments usual{"--robot",  "learm",
                        "--points", folder.at("points.toml"),
                        "--camera", folder.at("camera.toml"),
                        "--out",    folder.at("hand_eye.toml")};
  all.insert(all.end(), usual.begin(), usual.end());
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

/// m, 95 % of the errors with which a camera on the arm that was measured so finds points of the
/// table from new poses of the arm.
double error_on_table(const ArmScene& scene, const Pose<frame::Flange, frame::Camera>& X_FC) {
  const RobotModel& model = robot("learm");
  const kinematics::SerialChain chain(std::get<SerialGeometry>(model.geometry));
  Random random(99);
  std::vector<double> errors;
  for (int poses = 0; poses < 50;) {
    const JointVector q = any_joints(random);
    const PoseBF X_BF = chain.forward({q.data(), q.size()});
    if (!shows(X_BF * scene.X_FC, scene.board, scene.X_BS)) continue;
    ++poses;
    for (const Vec3& p_S : {Vec3{0.08, 0.1, 0}, Vec3{-0.08, 0.1, 0}, Vec3{0, -0.12, 0}, Vec3{}}) {
      const Vec3 p_B = scene.X_BS * p_S;
      const auto pixel = arm_camera().project((X_BF * scene.X_FC).inverse() * p_B);
      if (!pixel || pixel->x < 0 || pixel->y < 0 || pixel->x > 640 || pixel->y > 480) continue;
      const PoseBC X_BC = X_BF * X_FC;
      const Vec3 ray = X_BC.R * arm_camera().direction(*pixel);
      // Where that ray meets the plane of the target.
      const Vec3 n = scene.X_BS.R.z;
      const Vec3 met = X_BC.p + (dot(n, scene.X_BS.p - X_BC.p) / dot(n, ray)) * ray;
      errors.push_back(norm(met - p_B));
    }
  }
  std::ranges::sort(errors);
  return errors[errors.size() * 95 / 100];
}

void expect_no_pose(const Arguments& arguments, int exit, const std::string& part) {
  const Ended ended = sinew(arguments);
  EXPECT_EQ(ended.exit, exit) << ended.err;
  EXPECT_NE(ended.err.find(part), std::string::npos) << ended.err << "has no: " << part;
}

void refuse_what_makes_no_sense(const ScratchFolder& folder,
                                const std::vector<std::string>& images) {
  const std::vector<std::string> three{images.begin(), images.begin() + 3};
  expect_no_pose(hand_eye(folder, {}, {"--mount", "arm"}), 2, "images are missing");
  expect_no_pose(hand_eye(folder, three, {}), 2, "--mount must be arm");
  expect_no_pose(hand_eye(folder, three, {"--mount", "wall"}), 2, "--mount must be arm");
  expect_no_pose({"camera", "hand-eye", images[0]}, 2, "--robot is missing; sinew camera hand-eye");
  for (const auto& [target, part] : std::vector<std::pair<std::string, std::string>>{
           {"cube", "'cube' is neither board nor sheet"},
           {"16h5:1:20mm", "'16h5' is neither 36h11"},
           {"36h11:9999:20mm", "the family has no tag '9999'"},
           {"36h11:1:20s", "--target: "},
           {"36h11:1:1mm", "the side must be 2 mm to 2 m"}}) {
    expect_no_pose(hand_eye(folder, three, {"--mount", "arm", "--target", target}), 2, part);
  }
  expect_no_pose(hand_eye(folder, three, {"--mount", "arm", "--target", "sheet"}), 1,
                 "does not show the sheet");
  expect_no_pose(hand_eye(folder, three, {"--mount", "arm", "--zeros-deg", "40"}), 2,
                 "--zeros-deg");
  expect_no_pose(hand_eye(folder, three, {"--mount", "table", "--touch", "tag3=1,2,3,4,5"}), 2,
                 "marks are touched on a target that is fixed");
  expect_no_pose(hand_eye(folder, {images[0], images[1]}, {"--mount", "arm"}), 1,
                 "Too few views: 2, at least 3 needed");
  const std::string other = folder.file("other.png", text_of(images[0]));
  expect_no_pose(hand_eye(folder, {images[0], other}, {"--mount", "arm"}), 1,
                 "has no point 'other' with its joints. Teach it where the image is taken: sinew "
                 "teach learm other");
  const auto small = vision::encode_png(vision::black_picture(320, 240));
  const std::string view = folder.file("view3.png", std::string(small.begin(), small.end()));
  expect_no_pose(hand_eye(folder, {view}, {"--mount", "arm"}), 1, "is 320 x 240 px");
  auto maxarm = hand_eye(folder, three, {"--mount", "arm"});
  *(std::ranges::find(maxarm, "learm")) = "maxarm";
  expect_no_pose(maxarm, 1, "is of learm, not of maxarm");
}

/// The same image three times: nothing but the camera's place over the target is known.
void one_pose_leaves_directions_open(const ScratchFolder& folder,
                                     const std::vector<std::string>& images) {
  std::filesystem::remove(folder.at("hand_eye.toml"));
  const Ended ended =
      sinew(hand_eye(folder, {images[0], images[0], images[0]}, {"--mount", "arm", "--json"}));
  EXPECT_EQ(ended.exit, 1);
  EXPECT_NE(ended.err.find("is not written: these poses do not determine the camera's"),
            std::string::npos)
      << ended.err;
  const Json json = ended.json();
  EXPECT_EQ(json["not_determined"].size(), 6U) << json.dump();
  EXPECT_EQ(json["next"]["joints_deg"].size(), 5U);
  EXPECT_TRUE(text_of(folder.at("hand_eye.toml")).empty());
}

TEST(CameraHandEye, camera_on_a_learm_finds_the_table_to_3_mm) {
  const ScratchFolder folder;
  const ArmScene scene = camera_on_arm("board");
  const auto images = take_images(folder, scene, 20, 2, any_joints);
  ASSERT_EQ(images.size(), 20U);
  const Json json = answer(hand_eye(folder, images, {"--mount", "arm", "--json"}));
  const auto X_FC = relabel<frame::Flange, frame::Camera>(pose_of(json["camera"]));
  const double error = error_on_table(scene, X_FC);
  RecordProperty("error_um", static_cast<int>(1e6 * error));
  EXPECT_LT(error, 3e-3);
  const auto X_BS = pose_of(json["target_pose"]);
  const double table_off = norm(X_BS.p - scene.X_BS.p);
  EXPECT_LT(table_off, 3e-3);
  EXPECT_LT(to_mm(table_off), json["table_mm"].get<double>());
  EXPECT_LT(json["table_mm"].get<double>(), 5);
  EXPECT_LT(json["held_back_mm"].get<double>(), 6);
  EXPECT_GT(json["held_back_mm"].get<double>(), 0.5) << "servos' steps are part of it";
  EXPECT_TRUE(json["not_determined"].empty());
  EXPECT_EQ(json["views"].size(), 20U);
  EXPECT_FALSE(json.contains("next")) << "enough";
  EXPECT_FALSE(json.contains("camera_table")) << "the board is not the table's sheet";
  const std::string file = text_of(folder.at("hand_eye.toml"));
  EXPECT_EQ(file.substr(0, 26), "format = 1\nmount = \"arm\"\nr");
  EXPECT_NE(file.find("[camera]  # in the flange\nposition_mm = ["), std::string::npos) << file;

  // Of a few of them a view is asked for, which the arm can take.
  const Json few =
      answer(hand_eye(folder, {images.begin(), images.begin() + 8}, {"--mount", "arm", "--json"}));
  ASSERT_TRUE(few["next"].contains("joints_deg")) << few.dump();
  EXPECT_EQ(few["next"]["joints_deg"].size(), 5U);
  refuse_what_makes_no_sense(folder, images);
  one_pose_leaves_directions_open(folder, images);
}

TEST(CameraHandEye, sheet_that_the_arm_sees_gives_the_lines_of_the_cell) {
  const ScratchFolder folder;
  const ArmScene scene = camera_on_arm("sheet");
  const auto images = take_images(folder, scene, 12, 4, any_joints);
  ASSERT_EQ(images.size(), 12U);
  const std::string cell = folder.file("cell.toml",
                                       "title = \"bench\"\n[[robot]]\nname = \"left\"\n"
                                       "robot = \"learm\"\nx_mm = 1000\nrz_deg = 90\n");
  auto arguments = hand_eye(folder, images, {"--mount", "arm", "--target", "sheet"});
  *(std::ranges::find(arguments, "learm")) = "left";
  arguments.insert(arguments.end(), {"--cell", cell, "--json"});
  const Json json = answer(arguments);
  const Json& table = json["camera_table"];
  const Pose<frame::World, frame::Base> X_WB{rotation_z(kPi / 2), {1, 0, 0}};
  const auto X_WS = X_WB * scene.X_BS;
  EXPECT_NEAR(table["x_mm"].get<double>(), to_mm(X_WS.p.x), 4);
  EXPECT_NEAR(table["y_mm"].get<double>(), to_mm(X_WS.p.y), 4);
  EXPECT_NEAR(table["z_mm"].get<double>(), to_mm(X_WS.p.z), 4);
  EXPECT_NEAR(table["rz_deg"].get<double>(), 2, 1);
}

/// Joints of a MaxArm with its nozzle at a point.
JointVector maxarm_at(const Vec3& p_B) {
  const RobotModel& model = robot("maxarm");
  const auto q =
      kinematics::inverse(std::get<PalletizerGeometry>(model.geometry), model.joints, p_B);
  return q ? *q : JointVector{};
}

TEST(CameraHandEye, palletizer_is_asked_to_touch_marks_and_then_knows_the_height) {
  ArmScene scene;
  scene.board = *vision::calibration_board("a4");
  scene.X_FC = {rotation_x(kPi) * rotation_z(0.1), {0.01, -0.05, 0.03}};
  scene.X_BS = {rotation_z(0.1), {0.01, -0.2, 0}};
  const DrawJoints draw = [](Random& random) {
    while (true) {
      const double turn = random.uniform(-0.6, 0.6);
      const double radius = random.uniform(0.13, 0.24);
      const JointVector q =
          maxarm_at({radius * std::sin(turn), -radius * std::cos(turn), random.uniform(0.1, 0.22)});
      if (!q.empty()) return q;
    }
  };
  TaughtPoints touched;
  for (const auto& mark : marks_of(scene.board)) {
    if (mark.name != "tag5" && mark.name != "tag9" && mark.name != "tag26") continue;
    TaughtPoint point;
    point.name = mark.name;
    point.robot = "maxarm";
    const JointVector q = maxarm_at(scene.X_BS * mark.p_B);
    ASSERT_FALSE(q.empty()) << mark.name << " is out of reach";
    point.place = q;
    touched.push_back(point);
  }
  const ScratchFolder without;
  const auto images = take_images(without, scene, 10, 7, draw, "maxarm");
  ASSERT_EQ(images.size(), 10U);
  auto arguments = hand_eye(without, images, {"--mount", "arm"});
  *(std::ranges::find(arguments, "learm")) = "maxarm";
  const Ended open = sinew(arguments);
  EXPECT_EQ(open.exit, 1);
  for (const std::string part :
       {"not determined: the camera's position along the flange's z axis, together with the "
        "board's "
        "position along the base's z axis",
        "To fix: no pose of this robot that shows the target tells it. Touch three marks"}) {
    EXPECT_NE(open.out.find(part), std::string::npos) << open.out;
  }
  auto points = *read_points(text_of(without.at("points.toml")), "points.toml");
  points.insert(points.end(), touched.begin(), touched.end());
  without.file("points.toml", points_text(points));
  arguments.emplace_back("--json");
  const Json json = answer(arguments);
  EXPECT_EQ(json["touched"], 3);
  EXPECT_TRUE(json["not_determined"].empty());
  EXPECT_NEAR(json["target_pose"]["z_mm"].get<double>(), 0, 2);
  EXPECT_NEAR(json["camera"]["z_mm"].get<double>(), 30, 4);
}

TEST(CameraHandEye, tag_on_the_arm_locates_a_fixed_camera) {
  const ScratchFolder folder;
  const ArmScene scene = tag_on_arm();
  const auto images = take_images(folder, scene, 16, 5, any_joints);
  ASSERT_EQ(images.size(), 16U);
  const Json json =
      answer(hand_eye(folder, images, {"--mount", "table", "--target", "36h11:7:40mm", "--json"}));
  const auto X_BC = pose_of(json["camera"]);
  const double off = norm(X_BC * (scene.X_BC.inverse() * Vec3{0.2, 0, 0}) - Vec3{0.2, 0, 0});
  RecordProperty("error_um", static_cast<int>(1e6 * off));
  EXPECT_LT(off, 5e-3);
  EXPECT_LT(to_mm(off), json["table_mm"].get<double>());
  EXPECT_LT(json["held_back_mm"].get<double>(), 6);
  EXPECT_LT(json["target_size"].get<double>(), 0.998) << "white spreads over black edges";
  // camera.toml says that it is 500 mm above its sheet.
  const auto X_BS = X_BC * Pose<frame::Camera, frame::Table>{Rotation{}, {0, 0, -0.5}};
  EXPECT_NEAR(json["camera_table"]["x_mm"].get<double>(), to_mm(X_BS.p.x), 0.1);
  EXPECT_NEAR(json["camera_table"]["z_mm"].get<double>(), to_mm(X_BS.p.z), 0.1);
}

}  // namespace
}  // namespace sinew::test
