#include "sinew/render/cell_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/calibration/plane_pose.h"
#include "sinew/core/assert.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/serial_arm.h"
#include "support/robots.h"

namespace sinew::render {
namespace {

using vision::ColorName;

constexpr double kEdge = 0.025;

const vision::CameraModel& camera() {
  static const auto model = vision::pinhole(640, 360, from_deg(60));
  return model;
}
Pose<frame::World, frame::Camera> aslant() {
  return looking_at({0.05, -0.35, 0.4}, {0.02, 0.0, 0});
}

ViewedCube cube_at(double x, double y, double yaw, ColorName color) {
  return {{rotation_z(yaw), {x, y, kEdge / 2}}, kEdge, color};
}

ViewedRobot learm(double shoulder) {
  ViewedRobot robot{test::robot("learm"), {Rotation{}, {-0.15, 0.05, 0}}, {}, 0.04};
  for (const double q : {0.0, shoulder, 0.6, 0.9, 0.0}) robot.q.push_back(q);
  return robot;
}

ViewedSheet sheet_at(double x, double y, double yaw) {
  const auto board = vision::table_sheet("a4").value();
  return {board, {rotation_z(yaw), {x, y, 0}}, print_of(board)};
}

std::size_t pixel_of(const Vec3& p_W, const Pose<frame::World, frame::Camera>& X_WC) {
  const auto p = camera().project(X_WC.inverse() * p_W);
  SINEW_ASSERT(p && p->x >= 0 && p->y >= 0 && p->x < 640 && p->y < 360);
  return static_cast<std::size_t>(p->y) * 640 + static_cast<std::size_t>(p->x);
}

/// Mean of 3 x 3 pixels.
std::array<double, 3> seen_at(const vision::Picture& picture, const Vec3& p_W,
                              const Pose<frame::World, frame::Camera>& X_WC) {
  const std::size_t i = pixel_of(p_W, X_WC);
  std::array<double, 3> mean{};
  for (int k = 0; k < 9; ++k) {
    const std::uint8_t* rgb =
        picture.at(static_cast<int>(i % 640) + k % 3 - 1, static_cast<int>(i / 640) + k / 3 - 1);
    for (std::size_t c = 0; c < 3; ++c) mean[c] += rgb[c] / 9.0;
  }
  return mean;
}

TEST(CellScene, tops_of_cubes_show_their_colors_and_the_floor_of_the_basket_its_own) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    CellView view;
    view.seed = seed;
    view.cubes = {cube_at(-0.06, 0, 0.3, ColorName::kRed), cube_at(0, 0.05, 1, ColorName::kGreen),
                  cube_at(0.06, -0.02, 0, ColorName::kBlue),
                  cube_at(0.1, 0.06, 0.7, ColorName::kYellow)};
    view.baskets = {ViewedBasket{.X_WS = {rotation_z(0.2), {0.02, 0.16, 0}}, .srgb = 0xC02080U}};
    const auto picture = picture_of(view, camera(), aslant(), {}, seed);
    const auto top = [&](std::size_t i) {
      return seen_at(picture, view.cubes[i].X_WS.p + Vec3{0, 0, kEdge / 2}, aslant());
    };
    EXPECT_GT(top(0)[0], 1.5 * std::max(top(0)[1], top(0)[2])) << "red";
    EXPECT_GT(top(1)[1], 1.1 * std::max(top(1)[0], top(1)[2])) << "green";
    EXPECT_GT(top(2)[2], 1.2 * std::max(top(2)[0], top(2)[1])) << "blue";
    EXPECT_GT(std::min(top(3)[0], top(3)[1]), 1.3 * top(3)[2]) << "yellow";
    const auto floor = seen_at(picture, {0.02, 0.17, 0.003}, aslant());
    EXPECT_GT(std::min(floor[0], floor[2]), 1.3 * floor[1]) << "magenta";
  }
}

TEST(CellScene, walls_of_the_basket_hide_what_lies_behind_them_and_not_its_middle) {
  CellView view;
  view.cubes = {cube_at(0.02, 0.16, 0, ColorName::kRed)};
  view.baskets = {ViewedBasket{.X_WS = {Rotation{}, {0.02, 0.16, 0}}}};
  const View seen = view_of(cell_scene(view), camera(), aslant(), 1);
  EXPECT_EQ(seen.solids[pixel_of({0.02, 0.16, kEdge}, aslant())], 1);
  // Solids: table, cube, floor, +x wall, -x wall, +y wall, -y wall.
  EXPECT_EQ(seen.solids[pixel_of({0.02, 0.0985, 0.04}, aslant())], 6) << "the near wall, outside";
  EXPECT_EQ(seen.solids[pixel_of({0.02, 0.105, 0.003}, aslant())], 6) << "hides the floor there";
  EXPECT_EQ(seen.solids[pixel_of({0.02, 0.217, 0.04}, aslant())], 5) << "the far one, inside";
}

TEST(CellScene, the_arm_hides_what_it_stands_in_front_of) {
  CellView view;
  view.robots = {learm(1.2)};
  const auto links = link_poses(view.robots[0]);
  ASSERT_EQ(links.size(), 7U);
  const Vec3 wrist = links[3].p;  // the elbow's row ends there
  const auto X_WC = aslant();
  // A cube where the line of sight through the wrist meets the table.
  const Vec3 ray = wrist - X_WC.p;
  const Vec3 behind = X_WC.p + -(X_WC.p.z - kEdge) / ray.z * ray;
  view.cubes = {cube_at(behind.x, behind.y, 0, ColorName::kRed)};
  const std::size_t pixel = pixel_of(behind, X_WC);
  const View with_arm = view_of(cell_scene(view), camera(), X_WC, 1);
  EXPECT_GT(with_arm.solids[pixel], 1) << "a link";
  view.robots.clear();
  const View without = view_of(cell_scene(view), camera(), X_WC, 1);
  EXPECT_EQ(without.solids[pixel], 1) << "the cube";
}

TEST(CellScene, links_are_where_the_kinematics_says) {
  const ViewedRobot robot = learm(0.4);
  const auto links = link_poses(robot);
  const auto& geometry = std::get<SerialGeometry>(robot.model.geometry);
  const kinematics::SerialArm arm(geometry, robot.model.joints, geometry.X_FT);
  const auto X_WT = robot.X_WB * arm.forward({robot.q.begin(), robot.q.size()});
  EXPECT_LT(norm(links.back().p - X_WT.p), 1e-12);
  ViewedRobot palletizer{test::robot("maxarm"), {}, {}, 0};
  for (const Joint& joint : palletizer.model.joints) palletizer.q.push_back(joint.home);
  ASSERT_EQ(link_poses(palletizer).size(), 5U);
  EXPECT_NEAR(link_poses(palletizer).back().p.z, 0.212, 1e-3) << "the maker's home";
  EXPECT_NEAR(link_poses(palletizer).back().p.y, -0.163, 1e-3);
}

TEST(CellScene, fingers_stand_as_wide_as_the_jaws) {
  ViewedRobot robot = learm(0.5);
  for (const double jaws : {0.02, 0.05}) {
    robot.jaws = jaws;
    Scene scene;
    add_robot(scene, robot, {}, {}, {});
    const Solid& one = scene.solids[scene.solids.size() - 2];
    const Solid& other = scene.solids.back();
    EXPECT_NEAR(norm(one.X_WS.p - other.X_WS.p), jaws + 2 * 0.006, 1e-9);
  }
}

TEST(CellScene, tags_give_the_camera_s_pose_back) {
  for (const double yaw : {0.0, 0.5}) {
    CellView view;
    view.sheets = {sheet_at(0.02, 0.02, yaw)};
    view.cubes = {cube_at(0.02, 0.02, 0.2, ColorName::kBlue)};
    const auto X_WC = looking_at({0.05, -0.25, 0.45}, {0.02, 0.02, 0});
    const auto picture = picture_of(view, camera(), X_WC, {}, 3);
    vision::TagFinder finder({vision::TagFamily::k36h11, vision::TagFamily::kStandard41h12});
    const auto corners = vision::corners_in(view.sheets[0].board, finder.find(picture));
    ASSERT_EQ(corners.points_B.size(), 16U) << "all four tags";
    const auto found = calibration::plane_pose(camera(), corners);
    ASSERT_TRUE(found);
    const auto X_WC_seen = view.sheets[0].X_WP * found->X_CB.inverse();
    EXPECT_LT(norm(X_WC_seen.p - X_WC.p), 1e-3);
    EXPECT_LT(angle_between(X_WC_seen.R, X_WC.R), from_deg(0.2));
  }
}

TEST(CellScene, a_hand_reaches_in_from_its_side) {
  CellView view;
  view.hand = ViewedHand{{0.05, 0, 0.01}, 0};
  const View seen = view_of(cell_scene(view), camera(), aslant(), 1);
  const auto solid_at = [&](const Vec3& p) { return seen.solids[pixel_of(p, aslant())]; };
  EXPECT_GT(solid_at({0.15, 0, 0.05}), 0) << "its back";
  EXPECT_EQ(solid_at({-0.05, 0, 0.01}), 0) << "on the other side is the table";
}

TEST(CellScene, a_view_is_a_picture_and_another_seed_another_one) {
  CellView view;
  view.cubes = {cube_at(0, 0, 0.3, ColorName::kWood)};
  view.clutter = {{ViewedThing::Form::kDisc, {Rotation{}, {0.1, 0, 0.003}}, {0.03, 0.03, 0.003}}};
  view.robots = {learm(0.5)};
  const auto small = vision::pinhole(96, 54, from_deg(60));
  const auto bytes = [&] { return picture_of(view, small, aslant(), {}, 7).rgb; };
  const auto first = bytes();
  EXPECT_EQ(first, bytes());
  view.seed = 2;
  EXPECT_NE(first, bytes());
}

TEST(CellScene, clutter_lies_where_it_lay_whatever_the_cubes_do_and_changes_nothing_else) {
  CellView view;
  for (int i = 0; i < 9; ++i) {
    view.cubes.push_back(cube_at(0.06 * (i % 3 - 1), 0.06 * (i / 3 - 1), i, ColorName::kPink));
  }
  const Scene tidy = cell_scene(view);
  using Form = ViewedThing::Form;
  view.clutter = {{Form::kBox, {rotation_z(0.4), {0, 0, 6e-5}}, {0.1, 0.07, 5e-5}, 0xF0F0F0},
                  {Form::kDisc, {Rotation{}, {0.12, 0, 0.003}}, {0.03, 0.03, 0.003}, 0x305080}};
  const Scene scene = cell_scene(view);
  ASSERT_EQ(scene.solids.size(), tidy.solids.size() + 2);
  for (std::size_t i = 0; i < tidy.solids.size(); ++i) {
    EXPECT_EQ(scene.solids[i].X_WS, tidy.solids[i].X_WS);
    EXPECT_EQ(scene.solids[i].material.color.r, tidy.solids[i].material.color.r);
  }
  view.cubes.clear();
  const Scene bare = cell_scene(view);
  for (int i = 1; i <= 2; ++i) {
    const Solid& with = scene.solids[scene.solids.size() - i];
    const Solid& without = bare.solids[bare.solids.size() - i];
    EXPECT_EQ(with.X_WS, without.X_WS);
    EXPECT_EQ(with.material.color.r, without.material.color.r);
  }
}

TEST(CellScene, of_two_sheets_the_one_laid_later_is_seen_whatever_the_arm_does) {
  CellView view;
  using Form = ViewedThing::Form;
  view.clutter = {{Form::kBox, {Rotation{}, {0.05, 0, 6e-5}}, {0.05, 0.05, 5e-5}, 0x202020},
                  {Form::kBox, {Rotation{}, {0.08, 0, 6e-5}}, {0.05, 0.05, 5e-5}, 0xF0F0F0}};
  for (const double shoulder : {-0.4, 0.0, 0.3, 0.9}) {
    view.robots = {learm(shoulder)};
    const auto picture = picture_of(view, camera(), aslant(), {}, 7);
    const auto both = seen_at(picture, {0.07, 0.02, 0}, aslant());
    const auto later = seen_at(picture, {0.12, 0.02, 0}, aslant());
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(both[c], later[c], 30) << shoulder;
  }
}

TEST(CellScene, exposure_is_automatic_and_the_sensor_s_is_a_factor) {
  CellView view;
  view.top = TableTop::kWood;
  const auto small = vision::pinhole(96, 54, from_deg(60));
  const auto mean = [&](double brightness, double exposure) {
    view.brightness = brightness;
    const auto picture = picture_of(view, small, aslant(), {.exposure = exposure}, 7);
    double sum = 0;
    for (const std::uint8_t byte : picture.rgb) sum += byte;
    return sum / static_cast<double>(picture.rgb.size());
  };
  EXPECT_NEAR(mean(0.2, 1), mean(1, 1), 3);
  EXPECT_LT(mean(1, 0.5), mean(1, 1) - 20);
}

TEST(CellScene, an_arm_that_moves_is_blurred_and_nothing_else_is) {
  CellView view;
  view.robots = {learm(0.3)};
  const Sensor sensor{.shutter = 0.02, .read_out = 0.01};
  const auto still = picture_of(view, camera(), aslant(), sensor, 7);
  EXPECT_EQ(still.rgb, picture_of(view, camera(), aslant(), {}, 7).rgb);
  view.robots[0].qd = {1.5, 0, 0, 0, 0};
  const auto moving = picture_of(view, camera(), aslant(), sensor, 7);
  EXPECT_NE(moving.rgb, still.rgb);
  /// Of rows and columns, what they change by from pixel to pixel.
  const auto edges = [](const vision::Picture& picture) {
    double sum = 0;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 1; x < picture.width; ++x) {
        sum += std::abs(picture.at(x, y)[1] - picture.at(x - 1, y)[1]);
      }
    }
    return sum;
  };
  EXPECT_LT(edges(moving), edges(still));
  // Beside the arm and its shadows, where the exposure alone may differ a little.
  const auto before = seen_at(still, {0.15, -0.1, 0}, aslant());
  const auto then = seen_at(moving, {0.15, -0.1, 0}, aslant());
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(before[c], then[c], 2);
}

TEST(CellScene, a_camera_s_compression_costs_what_its_quality_says) {
  CellView view;
  view.cubes = {cube_at(0, 0, 0.3, ColorName::kRed)};
  const auto plain = picture_of(view, camera(), aslant(), {}, 7);
  const auto off = [&](int quality) {
    const auto picture = picture_of(view, camera(), aslant(), {.jpeg = quality}, 7);
    double sum = 0;
    for (std::size_t i = 0; i < plain.rgb.size(); ++i)
      sum += std::abs(plain.rgb[i] - picture.rgb[i]);
    return sum / static_cast<double>(plain.rgb.size());
  };
  EXPECT_GT(off(95), 0);
  EXPECT_GT(off(60), off(95));
  EXPECT_GT(off(20), off(60));
  EXPECT_LT(off(20), 8);
}

}  // namespace
}  // namespace sinew::render
