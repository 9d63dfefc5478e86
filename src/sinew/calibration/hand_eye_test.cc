#include "sinew/calibration/hand_eye.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <functional>

#include "sinew/calibration/scene_test_data.h"

namespace sinew::calibration {
namespace {

using PoseBF = Pose<frame::Base, frame::Flange>;

/// An arm with a camera and a board, and where they really are.
struct Scene {
  vision::CameraModel camera = webcam();
  CameraMounting mounting = CameraMounting::kOnFlange;
  PoseMC X_MC;
  PoseNB X_NB;
  std::vector<Vec3> points_B = grid(4, 3, 0.035);

  PoseCB board_in_camera(const PoseBF& X_BF) const {
    return X_MC.inverse() * between_mounts(mounting, X_BF) * X_NB;
  }
  /// Nothing where the camera does not show the whole board, or as many points as given.
  std::optional<HandEyeView> view(const PoseBF& X_BF, double sigma, test::Random& random,
                                  std::size_t points_min = 12) const {
    const PoseCB X_CB = board_in_camera(X_BF);
    if (X_CB.R.z.z > -0.3) return std::nullopt;
    HandEyeView out{X_BF, seen_points(camera, X_CB, points_B, sigma, random), std::nullopt};
    if (out.seen.pixels.size() < points_min) return std::nullopt;
    return out;
  }
};

/// Camera beside the tool, looks along the flange's z axis; the board lies before the base.
Scene on_flange(test::Random& random) {
  Scene scene;
  scene.X_MC = {rotation_z(kPi / 2) * rotation_from_vector(random_vector(random, 0.2)),
                Vec3{0.05, 0.01, 0.02} + random_vector(random, 0.01)};
  scene.X_NB = {rotation_z(random.uniform(-3, 3)) * rotation_x(random.uniform(-0.1, 0.1)),
                Vec3{0.35, 0, 0} + random_vector(random, 0.02)};
  return scene;
}

/// Camera on a stand before the base; the board is on the flange.
Scene fixed(test::Random& random) {
  Scene scene;
  scene.mounting = CameraMounting::kFixed;
  scene.X_MC = {rotation_z(kPi / 2) * rotation_x(-1.9 + random.uniform(-0.2, 0.2)),
                Vec3{0.9, 0, 0.4} + random_vector(random, 0.05)};
  scene.X_NB = {rotation_from_vector(random_vector(random, 0.3)), {0.02, 0.01, 0.04}};
  return scene;
}

using DrawPose = std::function<PoseBF(test::Random&)>;

std::vector<HandEyeView> draw_views(const Scene& scene, int count, double sigma,
                                    test::Random& random, const DrawPose& draw) {
  std::vector<HandEyeView> views;
  for (int i = 0; i < 100'000 && std::ssize(views) < count; ++i) {
    if (auto view = scene.view(draw(random), sigma, random)) views.push_back(std::move(*view));
  }
  return views;
}

/// Six joints: any pose that shows the board.
DrawPose six_joints(const Scene& scene) {
  return [&scene](test::Random& random) {
    const PoseCB X_CB = facing(
        random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), random.uniform(-1.5, 1.5),
        {random.uniform(-0.08, 0.08), random.uniform(-0.05, 0.05), random.uniform(0.25, 0.45)});
    const PoseMN X_MN = scene.X_MC * X_CB * scene.X_NB.inverse();
    const auto X = relabel<frame::Base, frame::Flange>(X_MN);
    return scene.mounting == CameraMounting::kFixed
               ? X
               : relabel<frame::Base, frame::Flange>(X.inverse());
  };
}

/// Five joints without their last: R_BF = Rz(yaw) Ry(pitch), the flange in the plane of the yaw.
PoseBF planar_pose(double yaw, double pitch, double radius, double height) {
  return {rotation_z(yaw) * rotation_y(pitch), rotation_z(yaw) * Vec3{radius, 0, height}};
}
PoseBF five_joints(test::Random& random) {
  return planar_pose(random.uniform(-0.6, 0.6), kPi + random.uniform(-0.6, 0.6),
                     random.uniform(0.1, 0.5), random.uniform(0.2, 0.4));
}
PoseBF yaw_alone(test::Random& random) {
  return planar_pose(random.uniform(-3, 3), kPi, 0.25, 0.35);
}
/// A palletizer: the flange always points down.
PoseBF four_joints(test::Random& random) {
  return planar_pose(random.uniform(-0.5, 0.5), kPi, random.uniform(0.15, 0.45),
                     random.uniform(0.25, 0.4));
}

MountVector step_from(const HandEye& found, const Scene& scene) {
  MountVector off;
  off << step_between(found.X_MC, scene.X_MC), step_between(found.X_NB, scene.X_NB);
  return off;
}

void expect_exact(const Scene& scene, const std::vector<HandEyeView>& views) {
  const auto found = hand_eye(scene.camera, views, {.mounting = scene.mounting});
  ASSERT_TRUE(found) << sentence(found.error());
  EXPECT_LT(step_from(*found, scene).norm(), 1e-9);
  EXPECT_TRUE(found->observability.complete());
  EXPECT_LT(found->rms, 1e-7);
  EXPECT_LT(found->error_95, 1e-9);
}

TEST(HandEye, exact_pixels_give_both_mounts_with_six_joints) {
  test::for_random_cases(20, [](test::Random& random) {
    const Scene scene = random.chance(0.5) ? on_flange(random) : fixed(random);
    expect_exact(scene, draw_views(scene, 8, 0, random, six_joints(scene)));
  });
}

TEST(HandEye, exact_pixels_give_both_mounts_with_five_joints) {
  test::for_random_cases(20, [](test::Random& random) {
    const Scene scene = on_flange(random);
    const auto views = draw_views(scene, 8, 0, random, five_joints);
    ASSERT_EQ(views.size(), 8U);
    expect_exact(scene, views);
  });
}

TEST(HandEye, any_mounting_rotation_is_found) {
  test::for_random_cases(20, [](test::Random& random) {
    Scene scene = on_flange(random);
    scene.X_MC.R = rotation_from_vector(random_vector(random, 1.8));
    expect_exact(scene, draw_views(scene, 6, 0, random, six_joints(scene)));
  });
}

TEST(HandEye, covariance_is_that_of_the_errors_with_six_joints) {
  double sum = 0;
  constexpr int kCases = 100;
  test::for_random_cases(kCases, [&](test::Random& random) {
    const Scene scene = on_flange(random);
    const auto views = draw_views(scene, 10, 0.2, random, six_joints(scene));
    const auto found = hand_eye(scene.camera, views);
    ASSERT_TRUE(found) << sentence(found.error());
    const MountVector off = step_from(*found, scene);
    sum += off.dot(found->covariance.inverse() * off);
    EXPECT_LT(norm(found->X_MC.p - scene.X_MC.p), 2e-3);
    EXPECT_LT(found->error_95, 1e-3);
    EXPECT_NEAR(found->rms, 0.2 * std::sqrt(2.0), 0.06);
  });
  expect_chi_square(sum, kCases, kMountParameters);
}

TEST(HandEye, covariance_is_that_of_the_errors_with_five_joints) {
  double sum = 0;
  constexpr int kCases = 100;
  test::for_random_cases(kCases, [&](test::Random& random) {
    const Scene scene = on_flange(random);
    const auto found = hand_eye(scene.camera, draw_views(scene, 10, 0.2, random, five_joints));
    ASSERT_TRUE(found) << sentence(found.error());
    EXPECT_TRUE(found->observability.complete()) << found->observability.weak[0].what;
    const MountVector off = step_from(*found, scene);
    sum += off.dot(found->covariance.inverse() * off);
  });
  expect_chi_square(sum, kCases, kMountParameters);
}

TEST(HandEye, yaw_alone_leaves_the_yaw_axis_open_and_the_suggested_pose_closes_it) {
  test::for_random_cases(10, [](test::Random& random) {
    Scene scene = on_flange(random);
    scene.X_NB.p = {0.03, 0, 0};
    scene.X_MC.R = rotation_y(0.5) * scene.X_MC.R;  // looks at the yaw axis
    auto views = draw_views(scene, 8, 0.2, random, yaw_alone);
    ASSERT_EQ(views.size(), 8U);
    const auto found = hand_eye(scene.camera, views);
    ASSERT_TRUE(found) << sentence(found.error());
    const Observability& seen = found->observability;
    ASSERT_EQ(seen.weak.size(), 2U) << seen.singular_values.transpose();
    EXPECT_EQ(seen.weak[0].what,
              "the camera's rotation about the flange's z axis, together with the board's rotation "
              "about the base's z axis");
    EXPECT_EQ(seen.weak[1].what,
              "the camera's position along the flange's z axis, together with the board's position "
              "along the base's z axis");
    EXPECT_EQ(seen.weak[1].remedy,
              "Add poses with the flange tilted by about 30 deg about its x or y axis.");

    std::vector<PoseBF> candidates{yaw_alone(random), yaw_alone(random)};
    for (const double tilt : {-0.5, 0.5}) {
      for (const double radius : {-0.1, 0.0, 0.1, 0.2, 0.3, 0.4}) {
        candidates.push_back(planar_pose(0, kPi + tilt, radius, 0.35));
      }
    }
    const auto next =
        next_poses(seen, scene.camera, found->X_MC, found->X_NB, scene.points_B, candidates);
    ASSERT_FALSE(next.empty());
    EXPECT_GE(next[0].index, 2U) << "a pose of the same pitch adds nothing";
    EXPECT_GT(next[0].smallest_after, kSingularValueMin);
    EXPECT_LT(next[0].smallest_before, 1e-6);
    std::optional<HandEyeView> view;
    for (std::size_t i = 0; i < next.size() && !view; ++i) {
      view = scene.view(candidates[next[i].index], 0.2, random, 8);
    }
    ASSERT_TRUE(view);
    views.push_back(*view);
    const auto after = hand_eye(scene.camera, views);
    ASSERT_TRUE(after) << sentence(after.error());
    EXPECT_TRUE(after->observability.complete()) << after->observability.weak[0].what;
  });
}

TEST(HandEye, palletizer_cannot_tell_heights_until_points_are_touched) {
  test::for_random_cases(10, [](test::Random& random) {
    const Scene scene = on_flange(random);
    const auto views = draw_views(scene, 12, 0.2, random, four_joints);
    ASSERT_EQ(views.size(), 12U);
    const auto without = hand_eye(scene.camera, views);
    ASSERT_TRUE(without) << sentence(without.error());
    ASSERT_EQ(without->observability.weak.size(), 1U);
    EXPECT_EQ(without->observability.weak[0].what,
              "the camera's position along the flange's z axis, together with the board's position "
              "along the base's z axis");
    HandEyeSettings settings;
    for (const std::size_t i : {0U, 3U, 8U}) {
      const Vec3 error{normal(random), normal(random), normal(random)};
      const Vec3 p_B = scene.points_B[i];
      settings.known_points.push_back({p_B, scene.X_NB * p_B + 0.5e-3 * error, 0.5e-3});
    }
    const auto with = hand_eye(scene.camera, views, settings);
    ASSERT_TRUE(with) << sentence(with.error());
    EXPECT_TRUE(with->observability.complete());
    EXPECT_LT(norm(with->X_MC.p - scene.X_MC.p), 3e-3);
    const MountVector off = step_from(*with, scene);
    EXPECT_LT(off.dot(with->covariance.inverse() * off), 60) << "chi-square of 12";
  });
}

TEST(HandEye, error_95_contains_the_errors_of_the_arm) {
  test::for_random_cases(10, [](test::Random& random) {
    const Scene scene = on_flange(random);
    auto views = draw_views(scene, 12, 0.2, random, five_joints);
    for (HandEyeView& view : views) {
      const Vector6 step = Vector6::NullaryExpr([&] { return 2e-3 * normal(random); });
      view.X_BF = moved(view.X_BF, step);
    }
    const auto found = hand_eye(scene.camera, views);
    ASSERT_TRUE(found) << sentence(found.error());
    EXPECT_GT(found->error_95, 2e-3);
    EXPECT_LT(found->error_95, 20e-3);
  });
}

TEST(HandEye, wrong_points_are_named) {
  test::for_random_cases(10, [](test::Random& random) {
    const Scene scene = on_flange(random);
    auto views = draw_views(scene, 8, 0.2, random, six_joints(scene));
    views[2].seen.pixels[5].x += 30;
    views[6].seen.pixels[0].y -= 8;
    const auto found = hand_eye(scene.camera, views);
    ASSERT_TRUE(found) << sentence(found.error());
    ASSERT_EQ(found->wrong_points.size(), 2U);
    EXPECT_EQ(found->wrong_points[0].view, 2U);
    EXPECT_EQ(found->wrong_points[0].point, 5U);
    EXPECT_NEAR(found->wrong_points[1].error, 8, 2);
  });
}

/// A five-joint arm: yaw, three pitches, roll along the tool.
kinematics::SerialChain small_arm() {
  SerialGeometry geometry;
  geometry.rows = {{0.10, 0, kPi / 2, 0},
                   {0, 0.14, 0, 0},
                   {0, 0.12, 0, 0},
                   {0, 0, kPi / 2, kPi / 2},
                   {0.08, 0, 0, 0}};
  return kinematics::SerialChain(geometry);
}

TEST(HandEye, zero_offsets_of_joints_are_found_with_their_jacobians) {
  const kinematics::SerialChain arm = small_arm();
  test::for_random_cases(5, [&](test::Random& random) {
    const bool moves = random.chance(0.5);
    Scene scene = moves ? on_flange(random) : fixed(random);
    (moves ? scene.X_NB.p : scene.X_MC.p) = moves ? Vec3{0.25, 0, 0} : Vec3{0.6, 0, 0.3};
    if (moves) scene.X_MC.p = {0.04, 0, -0.03};
    const std::array offsets{0.0, 0.012, -0.015, 0.01, 0.0};
    std::vector<HandEyeView> views;
    for (int i = 0; i < 100'000 && views.size() < 20; ++i) {
      std::array<double, 5> q{random.uniform(-0.6, 0.6), random.uniform(0.3, 2),
                              random.uniform(-2.2, 0), random.uniform(-2.5, 0.5),
                              random.uniform(-1.5, 1.5)};
      std::array<double, 5> q_real = q;
      for (std::size_t j = 0; j < 5; ++j) q_real[j] += offsets[j];
      auto view = scene.view(arm.forward(q_real), 0.2, random);
      if (!view) continue;
      kinematics::Jacobian J;
      view->X_BF = arm.forward(q, J);
      view->jacobian = J;
      views.push_back(std::move(*view));
    }
    ASSERT_EQ(views.size(), 20U);
    const auto without = hand_eye(scene.camera, views, {.mounting = scene.mounting});
    const auto with =
        hand_eye(scene.camera, views, {.mounting = scene.mounting, .joint_offset_sigma = 0.02});
    ASSERT_TRUE(without && with);
    EXPECT_LT(with->rms, 0.4);
    EXPECT_LT(with->error_95, 0.5 * without->error_95);
    ASSERT_EQ(with->joint_offsets.size(), 5U);
    for (const std::size_t j : {1U, 2U, 3U}) EXPECT_NEAR(with->joint_offsets[j], offsets[j], 3e-3);
  });
}

TEST(HandEye, too_few_views_and_a_view_without_points_are_refused) {
  test::Random random(1);
  const Scene scene = on_flange(random);
  auto views = draw_views(scene, 4, 0.2, random, six_joints(scene));
  const auto few = hand_eye(scene.camera, std::span(views).first(2));
  ASSERT_FALSE(few);
  EXPECT_EQ(few.error().fault, CalibrationFault::kTooFewViews);
  views[3].seen.points_B.resize(2);
  views[3].seen.pixels.resize(2);
  const auto empty = hand_eye(scene.camera, views);
  ASSERT_FALSE(empty);
  EXPECT_EQ(sentence(empty.error()),
            "Too few points of view 4: 2, at least 4 needed. Show more of the board.");
}

}  // namespace
}  // namespace sinew::calibration
