#include "sinew/calibration/plane_pose.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>

#include "sinew/calibration/scene_test_data.h"

namespace sinew::calibration {
namespace {

PoseCB random_pose(test::Random& random) {
  return facing(random.uniform(-0.9, 0.9), random.uniform(-0.9, 0.9), random.uniform(-3, 3),
                {random.uniform(-0.1, 0.1), random.uniform(-0.05, 0.05), random.uniform(0.3, 0.8)});
}

TEST(PlanePose, exact_pixels_give_the_pose) {
  test::for_random_cases(100, [](test::Random& random) {
    const PoseCB X_CB = random_pose(random);
    const int side = static_cast<int>(random.integer(2, 5));
    const auto seen = seen_points(webcam(), X_CB, grid(side, side, 0.12 / side), 0, random);
    if (seen.pixels.size() < 4) return random.discard();
    const auto pose = plane_pose(webcam(), seen);
    ASSERT_TRUE(pose) << sentence(pose.error());
    EXPECT_LT(step_between(X_CB, pose->X_CB).norm(), 1e-9);
    EXPECT_LT(pose->rms, 1e-8);
    EXPECT_TRUE(pose->wrong_points.empty());
  });
}

TEST(PlanePose, three_of_four_points_may_be_on_a_line) {
  int found = 0;
  constexpr int kCases = 100;
  test::for_random_cases(kCases, [&](test::Random& random) {
    const PoseCB X_CB = facing(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5),
                               random.uniform(-3, 3), {0.02, 0.01, 0.3});
    std::vector<Vec3> points_B = grid(3, 1, 0.035);
    points_B.push_back({0.035, 0.035, 0});
    const auto pose = plane_pose(webcam(), seen_points(webcam(), X_CB, points_B, 0.2, random));
    found += pose && pose->rms < 2 ? 1 : 0;
  });
  EXPECT_GE(found, 0.9 * kCases);
}

TEST(PlanePose, covariance_is_that_of_the_errors) {
  double sum = 0;
  constexpr int kCases = 200;
  test::for_random_cases(kCases, [&](test::Random& random) {
    const PoseCB X_CB = facing(random.uniform(0.3, 0.8), random.uniform(0.3, 0.8), 0, {0, 0, 0.5});
    const auto seen = seen_points(webcam(), X_CB, grid(7, 6, 0.03), 0.3, random);
    const auto pose = plane_pose(webcam(), seen, 0.01);
    ASSERT_TRUE(pose);
    const Vector6 off = step_between(pose->X_CB, X_CB);
    sum += off.dot(pose->covariance.inverse() * off);
  });
  expect_chi_square(sum, kCases, 6);
}

TEST(PlanePose, small_tag_far_away_is_ambiguous_and_its_true_pose_is_one_of_both) {
  test::for_random_cases(50, [](test::Random& random) {
    const PoseCB X_CB = facing(0.5, 0.3, random.uniform(-3, 3), {0.02, 0, 1.5});
    const auto seen = seen_points(webcam(), X_CB, grid(2, 2, 0.03), 0.2, random);
    const auto pose = plane_pose(webcam(), seen);
    ASSERT_TRUE(pose);
    ASSERT_TRUE(pose->other);
    EXPECT_GE(pose->ambiguity, 1);
    const double off = angle_between(pose->X_CB.R, X_CB.R);
    EXPECT_LT(std::min(off, angle_between(pose->other->R, X_CB.R)), 0.3);
  });
}

TEST(PlanePose, near_tilted_board_is_not_ambiguous) {
  test::for_random_cases(50, [](test::Random& random) {
    const PoseCB X_CB = facing(0.6, random.uniform(-0.3, 0.3), random.uniform(-3, 3), {0, 0, 0.4});
    const auto seen = seen_points(webcam(), X_CB, grid(4, 4, 0.04), 0.2, random);
    const auto pose = plane_pose(webcam(), seen);
    ASSERT_TRUE(pose);
    EXPECT_FALSE(pose->ambiguous()) << pose->ambiguity;
    EXPECT_LT(angle_between(pose->X_CB.R, X_CB.R), 0.02);
  });
}

TEST(PlanePose, wrong_points_are_named_and_do_not_count) {
  test::for_random_cases(50, [](test::Random& random) {
    const PoseCB X_CB = facing(0.4, 0.2, 0.1, {0, 0, 0.5});
    auto seen = seen_points(webcam(), X_CB, grid(6, 5, 0.04), 0.2, random);
    const std::vector<std::size_t> wrong{3, 17};
    for (const std::size_t i : wrong) seen.pixels[i] = {random.uniform(0, 200), 20};
    const auto pose = plane_pose(webcam(), seen);
    ASSERT_TRUE(pose) << sentence(pose.error());
    // Of 28 points, one with a large error may go with them.
    EXPECT_TRUE(std::includes(pose->wrong_points.begin(), pose->wrong_points.end(), wrong.begin(),
                              wrong.end()));
    EXPECT_LE(pose->wrong_points.size(), 3U);
    EXPECT_LT(norm(pose->X_CB.p - X_CB.p), 1e-3);
  });
}

TEST(PlanePose, three_points_or_a_line_are_refused_with_a_sentence) {
  test::Random random(1);
  const PoseCB X_CB = facing(0, 0, 0, {0, 0, 0.5});
  const auto three = seen_points(webcam(), X_CB, grid(3, 1, 0.03), 0, random);
  const auto few = plane_pose(webcam(), three);
  ASSERT_FALSE(few);
  EXPECT_EQ(sentence(few.error()), "Too few points: 3, at least 4 needed. Show more of the board.");
  const auto line = plane_pose(webcam(), seen_points(webcam(), X_CB, grid(6, 1, 0.03), 0, random));
  ASSERT_FALSE(line);
  EXPECT_EQ(sentence(line.error()),
            "The points are nearly on one line: 150 mm long, 0 mm wide, at least 7.5 mm wide "
            "needed. Add a point away from the line.");
}

PoseWC above_table(test::Random& random) {
  const PoseCB X_CW = facing(random.uniform(-0.6, 0.6), random.uniform(-0.4, 0.4),
                             random.uniform(-3, 3), {0.02, 0.03, 0.7});
  return relabel<frame::World, frame::Camera>(X_CW.inverse());
}

TEST(RayToPlane, point_of_the_plane_comes_back_from_its_pixel) {
  test::for_random_cases(300, [](test::Random& random) {
    const PoseWC X_WC = above_table(random);
    const Vec3 p_W{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(0, 0.05)};
    const auto pixel = webcam().project(X_WC.inverse() * p_W);
    ASSERT_TRUE(pixel);
    const auto back = ray_to_plane(webcam(), X_WC, *pixel, p_W.z);
    ASSERT_TRUE(back);
    EXPECT_LT(norm(*back - p_W), 1e-9);
  });
}

TEST(RayToPlane, plane_behind_the_camera_or_along_the_ray_has_no_point) {
  test::Random random(1);
  const PoseWC X_WC = above_table(random);
  EXPECT_FALSE(ray_to_plane(webcam(), X_WC, {640, 360}, 2));
  const PoseWC level{rotation_x(-kPi / 2), {0, 0, 0.3}};  // looks along y
  EXPECT_FALSE(ray_to_plane(webcam(), level, webcam().center, 0));
}

TEST(TableCovariance, is_that_of_drawn_errors) {
  test::Random random(test::seed());
  const PoseWC X_WC = above_table(random);
  CameraUncertainty uncertainty;
  uncertainty.pixel = 0.4;
  const Vector6 pose_sigma = (Vector6() << 1e-3, 2e-3, 1e-3, 5e-4, 3e-4, 8e-4).finished();
  uncertainty.pose = pose_sigma.cwiseAbs2().asDiagonal();
  CameraVector camera_sigma = CameraVector::Zero();
  camera_sigma << 2, 3, 1, 1.5, 2e-3, 0, 1e-4, 2e-4, 0;
  uncertainty.camera = camera_sigma.cwiseAbs2().asDiagonal();
  const vision::Pixel pixel{300, 500};
  const Eigen::Matrix2d expected = table_covariance(webcam(), X_WC, pixel, 0.02, uncertainty);
  const Vec3 middle = ray_to_plane(webcam(), X_WC, pixel, 0.02).value();
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  constexpr int kDraws = 4000;
  for (int i = 0; i < kDraws; ++i) {
    const Vector6 step =
        pose_sigma.cwiseProduct(Vector6::NullaryExpr([&] { return normal(random); }));
    const CameraVector change =
        camera_sigma.cwiseProduct(CameraVector::NullaryExpr([&] { return normal(random); }));
    const auto camera = with_parameters(webcam(), parameters_of(webcam()) + change);
    const vision::Pixel p = pixel + 0.4 * vision::Pixel{normal(random), normal(random)};
    const Vec3 off = ray_to_plane(camera, moved(X_WC, step), p, 0.02).value() - middle;
    sum += Eigen::Vector2d(off.x, off.y) * Eigen::Vector2d(off.x, off.y).transpose();
  }
  sum /= kDraws;
  EXPECT_LT((sum - expected).norm(), 0.12 * expected.norm()) << sum << "\n" << expected;
}

TEST(InverseCovariance, is_that_of_drawn_errors) {
  test::Random random(test::seed());
  const PoseCB X_CB = random_pose(random);
  const Vector6 sigma = (Vector6() << 1e-3, 2e-3, 3e-3, 1e-3, 2e-3, 5e-4).finished();
  const Matrix6 covariance = sigma.cwiseAbs2().asDiagonal();
  const Matrix6 expected = inverse_covariance(X_CB, covariance);
  Matrix6 sum = Matrix6::Zero();
  constexpr int kDraws = 4000;
  for (int i = 0; i < kDraws; ++i) {
    const Vector6 step = sigma.cwiseProduct(Vector6::NullaryExpr([&] { return normal(random); }));
    const Vector6 off = step_between(X_CB.inverse(), moved(X_CB, step).inverse());
    sum += off * off.transpose();
  }
  EXPECT_LT((sum / kDraws - expected).norm(), 0.12 * expected.norm());
}

}  // namespace
}  // namespace sinew::calibration
