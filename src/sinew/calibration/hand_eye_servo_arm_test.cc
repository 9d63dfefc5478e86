#include <gtest/gtest.h>

#include <cmath>

#include "sinew/calibration/hand_eye.h"
#include "sinew/calibration/scene_test_data.h"
#include "sinew/kinematics/serial_chain.h"

namespace sinew::calibration {
namespace {

using PoseBF = Pose<frame::Base, frame::Flange>;

/// A LeArm's five joints.
kinematics::SerialChain learm() {
  SerialGeometry geometry;
  geometry.rows = {{0.095, 0, -kPi / 2, 0},
                   {0, 0.105, 0, -kPi / 2},
                   {0, 0.098, 0, 0},
                   {0, 0, -kPi / 2, -kPi / 2},
                   {0.095, 0, 0, kPi}};
  return kinematics::SerialChain(geometry);
}

/// Where its servos go: 1000 steps over 240 deg, and 0.1 deg of gears and load.
std::array<double, 5> really_at(const std::array<double, 5>& q, test::Random& random) {
  constexpr double kStep = from_deg(240) / 1000;
  std::array<double, 5> out{};
  for (std::size_t j = 0; j < 5; ++j) {
    out[j] = std::round(q[j] / kStep) * kStep + from_deg(0.1) * normal(random);
  }
  return out;
}

struct ServoScene {
  CameraMounting mounting = CameraMounting::kOnFlange;
  PoseMC X_MC;
  PoseNB X_NB;
  std::vector<Vec3> points_B;
};

std::vector<HandEyeView> servo_views(const ServoScene& scene, std::size_t count,
                                     test::Random& random) {
  const kinematics::SerialChain arm = learm();
  std::vector<HandEyeView> views;
  for (int i = 0; i < 300'000 && views.size() < count; ++i) {
    const std::array<double, 5> q{random.uniform(-1, 1), random.uniform(-1.2, 1.2),
                                  random.uniform(-0.5, 1.57), random.uniform(0, 1.57),
                                  random.uniform(-1.2, 1.2)};
    const PoseBF X_BF = arm.forward(really_at(q, random));
    const PoseCB X_CB = scene.X_MC.inverse() * between_mounts(scene.mounting, X_BF) * scene.X_NB;
    if (X_BF.p.z < 0.06 || dot(normalized(X_CB.p), X_CB.R.z) > -0.6) continue;
    auto seen = seen_points(webcam(), X_CB, scene.points_B, 0.2, random);
    if (2 * seen.pixels.size() < scene.points_B.size() || seen.pixels.size() < 4) continue;
    views.push_back({arm.forward(q), std::move(seen), std::nullopt});
  }
  return views;
}

/// Camera beside the gripper, a board of A4 on the table.
ServoScene camera_on_arm(test::Random& random) {
  ServoScene scene;
  scene.X_MC = {rotation_z(kPi / 2) * rotation_from_vector(random_vector(random, 0.15)),
                Vec3{0.048, 0.006, -0.02} + random_vector(random, 0.01)};
  scene.X_NB = {rotation_z(-kPi / 2 + random.uniform(-0.2, 0.2)),
                Vec3{0.235, 0, 0} + random_vector(random, 0.01)};
  scene.points_B = grid(5, 7, 0.038);
  return scene;
}

/// Camera on a stand, a tag of 40 mm on the gripper.
ServoScene tag_on_arm(test::Random& random) {
  ServoScene scene;
  scene.mounting = CameraMounting::kFixed;
  scene.X_MC = {
      rotation_z(kPi / 2) * rotation_x(kPi) * rotation_from_vector(random_vector(random, 0.1)),
      Vec3{0.16, -0.03, 0.55} + random_vector(random, 0.02)};
  scene.X_NB = {rotation_y(-kPi / 2 + 0.5) * rotation_from_vector(random_vector(random, 0.2)),
                {-0.03, 0.004, -0.03}};
  scene.points_B = grid(2, 2, 0.04);
  return scene;
}

/// What many calibrations were off by, and whether they said so.
struct Outcomes {
  int cases = 0;
  int board_inside = 0;  ///< of the error that was said
  int camera_inside = 0;
  std::vector<double> board;   ///< m
  std::vector<double> camera;  ///< m
  std::vector<double> said;    ///< m, of the board
  std::vector<double> size;    ///< of the tag
};

Outcomes calibrated(ServoScene (*make)(test::Random&), const HandEyeSettings& settings,
                    double tag_seems) {
  constexpr std::size_t kViews = 14;
  constexpr int kCases = 20;
  Outcomes out;
  test::for_random_cases(kCases, [&](test::Random& random) {
    ServoScene scene = make(random);
    for (Vec3& p : scene.points_B) p = tag_seems * p;
    auto views = servo_views(scene, kViews, random);
    ASSERT_EQ(views.size(), kViews);
    for (HandEyeView& view : views) {
      for (Vec3& p : view.seen.points_B) p = (1 / tag_seems) * p;
    }
    const auto found = hand_eye(webcam(), views, settings);
    ASSERT_TRUE(found) << sentence(found.error());
    EXPECT_TRUE(found->observability.complete()) << found->observability.weak[0].what;
    // A corner of the sheet on the table, or of the table that the camera sees.
    const Vec3 p_B = scene.mounting == CameraMounting::kOnFlange ? Vec3{0.08, 0.1, 0} : Vec3{};
    const Vec3 p_C{0.05, 0.05, 0.5};
    ++out.cases;
    out.board.push_back(norm(found->X_NB * p_B - scene.X_NB * p_B));
    out.camera.push_back(norm(found->X_MC * p_C - scene.X_MC * p_C));
    out.said.push_back(board_error_95(*found, p_B));
    out.board_inside += out.board.back() <= out.said.back() ? 1 : 0;
    out.camera_inside += out.camera.back() <= camera_error_95(*found, p_C) ? 1 : 0;
    out.size.push_back(found->size);
  });
  return out;
}

TEST(HandEyeServoArm, camera_on_the_arm_finds_the_table_to_3_mm_and_says_what_it_is_off_by) {
  const Outcomes out = calibrated(camera_on_arm, {}, 1);
  EXPECT_LT(quantile(out.board, 0.95), 3e-3);
  EXPECT_LT(quantile(out.said, 0.5), 5e-3);
  EXPECT_GE(out.board_inside, 17) << "95 % of " << out.cases;
  EXPECT_GE(out.camera_inside, 17);
}

TEST(HandEyeServoArm, tag_on_the_arm_that_seems_smaller_is_measured_by_the_arms_motions) {
  constexpr double kSeems = 0.97;
  const HandEyeSettings exact{.mounting = CameraMounting::kFixed};
  HandEyeSettings free = exact;
  free.size_sigma = 0.02;
  const Outcomes off = calibrated(tag_on_arm, exact, kSeems);
  const Outcomes out = calibrated(tag_on_arm, free, kSeems);
  EXPECT_EQ(quantile(off.size, 1), 1);
  EXPECT_NEAR(quantile(out.size, 0.5), kSeems, 0.005);
  EXPECT_GT(quantile(off.camera, 0.5), 1.5 * quantile(out.camera, 0.5));
  EXPECT_LT(quantile(out.camera, 0.5), 3e-3);
  EXPECT_GE(out.camera_inside, 17) << "95 % of " << out.cases;
}

}  // namespace
}  // namespace sinew::calibration
