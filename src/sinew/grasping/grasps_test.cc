#include "sinew/grasping/grasps.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/rotation.h"
#include "sinew/core/split_mix.h"
#include "sinew/core/units.h"
#include "sinew/model/tool_state.h"
#include "support/robots.h"

namespace sinew::grasping {
namespace {

constexpr double kEdge = 25e-3;

Cube cube_at(double x, double y, double yaw = 0, int level = 1) {
  return {{x, y, kEdge * (level - 0.5)}, yaw, kEdge, 0};
}

/// Whether a point is inside of a box.
bool holds(const Body& body, const Vec3& p) {
  const Vec3 d = p - body.p_BO;
  const double c = std::cos(body.yaw), s = std::sin(body.yaw);
  return std::abs(c * d.x + s * d.y) < body.half.x && std::abs(-s * d.x + c * d.y) < body.half.y &&
         std::abs(d.z) < body.half.z;
}

/// Something longer or wider than a cube, and lower or as high.
Body body_by(SplitMix64& random, double x, double y) {
  const Vec3 half{random.uniform(0.01, 0.03), random.uniform(0.005, 0.015),
                  random.uniform(0.006, kEdge / 2)};
  return {{x, y, half.z}, random.uniform(0, kPi), half};
}

/// R_BT of a grasp, and the tips of its jaws at another width.
Rotation turned(const JawGrasp& grasp) {
  const double yaw = std::atan2(grasp.p_BT.y, grasp.p_BT.x);
  return rotation_from_fixed_xyz({0, 0, yaw}) * rotation_from_fixed_xyz({0, grasp.pitch, 0}) *
         rotation_from_fixed_xyz({0, 0, grasp.roll});
}
Vec3 tips(const JawGrasp& grasp, const JawGripper& gripper, double width) {
  const double ahead = jaw_reach(gripper, width) - jaw_reach(gripper, grasp.open);
  return grasp.p_BT + turned(grasp) * Vec3{0, 0, ahead};
}

/// What of all bodies the fingers are in at a width, by points of their boxes, `dz` above the
/// grasp.
int touched(const JawGrasp& grasp, const JawGripper& gripper, std::span<const Body> bodies,
            std::size_t held, double width, double dz) {
  const Rotation R = turned(grasp);
  const Vec3 end = tips(grasp, gripper, width) + Vec3{0, 0, dz};
  int count = 0;
  for (const double side : {-1.0, 1.0}) {
    for (int i = 0; i <= 6; ++i) {
      for (int j = 0; j <= 6; ++j) {
        for (int k = 0; k <= 10; ++k) {
          const Vec3 p_T{7e-3 * (i / 3.0 - 1), side * (width / 2 + 12e-3 * j / 6.0),
                         -60e-3 * k / 10.0};
          const Vec3 p = end + R * p_T;
          count += p.z < 0 ? 1 : 0;
          for (std::size_t c = 0; c < bodies.size(); ++c) {
            // Closing jaws touch the held one on purpose.
            if (c == held && width < grasp.open) continue;
            count += holds(bodies[c], p) ? 1 : 0;
          }
        }
      }
    }
  }
  return count;
}

TEST(Grasps, fingers_touch_nothing_but_their_cube_on_any_table) {
  const RobotModel robot = test::robot("learm");
  const JawGripper& gripper = *std::get<SerialGeometry>(robot.geometry).gripper;
  std::size_t found = 0, crowded = 0, beside = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    SplitMix64 random(seed);
    std::vector<Cube> cubes;
    std::vector<Body> others;
    for (int tries = 0; tries < 60 && cubes.size() < 12; ++tries) {
      Cube cube = cube_at(random.uniform(0.13, 0.26), random.uniform(-0.1, 0.1),
                          random.uniform(0, kPi / 2));
      bool free = true;
      for (const Cube& other : cubes) {
        const Vec3 d = other.p_BO - cube.p_BO;
        free = free && std::hypot(d.x, d.y) > kEdge * 1.42;
      }
      for (const Body& other : others) {
        free = free && norm(other.p_BO - cube.p_BO) > kEdge / 2 + norm(other.half);
      }
      if (!free) continue;
      cubes.push_back(cube);
      if (tries % 3 == 0) {
        const double turn = random.uniform(0, 2 * kPi);
        const Body body = body_by(random, cube.p_BO.x + 0.04 * std::cos(turn),
                                  cube.p_BO.y + 0.04 * std::sin(turn));
        const auto apart = [&](const Cube& one) {
          return norm(one.p_BO - body.p_BO) > kEdge / 2 + norm(body.half);
        };
        if (std::ranges::all_of(cubes, apart)) others.push_back(body);
      }
    }
    std::vector<Body> bodies(cubes.size());
    std::ranges::transform(cubes, bodies.begin(), body_of);
    bodies.insert(bodies.end(), others.begin(), others.end());
    beside += others.size();
    for (std::size_t which = 0; which < cubes.size(); ++which) {
      const auto grasps = jaw_grasps(robot, cubes, which, others);
      if (!grasps) {
        EXPECT_EQ(grasps.error().code, ErrorCode::kCubeCrowded);
        EXPECT_LT(grasps.error().measured, grasps.error().limit);
        ++crowded;
        continue;
      }
      ++found;
      constexpr std::size_t kEach = 5;  // they are many, and alike in threes and eights
      for (std::size_t g = 0; g < grasps->size(); g += kEach) {
        const JawGrasp& grasp = (*grasps)[g];
        for (const double dz : {0.0, 5e-3, 15e-3, 40e-3}) {
          EXPECT_EQ(touched(grasp, gripper, bodies, which, grasp.open, dz), 0)
              << "seed " << seed << ", cube " << which << ", pitch " << to_deg(grasp.pitch);
        }
        for (double width = grasp.open; width > kEdge; width -= 2e-3) {
          EXPECT_EQ(touched(grasp, gripper, bodies, which, width, 0), 0)
              << "seed " << seed << ", cube " << which << ", width " << to_mm(width);
        }
      }
    }
  }
  EXPECT_GT(found, 50U);
  EXPECT_GT(crowded, 3U);
  EXPECT_GT(beside, 10U);
}

TEST(Grasps, jaws_close_along_a_pair_of_faces_with_the_cube_between_them) {
  const RobotModel robot = test::robot("learm");
  const JawGripper& gripper = *std::get<SerialGeometry>(robot.geometry).gripper;
  for (const double yaw_deg : {0.0, 17.0, 45.0, 80.0}) {
    const std::vector<Cube> cubes{cube_at(0.18, 0.05, from_deg(yaw_deg))};
    const auto grasps = jaw_grasps(robot, cubes, 0);
    ASSERT_TRUE(grasps);
    EXPECT_EQ(grasps->front().pitch, kPi);
    EXPECT_NEAR(grasps->front().open, kEdge + 2 * 8e-3, 1e-9) << "8 mm beside each face";
    for (const JawGrasp& grasp : *grasps) {
      EXPECT_LE(std::abs(grasp.roll), kPi / 2 + 1e-9);
      const Vec3 across = turned(grasp) * Vec3{0, 1, 0};
      const double angle = std::atan2(across.y, across.x) - from_deg(yaw_deg);
      EXPECT_NEAR(std::sin(2 * angle), 0, 2e-2) << "off only by the offset of the tips' plane";
      const Vec3 at = tips(grasp, gripper, grasp.close) - cubes[0].p_BO;
      EXPECT_NEAR(std::hypot(at.x, at.y), 0, 1e-3);
      EXPECT_LT(at.z, kEdge / 2 - 4.9e-3);
      EXPECT_GT(at.z, -kEdge / 2 + 4.99e-3);
      EXPECT_LT(grasp.close, kEdge);
    }
  }
}

TEST(Grasps, a_cube_that_cannot_be_had_says_why) {
  const RobotModel robot = test::robot("learm");
  const auto refusal = [&](const std::vector<Cube>& cubes) {
    const auto grasps = jaw_grasps(robot, cubes, 0);
    return grasps ? Error{ErrorCode::kBusy} : grasps.error();
  };
  const Error covered = refusal({cube_at(0.2, 0), cube_at(0.2, 0.003, 0.3, 2)});
  EXPECT_EQ(covered.code, ErrorCode::kCubeCovered);
  // 10 mm on all sides, of which 3 stay clear.
  const double next = kEdge + 10e-3;
  const Error crowded = refusal({cube_at(0.2, 0), cube_at(0.2 + next, 0), cube_at(0.2 - next, 0),
                                 cube_at(0.2, next), cube_at(0.2, -next)});
  EXPECT_EQ(crowded.code, ErrorCode::kCubeCrowded);
  EXPECT_NEAR(crowded.measured, 7e-3, 1e-4);
  EXPECT_NEAR(crowded.limit, 15e-3, 1e-9);
  // Neighbours on one pair of faces leave the other pair.
  EXPECT_EQ(refusal({cube_at(0.2, 0), cube_at(0.2, kEdge), cube_at(0.2, -kEdge)}).code,
            ErrorCode::kBusy);
  const Error wide = refusal({{{0.2, 0, 0.03}, 0, 0.06, 0}});
  EXPECT_EQ(wide.code, ErrorCode::kCubeTooWide);
  EXPECT_NEAR(wide.limit, 0.054, 1e-9);
}

TEST(Grasps, upper_ones_come_first_then_the_nearest) {
  const std::vector<Cube> cubes{cube_at(0.15, 0), cube_at(0.25, 0), cube_at(0.2, 0.02),
                                cube_at(0.15, 0.002, 0.5, 2)};
  EXPECT_EQ(order_of(cubes), (std::vector<std::size_t>{3, 2, 1, 0}));
}

TEST(Grasps, a_cup_takes_the_middle_of_a_top_that_it_can_get_at) {
  std::vector<Cube> cubes{cube_at(0.2, 0)};
  const auto lip = cup_grasp(cubes, 0);
  ASSERT_TRUE(lip);
  EXPECT_EQ(*lip, (Vec3{0.2, 0, kEdge}));
  cubes.push_back(cube_at(0.2 + kEdge + 2e-3, 0, 0, 1));
  EXPECT_TRUE(cup_grasp(cubes, 0)) << "as high as it is";
  cubes.push_back(cube_at(0.2 + kEdge + 3e-3, 0, 0, 2));
  EXPECT_TRUE(cup_grasp(cubes, 0)) << "3.5 mm beside the cup";
  cubes[1].p_BO.x += 1e-3;
  cubes[2].p_BO.x -= 2e-3;
  ASSERT_FALSE(cup_grasp(cubes, 0));
  EXPECT_EQ(cup_grasp(cubes, 0).error().code, ErrorCode::kCubeCrowded);
  EXPECT_EQ(cup_grasp(cubes, 1).error().code, ErrorCode::kCubeCovered);
}

}  // namespace
}  // namespace sinew::grasping
