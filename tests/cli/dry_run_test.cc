#include <gtest/gtest.h>

#include "cli/process.h"
#include "cli/rendered_table.h"
#include "sinew/config/camera_file.h"
#include "sinew/config/hand_eye_file.h"
#include "sinew/kinematics/serial_chain.h"
#include "sinew/vision/picture_file.h"
#include "support/robots.h"

/// `sinew plan --in-cell`: what a program would do with the cubes of one picture.
namespace sinew::test {
namespace {

/// A stored picture of a red cube, 180 mm in front of a LeArm, and the cell that it was taken in.
class DryRun : public ::testing::Test {
 protected:
  DryRun() {
    const auto png = vision::encode_png(table());
    folder_.file("table.png", std::string(png.begin(), png.end()));
    program_ = folder_.file("sort.sinew", "repeat while seen\n  pick\n  place basket\nend\n");
  }
  void keep_calibration(const Pose<frame::World, frame::Camera>& X_WC) {
    folder_.file("camera.toml", camera_text({"eye", vision::pinhole(320, 240, from_deg(50)), X_WC,
                                             0.2, 1e-3, "", "", std::nullopt}));
  }
  /// @param camera  more lines of the camera
  std::string cell(const std::string& camera, const std::string& robot = "learm") {
    return folder_.file("cell.toml",
                        "title = \"photo\"\n[[robot]]\nname = \"left\"\nrobot = \"" + robot +
                            "\"\n[[camera]]\nname = \"eye\"\ndevice = "
                            "\"table.png\"\ncalibration = \"camera.toml\"\nx_mm = 180\n" +
                            camera +
                            "[basket]\nname = \"tray\"\nlength_mm = 110\nwidth_mm = "
                            "110\nheight_mm = 50\nx_mm = 60\ny_mm = 180\n");
  }
  Arguments plan(const std::string& cell_file, const Arguments& more = {}) {
    Arguments all{"plan", program_, "--in-cell", cell_file, "--json"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  ScratchFolder folder_;
  std::string program_;
};

/// mm, of the top of the cube that is picked.
Vec3 picked_at(const Json& json) {
  EXPECT_EQ(json["picked"].size(), 1U) << json.dump();
  EXPECT_TRUE(json["left"].empty()) << json.dump();
  const Json& one = json["picked"][0];
  EXPECT_EQ(one["color"], "red");
  return {one["top_mm"][0], one["top_mm"][1], one["top_mm"][2]};
}

TEST_F(DryRun, of_a_stored_picture_says_what_becomes_of_its_cube) {
  keep_calibration(kX_WC);
  EXPECT_LT(norm(picked_at(answer(plan(cell("")))) - Vec3{180, 0, 25}), 1);
}

TEST_F(DryRun, of_a_camera_on_the_arm_is_from_where_the_arm_stands) {
  // Its calibration's own pose is of another table.
  keep_calibration({Rotation{}, {9, 9, 9}});
  const RobotModel& arm = robot("learm");
  const JointVector q{0, from_deg(-20), from_deg(80), from_deg(60), 0};
  const kinematics::SerialChain chain(std::get<SerialGeometry>(arm.geometry));
  const Pose<frame::Base, frame::World> X_BT{Rotation{}, {0.18, 0, 0}};
  HandEyeFile file;
  file.robot = "learm";
  file.lens = "eye";
  file.target = "sheet";
  file.X_MC =
      relabel<frame::CameraMount, frame::Camera>(chain.forward(q).inverse() * (X_BT * kX_WC));
  file.held_back = 2e-3;
  folder_.file("hand_eye.toml", hand_eye_text(file));
  const std::string lines = "hand_eye = \"hand_eye.toml\"\nrobot = \"left\"\n";
  const Vec3 there = picked_at(answer(plan(cell(lines), {"--from-joints", "0,-20,80,60,0"})));
  EXPECT_LT(norm(there - Vec3{180, 0, 25}), 1);
  const Vec3 elsewhere = picked_at(answer(plan(cell(lines), {"--from-joints", "0,-20,80,75,0"})));
  EXPECT_GT(norm(elsewhere - there), 20) << "the same picture, taken from elsewhere";
  const Ended other = sinew(plan(cell(lines, "maxarm")));
  EXPECT_EQ(other.exit, 2);
  EXPECT_NE(other.err.find("it was measured on a learm, not on a maxarm"), std::string::npos)
      << other.err;
  folder_.file("hand_eye.toml", "mount = \"arm\"\n");
  const Ended broken = sinew(plan(cell(lines)));
  EXPECT_EQ(broken.exit, 2);
  EXPECT_NE(broken.err.find("hand_eye.toml:"), std::string::npos) << broken.err;
}

}  // namespace
}  // namespace sinew::test
