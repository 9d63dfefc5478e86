#include "sinew/config/camera_file.h"

#include <gtest/gtest.h>

#include "sinew/core/units.h"
#include "support/property.h"

namespace sinew {
namespace {

vision::TableCamera some_camera(test::Random& random) {
  vision::TableCamera camera;
  camera.name = "over the table";
  camera.model = vision::pinhole(1280, 720, from_deg(random.uniform(30, 90)));
  for (double& value : camera.model.lens) value = random.uniform(-0.3, 0.3);
  camera.X_WC = {
      rotation_from_vector({random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)}),
      {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0, 2)}};
  camera.reprojection = 0.25;
  camera.accuracy = 0.0015;
  camera.sheet = "a4";
  camera.touched = {"left",
                    {rotation_from_vector({random.uniform(-2, 2), 0.1, random.uniform(-2, 2)}),
                     {random.uniform(-1, 1), 0.2, random.uniform(0, 2)}},
                    0.0031};
  camera.identity = "USB \"Cam\" C:\\1";
  return camera;
}

TEST(CameraFile, written_and_read_again_it_is_the_same_camera) {
  test::for_random_cases(100, [](test::Random& random) {
    const vision::TableCamera camera = some_camera(random);
    const auto again = read_camera(camera_text(camera), "camera.toml");
    ASSERT_TRUE(again) << to_text(again.error().front());
    EXPECT_EQ(again->name, camera.name);
    EXPECT_EQ(again->model.width, 1280);
    EXPECT_EQ(again->model.height, 720);
    EXPECT_NEAR(again->model.fy, camera.model.fy, 1e-8);
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_NEAR(again->model.lens[i], camera.model.lens[i], 1e-11);
    }
    EXPECT_LT(norm(again->X_WC.p - camera.X_WC.p), 1e-11);
    EXPECT_LT(angle_between(again->X_WC.R, camera.X_WC.R), 1e-7);
    EXPECT_DOUBLE_EQ(again->reprojection, 0.25);
    EXPECT_DOUBLE_EQ(again->accuracy, 0.0015);
    EXPECT_EQ(again->sheet, "a4");
    EXPECT_EQ(again->identity, camera.identity);
    ASSERT_TRUE(again->touched);
    EXPECT_EQ(again->touched->robot, "left");
    EXPECT_LT(norm(again->touched->X_BW.p - camera.touched->X_BW.p), 1e-11);
    EXPECT_LT(angle_between(again->touched->X_BW.R, camera.touched->X_BW.R), 1e-7);
    EXPECT_DOUBLE_EQ(again->touched->error, 0.0031);
  });
}

TEST(CameraFile, what_is_wrong_is_said_with_its_line) {
  test::Random random(1);
  const std::string good = camera_text(some_camera(random));
  const auto complaint_after = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    const auto camera = read_camera(text, "camera.toml");
    return camera ? std::string() : to_text(camera.error().front());
  };
  EXPECT_EQ(complaint_after("format = 1", "format = 2"),
            "camera.toml:1:10: format: is 2: written by another version; calibrate again: sinew "
            "camera calibrate");
  EXPECT_EQ(complaint_after("width = 1280", "width = 0").substr(0, 26),
            "camera.toml:5:9: width: mu");
  EXPECT_NE(complaint_after("k3 =", "k4 ="), "");
  EXPECT_NE(complaint_after("\"a4\"", "\"b4\"").find("has to be a4, a3 or letter"),
            std::string::npos);
  EXPECT_NE(complaint_after("position_mm", "position_px"), "");
  EXPECT_NE(complaint_after("[pose]", "pose = ["), "");
}

}  // namespace
}  // namespace sinew
