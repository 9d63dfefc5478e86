#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/render/cell_scene.h"
#include "sinew/vision/shapes.h"
#include "sinew/vision/table_camera.h"

/// What place_on_table() makes of tops that the detection was not sure of.
namespace sinew::vision {
namespace {

constexpr double kEdge = 0.025;  // m

class DoubtfulTops : public ::testing::Test {
 protected:
  DoubtfulTops() {
    camera_.model = pinhole(640, 480, from_deg(45));
    camera_.X_WC = render::looking_at({0, -0.2, 0.5}, {0, 0, 0});
    view_.top = render::TableTop::kWood;
    view_.reach = 0.25;
  }

  void stand(double x, double y, double turn, ColorName color) {
    view_.cubes.push_back({{rotation_z(turn), {x, y, kEdge / 2}}, kEdge, color});
  }
  /// A top that was refused there, of the size of a cube's.
  void refuse(double x, double y, double turn) {
    RefusedShape shape;
    const double half = kEdge / 2;
    const std::array<Vec3, 4> corners{
        {{-half, half, 0}, {half, half, 0}, {half, -half, 0}, {-half, -half, 0}}};
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3 p_W = Vec3{x, y, kEdge} + rotation_z(turn) * corners[i];
      shape.outline[i] = *camera_.model.project(camera_.X_WC.inverse() * p_W);
    }
    shape.why = "its top is hardly that of a cube, or mostly hidden";
    shape.height = Height::kLikely;
    SeenCube cube;
    cube.color = ColorName::kGreen;
    cube.top = shape.outline;
    cube.center = middle_of(shape.outline);
    cube.size = edge_of(shape.outline);
    cube.confidence = 0.4;
    shape.cube = cube;
    detection_.refused.push_back(shape);
  }
  void place() {
    const auto picture = render::picture_of(view_, camera_.model, camera_.X_WC, {}, 3);
    place_on_table(detection_, picture, camera_, kEdge);
  }

  TableCamera camera_;
  render::CellView view_;
  Detection detection_;
};

TEST_F(DoubtfulTops, become_cubes_where_their_sides_are_those_of_one_and_no_more_than_one) {
  stand(0.06, 0.05, 0.4, ColorName::kGreen);
  refuse(0.061, 0.051, 0.42);
  refuse(0.066, 0.055, 0.4);
  place();
  ASSERT_EQ(detection_.cubes.size(), 1U);
  EXPECT_NEAR(detection_.cubes[0].position->top_W.x, 0.06, 1.5e-3);
  EXPECT_NEAR(detection_.cubes[0].position->top_W.y, 0.05, 1.5e-3);
  EXPECT_EQ(detection_.cubes[0].position->level, 1);
}

TEST_F(DoubtfulTops, on_the_bare_table_are_nothing_that_a_grasp_has_to_keep_clear_of) {
  refuse(0.06, 0.05, 0.4);
  place();
  EXPECT_TRUE(detection_.cubes.empty());
  ASSERT_EQ(detection_.refused.size(), 1U);
  EXPECT_EQ(detection_.refused[0].height, Height::kPerhaps);
}

TEST_F(DoubtfulTops, that_touch_each_other_stay_likely_obstacles_at_least) {
  for (const double turn : {0.0, 0.5, 1.0, 1.3}) {
    view_.cubes.clear();
    detection_ = {};
    const Vec3 toward = rotation_z(turn) * Vec3{0, kEdge, 0};
    stand(0.02, 0.02, turn, ColorName::kRed);
    stand(0.02 + toward.x, 0.02 + toward.y, turn, ColorName::kRed);
    refuse(0.02, 0.02, turn);
    refuse(0.02 + toward.x, 0.02 + toward.y, turn);
    place();
    std::size_t likely = detection_.cubes.size();
    for (const RefusedShape& shape : detection_.refused) {
      likely += shape.height == Height::kLikely ? 1 : 0;
    }
    EXPECT_EQ(likely, 2U) << turn;
  }
}

TEST_F(DoubtfulTops, that_the_picture_cuts_off_stay_likely_obstacles) {
  const auto edge_W = on_plane(camera_, {639, 240}, kEdge);
  refuse(edge_W->x, edge_W->y, 0.4);
  place();
  ASSERT_EQ(detection_.refused.size(), 1U);
  EXPECT_EQ(detection_.refused[0].height, Height::kLikely);
}

TEST_F(DoubtfulTops, of_cubes_that_only_lack_a_color_stay_likely_obstacles) {
  refuse(0.06, 0.05, 0.4);
  detection_.refused[0].is_sure = true;
  detection_.refused[0].has_color = false;
  place();
  ASSERT_EQ(detection_.refused.size(), 1U);
  EXPECT_EQ(detection_.refused[0].height, Height::kLikely);
}

}  // namespace
}  // namespace sinew::vision
