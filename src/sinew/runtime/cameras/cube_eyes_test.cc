#include "sinew/runtime/cameras/cube_eyes.h"

#include <gtest/gtest.h>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"

namespace sinew::runtime {
namespace {

TEST(CubeEyes, places_are_the_robots_own) {
  CubeEyes::Place place;
  place.X_WB = {rotation_z(-kPi / 2), {1, 2, 0.01}};
  place.X_WT = {rotation_z(0.1), {1.05, 1.8, 0}};
  vision::Detection seen;
  vision::SeenCube cube;
  cube.color = vision::ColorName::kBlue;
  cube.position = vision::CubePosition{{0.03, 0.01, 0.025}, from_deg(10), 0.0248, 1};
  seen.cubes = {cube, vision::SeenCube{}};
  const auto sighting = sighting_of(seen, 0.025, place);
  ASSERT_EQ(sighting.cubes.size(), 1U) << "one has no place";
  const Vec3 p_W = place.X_WB * sighting.cubes[0].p_BO;
  const Vec3 expected = place.X_WT * Vec3{0.03, 0.01, 0.0125};
  EXPECT_NEAR(norm(p_W - expected), 0, 1e-12);
  EXPECT_NEAR(std::remainder(sighting.cubes[0].yaw - from_deg(10) - 0.1, kPi / 2), 0, 1e-12);
  EXPECT_EQ(sighting.cubes[0].edge, 0.025);
}

TEST(CubeEyes, what_is_in_the_basket_is_done_with) {
  CubeEyes::Place place;
  place.baskets.emplace_back();
  place.baskets[0].X_WK = {rotation_z(from_deg(45)), {0.2, 0, 0}};
  place.baskets[0].size = {0.1, 0.06, 0.04};
  vision::Detection seen;
  // Along the basket's length, across it, and on its wall.
  for (const Vec3& top : {Vec3{0.23, 0.03, 0.03}, {0.17, 0.03, 0.025}, {0.176, 0.024, 0.06}}) {
    seen.cubes.emplace_back().position = vision::CubePosition{top, 0, 0.025, 1};
  }
  const auto sighting = sighting_of(seen, 0.025, place);
  ASSERT_EQ(sighting.cubes.size(), 1U);
  EXPECT_NEAR(sighting.cubes[0].p_BO.x, 0.17, 1e-12);
}

}  // namespace
}  // namespace sinew::runtime
