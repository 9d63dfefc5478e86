#include <gtest/gtest.h>

#include <algorithm>

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

/// m, the largest of the errors with which a camera on the arm that was measured so finds points of
/// the table from new poses of the arm.
double error_on_table(const ArmScene& scene, const Pose<frame::Flange, frame::Camera>& X_FC) {
  const RobotModel& model = robot("learm");
  const kinematics::SerialChain chain(std::get<SerialGeometry>(model.geometry));
  Random random(99);
  double worst = 0;
  for (int poses = 0; poses < 20;) {
    const JointVector q = any_joints(random);
    const PoseBF X_BF = chain.forward({q.data(), q.size()});
    if (!shows(X_BF * scene.X_FC, scene.board, scene.X_BS)) continue;
    ++poses;
    for (const Vec3& p_S : {Vec3{0.08, 0.1, 0}, Vec3{-0.08, 0.1, 0}, Vec3{0, -0.12, 0}}) {
      const Vec3 p_B = scene.X_BS * p_S;
      const auto pixel = arm_camera().project((X_BF * scene.X_FC).inverse() * p_B);
      if (!pixel) continue;
      const PoseBC X_BC = X_BF * X_FC;
      const Vec3 ray = X_BC.R * arm_camera().direction(*pixel);
      // Where that ray meets the plane of the target.
      const Vec3 n = scene.X_BS.R.z;
      const Vec3 met = X_BC.p + (dot(n, scene.X_BS.p - X_BC.p) / dot(n, ray)) * ray;
      worst = std::max(worst, norm(met - p_B));
    }
  }
  return worst;
}

TEST(CameraHandEye, camera_on_a_learm_finds_the_table_to_3_mm) {
  for (const std::uint64_t seed : {1U, 2U}) {
    const ScratchFolder folder;
    const ArmScene scene = camera_on_arm("board");
    const auto images = take_images(folder, scene, 14, seed, any_joints);
    ASSERT_EQ(images.size(), 14U);
    const Json json = answer(hand_eye(folder, images, {"--mount", "arm", "--json"}));
    const auto X_FC = relabel<frame::Flange, frame::Camera>(pose_of(json["camera"]));
    const double error = error_on_table(scene, X_FC);
    RecordProperty("error_mm_" + std::to_string(seed), std::to_string(to_mm(error)));
    std::printf("  seed %d: %.2f mm at the table, %.2f mm said, %.2f px\n", int(seed), to_mm(error),
                json["held_back_mm"].get<double>(), json["reprojection_px"].get<double>());
    EXPECT_LT(error, 3e-3);
    EXPECT_LT(json["held_back_mm"].get<double>(), 4);
    EXPECT_GT(json["held_back_mm"].get<double>(), 0.3) << "servos' steps are part of it";
    EXPECT_TRUE(json["not_determined"].empty());
    EXPECT_EQ(json["views"].size(), 14U);
    EXPECT_FALSE(json.contains("camera_table")) << "the board is not the table's sheet";
    ASSERT_EQ(json["next"]["joints_deg"].size(), 5U);
    const std::string file = text_of(folder.at("hand_eye.toml"));
    EXPECT_EQ(file.substr(0, 26), "format = 1\nmount = \"arm\"\nr");
    EXPECT_NE(file.find("[camera]  # in the flange\nposition_mm = ["), std::string::npos) << file;
  }
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

TEST(CameraHandEye, tag_on_the_arm_locates_a_fixed_camera) {
  const ScratchFolder folder;
  const ArmScene scene = tag_on_arm();
  const auto images = take_images(folder, scene, 16, 5, any_joints);
  ASSERT_EQ(images.size(), 16U);
  const Json json =
      answer(hand_eye(folder, images, {"--mount", "table", "--target", "36h11:7:40mm", "--json"}));
  const auto X_BC = pose_of(json["camera"]);
  const double off = norm(X_BC * (scene.X_BC.inverse() * Vec3{0.2, 0, 0}) - Vec3{0.2, 0, 0});
  std::printf("  %.2f mm at the table, %.2f mm said, %.2f held, size %.4f, %.2f px\n", to_mm(off),
              json["table_mm"].get<double>(), json["held_back_mm"].get<double>(),
              json["target_size"].get<double>(), json["reprojection_px"].get<double>());
  EXPECT_LT(off, 5e-3);
  EXPECT_LT(json["held_back_mm"].get<double>(), 6);
  // camera.toml says that it is 500 mm above its sheet.
  const auto X_BS = X_BC * Pose<frame::Camera, frame::Table>{Rotation{}, {0, 0, -0.5}};
  EXPECT_NEAR(json["camera_table"]["x_mm"].get<double>(), to_mm(X_BS.p.x), 0.1);
  EXPECT_NEAR(json["camera_table"]["z_mm"].get<double>(), to_mm(X_BS.p.z), 0.1);
}

}  // namespace
}  // namespace sinew::test
