#include "cubes/reach.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/program/plans/cube_rows.h"
#include "support/property.h"
#include "support/robots.h"

/// The product's grasps against brute force, where all is seen as it is.
namespace sinew::cubes {
namespace {

constexpr double kEdge = 0.025;  // m
constexpr double kSlack = 1e-3;  // m, of brute force: the product has margins of its own

program::Basket usual_basket() {
  program::Basket basket;
  basket.name = "basket";
  basket.X_BK.p = {0.06, 0.18, 0};
  return basket;
}

std::vector<planning::PlacedBox> walls_of(const program::Basket& basket) {
  constexpr double kWall = 1.5e-3;  // m, half
  std::vector<planning::PlacedBox> walls;
  const double x = basket.size.x / 2, y = basket.size.y / 2, z = basket.size.z / 2;
  const auto add = [&](const Vec3& p_K, const Vec3& half) {
    walls.push_back({{basket.X_BK.R, basket.X_BK * p_K}, half});
  };
  add({0, 0, kWall}, {x, y, kWall});
  for (const double side : {1.0, -1.0}) {
    add({side * (x + kWall), 0, z}, {kWall, y + 2 * kWall, z});
    add({0, side * (y + kWall), z}, {x, kWall, z});
  }
  return walls;
}

/// 1 to 12 cubes, near enough to each other to be in the way.
std::vector<grasping::Cube> table_by(test::Random& random) {
  std::vector<grasping::Cube> cubes;
  const auto count = 1 + random.bits() % 12;
  for (int tries = 0; cubes.size() < count && tries < 500; ++tries) {
    const double reach = random.uniform(0.09, 0.26),
                 turn = random.uniform(-from_deg(40), from_deg(40));
    const Vec3 p{reach * std::cos(turn), reach * std::sin(turn), kEdge / 2};
    bool free = std::abs(p.x - 0.06) > 0.093 || std::abs(p.y - 0.18) > 0.093;
    for (const auto& cube : cubes) free = free && norm(cube.p_BO - p) > 1.42 * kEdge;
    if (free) cubes.push_back({p, random.uniform(0, kPi / 2), kEdge, 0});
  }
  return cubes;
}

TEST(Reach, what_brute_force_takes_can_be_planned) {
  const RobotModel& learm = test::robot("learm");
  const program::Basket basket = usual_basket();
  const auto walls = walls_of(basket);
  const program::Standing standing{
      JointVector{from_deg(-60), from_deg(20), from_deg(40), from_deg(40), 0},
      {.jaws = 0.06, .held = {}}};
  const program::Step row{1, program::PickCubeStep{}, 0};
  std::size_t takes = 0;
  test::for_random_cases(8, [&](test::Random& random) {
    const auto cubes = table_by(random);
    program::RowPlanner planner(learm);
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      if (!can_take(learm, cubes, walls, i, kSlack)) continue;
      ++takes;
      const auto rows =
          program::rows_to_cube(planner, standing, row, {.cubes = cubes}, i, std::span(&basket, 1));
      EXPECT_TRUE(rows) << fmt::format("cube {} at {:.0f}, {:.0f}: {}", i, 1e3 * cubes[i].p_BO.x,
                                       1e3 * cubes[i].p_BO.y,
                                       rows ? "" : describe(rows.error().error));
    }
  });
  EXPECT_GT(takes, 10U);
}

}  // namespace
}  // namespace sinew::cubes
