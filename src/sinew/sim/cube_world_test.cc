#include "sinew/sim/cube_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using Kind = CubeEvent::Kind;

constexpr double kEdge = 0.025;

/// A hand that points down, over a world of its own.
struct Cell {
  explicit Cell(const CubeWorldSettings& settings = {}) : world(settings) {}

  Pose<frame::World, frame::Tip> pose() const {
    return {rotation_z(yaw) * rotation_y(tilt) * rotation_x(kPi), tip};
  }
  void tell(Duration time = 500ms) {
    now += time;
    if (is_cup) {
      world.advance(now, {pose(), CupTruth{0.008, 0.04, pump}});
    } else {
      world.advance(now, {pose(), JawTruth{width, {0.007, 0.006, 0.03}}});
    }
  }
  void go(const Vec3& to) {
    tip = to;
    tell();
  }
  void open(double to) {
    width = to;
    tell();
  }
  void suck(bool on) {
    pump = on;
    tell();
  }
  const CubeState& cube(std::size_t i) const { return world.cubes()[i]; }
  Vec3 at(std::size_t i) const { return cube(i).X_WO.p; }
  double yaw_of(std::size_t i) const {
    return std::remainder(std::atan2(cube(i).X_WO.R.x.y, cube(i).X_WO.R.x.x), kPi / 2);
  }
  long count(Kind kind) const { return std::ranges::count(world.events(), kind, &CubeEvent::kind); }

  CubeWorld world;
  Instant now{};
  Vec3 tip{0, 0, 0.2};
  double yaw = 0;
  double tilt = 0;
  double width = 0.05;
  bool is_cup = false;
  bool pump = false;
};

CubeWorldSettings with_basket() {
  CubeWorldSettings settings;
  settings.baskets = {Basket{{rotation_z(0.3), {0.2, 0, 0}}}};
  return settings;
}

TEST(CubeWorld, grasp_lift_carry_and_release_into_the_basket) {
  Cell cell(with_basket());
  cell.world.add({.edge = kEdge, .at = {0.01, 0.02}});
  cell.go({0.01, 0.02, 0.1});
  cell.go({0.01, 0.02, 0.008});
  EXPECT_EQ(cell.world.blocked_width(), kEdge);
  EXPECT_EQ(cell.cube(0).where, CubePlace::kTable);
  cell.open(kEdge);
  ASSERT_EQ(cell.cube(0).where, CubePlace::kHeld);
  EXPECT_NEAR(cell.world.held_mass(), 600 * kEdge * kEdge * kEdge, 1e-12);
  cell.go({0.01, 0.02, 0.1});
  EXPECT_NEAR(cell.at(0).z, kEdge / 2 + 0.092, 1e-9) << "it is lifted as far as the hand";
  cell.go({0.2, 0, 0.1});
  cell.go({0.2, 0, 0.03});
  cell.open(0.05);
  EXPECT_EQ(cell.cube(0).where, CubePlace::kBasket);
  EXPECT_NEAR(cell.at(0).z, 0.003 + kEdge / 2, 1e-9) << "on its floor";
  EXPECT_EQ(cell.world.held_mass(), 0);
  EXPECT_EQ(cell.count(Kind::kGrasped), 1);
  EXPECT_EQ(cell.count(Kind::kReleased), 1);
  EXPECT_EQ(cell.count(Kind::kDropped), 1);
  EXPECT_EQ(cell.world.events().size(), 3U) << "and nothing else happened";
}

TEST(CubeWorld, jaws_that_close_beside_a_cube_take_nothing) {
  Cell cell;
  cell.world.add({.edge = kEdge, .at = {0, 0.06}});
  cell.go({0, 0, 0.008});
  EXPECT_FALSE(cell.world.blocked_width());
  cell.open(0);
  cell.go({0, 0, 0.1});
  EXPECT_EQ(cell.cube(0).where, CubePlace::kTable);
  EXPECT_EQ(cell.at(0).y, 0.06);
  EXPECT_TRUE(cell.world.events().empty());
}

TEST(CubeWorld, closing_jaws_centre_and_align_what_is_off) {
  Cell cell;
  cell.world.add({.edge = kEdge, .at = {0.002, 0.005}, .yaw = from_deg(20)});
  cell.yaw = 0.4;
  cell.go({0, 0, 0.008});
  cell.open(0.033);
  EXPECT_GT(std::abs(cell.yaw_of(0) - 0.4), 0.03) << "not touched from both sides yet";
  cell.open(kEdge);
  ASSERT_EQ(cell.cube(0).where, CubePlace::kHeld);
  EXPECT_NEAR(cell.yaw_of(0), 0.4, 1e-9);
  const Vec3 p_TO = cell.pose().inverse() * cell.at(0);
  EXPECT_NEAR(p_TO.y, 0, 1e-9);
  EXPECT_NEAR(p_TO.x, 0.002 * std::cos(0.4) + 0.005 * std::sin(0.4), 1e-3) << "along the faces";
}

TEST(CubeWorld, a_cube_across_a_corner_slips_out) {
  Cell cell;
  cell.world.add({.edge = kEdge, .at = {0.001, 0}, .yaw = from_deg(40)});
  cell.go({0, 0, 0.008});
  EXPECT_FALSE(cell.world.blocked_width());
  cell.open(0.02);
  EXPECT_EQ(cell.cube(0).where, CubePlace::kTable);
  EXPECT_EQ(cell.count(Kind::kSlipped), 1);
  EXPECT_EQ(cell.count(Kind::kGrasped), 0);
  EXPECT_GT(cell.at(0).x, 0.007 + kEdge / 2) << "beside the fingers";
}

TEST(CubeWorld, a_finger_s_edge_does_not_hold) {
  Cell cell;
  cell.world.add({.edge = kEdge, .at = {0.0175, 0}});
  cell.go({0, 0, 0.008});
  cell.open(0.02);
  EXPECT_EQ(cell.count(Kind::kSlipped), 1);
  EXPECT_GT(cell.at(0).x, 0.007 + kEdge / 2);
}

TEST(CubeWorld, fingers_hold_what_they_overlap_by_4_mm_and_no_less) {
  for (const double tip : {kEdge - 0.0035, kEdge - 0.0045}) {
    Cell cell;
    cell.world.add({.edge = kEdge});
    cell.go({0, 0, tip});
    EXPECT_EQ(cell.world.blocked_width(), kEdge) << "it stops the jaws all the same";
    cell.open(kEdge);
    cell.go({0, 0, 0.1});
    EXPECT_EQ(cell.cube(0).where == CubePlace::kHeld, tip < kEdge - 0.004);
  }
}

TEST(CubeWorld, tilted_along_the_jaws_plane_it_holds_and_across_it_does_not) {
  Cell along;
  along.world.add({.edge = kEdge});
  along.tilt = from_deg(25);
  along.go({0, 0, 0.01});
  along.open(kEdge);
  EXPECT_EQ(along.cube(0).where, CubePlace::kHeld);
  along.go({0, 0, 0.02});
  along.tilt = from_deg(65);
  along.tell();
  along.open(0.05);
  EXPECT_EQ(along.cube(0).where, CubePlace::kTable) << "it ends flat";
  EXPECT_NEAR(along.cube(0).X_WO.R.z.z, 1, 1e-12);
}

TEST(CubeWorld, fingers_from_the_side_push_a_chain) {
  Cell cell;
  cell.go({-0.2, 0, 0.01});
  cell.open(0);
  for (const double x : {0.0, 0.03, 0.06}) cell.world.add({.edge = kEdge, .at = {x, 0}});
  cell.go({-0.01, 0, 0.01});
  const double first = 0.007 + kEdge / 2;
  EXPECT_NEAR(cell.at(0).x, first - 0.01, 1e-6);
  EXPECT_NEAR(cell.at(1).x, first - 0.01 + kEdge, 1e-6);
  EXPECT_NEAR(cell.at(2).x, 0.06, 1e-9) << "not reached yet";
  cell.go({0.05, 0, 0.01});
  EXPECT_NEAR(cell.at(2).x, 0.05 + first + 2 * kEdge, 1e-6);
  EXPECT_EQ(cell.count(Kind::kPushed), 3);
  EXPECT_EQ(cell.count(Kind::kCrash), 0);
}

TEST(CubeWorld, a_held_cube_pushes_others) {
  Cell cell;
  cell.world.add({.edge = kEdge});
  cell.world.add({.edge = kEdge, .at = {0.06, 0.003}});
  cell.go({0, 0, 0.01});
  cell.open(kEdge);
  cell.go({0.05, 0, 0.012});
  EXPECT_EQ(cell.cube(0).where, CubePlace::kHeld);
  EXPECT_NEAR(cell.at(1).x, 0.05 + kEdge, 1e-6);
  EXPECT_EQ(cell.count(Kind::kPushed), 1);
}

TEST(CubeWorld, what_comes_from_above_crashes_once) {
  Cell cell;
  cell.world.add({.edge = kEdge});
  cell.open(0);
  cell.go({0, 0, 0.022});
  EXPECT_EQ(cell.count(Kind::kCrash), 1);
  EXPECT_EQ(cell.world.events().back().cube, 0U);
  EXPECT_EQ(cell.at(0), (Vec3{0, 0, kEdge / 2})) << "it does not go anywhere";
  cell.go({0, 0, 0.1});
  cell.go({0.2, 0, 0.1});
  EXPECT_EQ(cell.count(Kind::kCrash), 1);
  cell.go({0.2, 0, -0.003});
  EXPECT_EQ(cell.count(Kind::kCrash), 2);
  EXPECT_FALSE(cell.world.events().back().cube) << "that was the table";
}

TEST(CubeWorld, fingers_that_are_too_narrow_do_not_take_a_cube_by_driving_into_it) {
  Cell cell;
  cell.world.add({.edge = 0.03});
  cell.open(0.02);
  cell.go({0, 0, 0.005});
  EXPECT_GE(cell.count(Kind::kCrash), 1);
  EXPECT_EQ(cell.count(Kind::kGrasped), 0);
  EXPECT_NE(cell.cube(0).where, CubePlace::kHeld);
}

TEST(CubeWorld, stacks_stand_and_the_upper_one_falls_when_the_lower_one_goes) {
  Cell cell;
  cell.world.add({.edge = kEdge});
  cell.world.add({.edge = kEdge, .at = {0.004, 0}, .bottom = 0.05});
  EXPECT_EQ(cell.cube(1).where, CubePlace::kOnCube);
  EXPECT_EQ(cell.cube(1).on, 0U);
  EXPECT_NEAR(cell.at(1).z, 1.5 * kEdge, 1e-9);
  cell.world.take_away(0);
  EXPECT_EQ(cell.cube(0).where, CubePlace::kGone);
  EXPECT_EQ(cell.cube(1).where, CubePlace::kTable);
  EXPECT_NEAR(cell.at(1).z, kEdge / 2, 1e-9);
  EXPECT_EQ(cell.count(Kind::kDropped), 1);
}

TEST(CubeWorld, the_lower_one_drawn_away_lets_the_upper_one_tip_beside_it) {
  Cell cell;
  cell.world.add({.edge = kEdge});
  cell.world.add({.edge = kEdge, .bottom = kEdge});
  cell.tilt = -kPi / 2;
  cell.go({-0.1, 0, kEdge / 2});
  cell.go({0.008, 0, kEdge / 2});
  cell.open(kEdge);
  ASSERT_EQ(cell.cube(0).where, CubePlace::kHeld);
  cell.go({-0.002, 0, kEdge / 2});
  EXPECT_EQ(cell.cube(1).where, CubePlace::kOnCube) << "its middle is still over the lower one";
  cell.go({-0.008, 0, kEdge / 2});
  EXPECT_EQ(cell.count(Kind::kTipped), 1);
  EXPECT_EQ(cell.cube(1).where, CubePlace::kTable);
  EXPECT_NEAR(cell.at(1).z, kEdge / 2, 1e-9);
  EXPECT_GT(cell.at(1).x - cell.at(0).x, kEdge - 1e-6) << "side by side";
  EXPECT_EQ(cell.count(Kind::kCrash), 0);
}

TEST(CubeWorld, a_cube_is_set_down_on_another_one_and_both_are_lifted_together) {
  Cell cell;
  cell.world.add({.edge = kEdge, .at = {0, -0.1}});
  cell.world.add({.edge = kEdge, .at = {0, 0.1}});
  cell.go({0, -0.1, 0.1});
  cell.go({0, -0.1, 0.01});
  cell.open(kEdge);
  cell.go({0, -0.1, 0.1});
  cell.go({0, 0.1, 0.1});
  cell.go({0, 0.1, 0.01 + kEdge + 0.0005});
  cell.open(0.03);
  EXPECT_EQ(cell.cube(0).on, 1U);
  EXPECT_EQ(cell.count(Kind::kCrash), 0);
  EXPECT_EQ(cell.count(Kind::kTipped), 0);
  cell.go({0, 0.1, 0.01});
  cell.open(kEdge);
  cell.go({0, 0.1, 0.06});
  EXPECT_EQ(cell.cube(0).where, CubePlace::kHeld);
  EXPECT_EQ(cell.cube(1).where, CubePlace::kHeld);
  EXPECT_NEAR(cell.at(0).z - cell.at(1).z, kEdge, 1e-6);
}

TEST(CubeWorld, set_down_over_an_edge_it_tips_off) {
  Cell cell;
  cell.world.add({.edge = kEdge});
  cell.world.add({.edge = kEdge, .at = {0.016, 0}, .bottom = 0.026});
  EXPECT_EQ(cell.cube(1).where, CubePlace::kTable);
  EXPECT_GT(cell.at(1).x, kEdge - 0.002);
  EXPECT_NEAR(cell.at(1).z, kEdge / 2, 1e-9);
}

TEST(CubeWorld, a_bridge_rests_on_both) {
  Cell cell;
  cell.world.add({.edge = kEdge, .at = {-0.018, 0}});
  cell.world.add({.edge = kEdge, .at = {0.018, 0}});
  cell.world.add({.edge = kEdge, .bottom = kEdge});
  EXPECT_NEAR(cell.at(2).z, 1.5 * kEdge, 1e-9);
  cell.world.take_away(0);
  EXPECT_NEAR(cell.at(2).z, kEdge / 2, 1e-9) << "one of them alone is too far aside";
}

TEST(CubeWorld, a_cup_takes_what_it_stands_flat_on_while_the_pump_runs) {
  for (const bool pump : {false, true}) {
    Cell cell;
    cell.is_cup = true;
    cell.world.add({.edge = kEdge, .at = {0.003, 0}});
    cell.go({0, 0, 0.05});
    cell.go({0, 0, kEdge + 0.001});
    cell.suck(pump);
    cell.go({0, 0, 0.05});
    EXPECT_EQ(cell.cube(0).where == CubePlace::kHeld, pump);
    if (!pump) continue;
    EXPECT_NEAR(cell.at(0).z, 0.05 - kEdge / 2, 1e-9);
    cell.go({0.1, 0, 0.03});
    cell.suck(false);
    EXPECT_EQ(cell.cube(0).where, CubePlace::kTable);
    EXPECT_NEAR(cell.at(0).x, 0.103, 1e-9);
    EXPECT_EQ(cell.count(Kind::kCrash), 0);
  }
}

TEST(CubeWorld, a_cup_over_an_edge_aslant_or_too_high_takes_nothing) {
  const auto taken = [](double aside, double tilt, double above) {
    Cell cell;
    cell.is_cup = true;
    cell.pump = true;
    cell.tilt = tilt;
    cell.world.add({.edge = kEdge, .at = {aside, 0}});
    cell.go({0, 0, 0.05});
    cell.go({0, 0, kEdge + above});
    cell.go({0, 0, 0.06});
    return cell.cube(0).where == CubePlace::kHeld;
  };
  EXPECT_TRUE(taken(0.004, 0, 0.0015));
  EXPECT_FALSE(taken(0.006, 0, 0.0015)) << "air gets in";
  EXPECT_TRUE(taken(0.002, from_deg(4), 0.0015));
  EXPECT_FALSE(taken(0.002, from_deg(6), 0.0015));
  EXPECT_FALSE(taken(0.002, 0, 0.0025));
}

TEST(CubeWorld, high_drops_bounce_as_the_seed_says) {
  const auto dropped = [](std::uint64_t seed, double height) {
    CubeWorldSettings settings;
    settings.seed = seed;
    Cell cell(settings);
    cell.world.add({.edge = kEdge});
    cell.go({0, 0, 0.01});
    cell.open(kEdge);
    cell.go({0, 0, 0.01 + height});
    cell.open(0.05);
    return cell.at(0);
  };
  EXPECT_NEAR(dropped(1, 0.05).x, 0, 1e-9);
  EXPECT_GT(norm(dropped(1, 0.1) - dropped(1, 0.01)), 0.005);
  EXPECT_LT(norm(dropped(1, 0.1) - dropped(1, 0.01)), 0.06);
  EXPECT_EQ(dropped(1, 0.1), dropped(1, 0.1));
  EXPECT_NE(dropped(1, 0.1), dropped(2, 0.1));
}

TEST(CubeWorld, released_in_flight_it_is_thrown) {
  Cell cell;
  cell.world.add({.edge = kEdge});
  cell.go({0, 0, 0.01});
  cell.open(kEdge);
  cell.go({0, 0, 0.05});
  cell.tip = {0.02, 0, 0.05};
  cell.width = 0.05;
  cell.tell(20ms);
  EXPECT_EQ(cell.count(Kind::kThrown), 1);
  EXPECT_NEAR(cell.world.events()[cell.world.events().size() - 2].amount, 1, 0.01);
  EXPECT_GT(cell.at(0).x, 0.08);
}

TEST(CubeWorld, pushed_over_the_table_s_edge_it_is_gone) {
  CubeWorldSettings settings;
  settings.table_half = {0.1, 0.1};
  Cell cell(settings);
  cell.world.add({.edge = kEdge, .at = {0.08, 0}});
  cell.go({0, 0, 0.01});
  cell.open(0);
  cell.go({0.12, 0, 0.01});
  EXPECT_EQ(cell.cube(0).where, CubePlace::kGone);
  EXPECT_EQ(cell.count(Kind::kFell), 1);
}

TEST(CubeWorld, the_basket_s_walls_stop_cubes_and_crash_into_hands) {
  Cell cell(with_basket());
  cell.world.add({.edge = kEdge, .at = {0.08, 0}});
  cell.go({0, 0, 0.01});
  cell.open(0);
  cell.go({0.1, 0, 0.01});
  const Vec3 p_K = cell.world.settings().baskets[0].X_WK.inverse() * cell.at(0);
  EXPECT_LT(p_K.x, -0.063 - kEdge / 2 + 1e-3) << "it stays outside";
  cell.go({0.1, 0, 0.1});
  EXPECT_EQ(cell.count(Kind::kCrash), 0);
  cell.go({0.137, 0, 0.1});
  cell.go({0.137, 0, 0.03});
  EXPECT_EQ(cell.count(Kind::kCrash), 1);
}

TEST(CubeWorld, a_basket_that_is_moved_takes_its_cubes_along_and_catches_those_below) {
  CubeWorldSettings settings = with_basket();
  settings.baskets.push_back({{Rotation{}, {-0.2, 0, 0}}});
  Cell cell(settings);
  const std::size_t inside = cell.world.add({.edge = kEdge, .at = {0.21, 0.02}, .bottom = 0.06});
  const std::size_t outside = cell.world.add({.edge = kEdge, .at = {0.0, 0.3}});
  const std::size_t far = cell.world.add({.edge = kEdge, .at = {0.3, -0.3}});
  ASSERT_EQ(cell.cube(inside).where, CubePlace::kBasket);
  const auto& baskets = cell.world.settings().baskets;
  const Vec3 before = baskets[0].X_WK.inverse() * cell.at(inside);
  const Vec3 p_far = cell.at(far);
  cell.world.move_basket(0, {rotation_z(1.1), {0.01, 0.31, 0}});
  EXPECT_EQ(cell.cube(inside).where, CubePlace::kBasket);
  const Vec3 after = baskets[0].X_WK.inverse() * cell.at(inside);
  EXPECT_NEAR(after.x, before.x, 1e-9);
  EXPECT_NEAR(after.y, before.y, 1e-9);
  EXPECT_EQ(cell.cube(outside).where, CubePlace::kBasket);
  EXPECT_GE(cell.at(outside).z, 0.003 + kEdge / 2 - 1e-9) << "on its floor, or on the other cube";
  EXPECT_EQ(cell.at(far), p_far);
  EXPECT_EQ(cell.cube(far).where, CubePlace::kTable);
  EXPECT_EQ(baskets[1].X_WK.p.x, -0.2);
}

TEST(CubeWorld, many_cubes_in_the_basket_lie_in_it_and_not_in_each_other) {
  Cell cell(with_basket());
  for (int i = 0; i < 12; ++i) {
    const auto k = static_cast<double>(i);
    const PlanPoint at{0.2 + 0.03 * std::sin(5 * k), 0.03 * std::cos(3 * k)};
    cell.world.add({.edge = kEdge, .at = at, .yaw = k, .bottom = 0.1});
  }
  double most = 0;
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(cell.cube(i).where, CubePlace::kBasket) << i;
    most = std::max(most, cell.at(i).z);
  }
  EXPECT_LT(most, 0.003 + 3.5 * kEdge + 1e-6) << "there is room for three layers";
}

TEST(CubeWorld, random_places_are_free_and_the_seed_s) {
  const auto places = [](std::uint64_t seed) {
    CubeWorldSettings settings = with_basket();
    settings.seed = seed;
    CubeWorld world(settings);
    for (int i = 0; i < 15; ++i) world.add_somewhere(kEdge, i, {0, 0}, {0.15, 0.15}, 0.01);
    std::vector<Vec3> found;
    for (const CubeState& cube : world.cubes()) found.push_back(cube.X_WO.p);
    return found;
  };
  const auto found = places(4);
  ASSERT_EQ(found.size(), 15U);
  EXPECT_EQ(found, places(4));
  EXPECT_NE(found, places(5));
  for (std::size_t i = 0; i < 15; ++i) {
    EXPECT_NEAR(found[i].z, kEdge / 2, 1e-12);
    for (std::size_t k = 0; k < i; ++k) EXPECT_GT(norm(found[i] - found[k]), kEdge + 0.01);
  }
}

TEST(CubeWorld, time_in_small_or_large_pieces_moves_the_same) {
  Cell whole;
  Cell pieces;
  for (Cell* cell : {&whole, &pieces}) {
    cell->world.add({.edge = kEdge, .at = {0.05, 0.004}, .yaw = 0.3});
    cell->world.add({.edge = kEdge, .at = {0.09, 0.01}, .yaw = 1});
    cell->go({0, 0, 0.01});
    cell->open(0);
  }
  whole.go({0.1, 0, 0.01});
  for (int i = 1; i <= 25; ++i) pieces.go({0.004 * i, 0, 0.01});
  for (std::size_t i = 0; i < 2; ++i) EXPECT_LT(norm(whole.at(i) - pieces.at(i)), 1e-9) << i;
}

TEST(CubeWorld, a_row_of_two_stops_the_jaws_at_both) {
  Cell cell;
  cell.width = 0.06;
  cell.world.add({.edge = kEdge, .at = {0, -0.013}});
  cell.world.add({.edge = kEdge, .at = {0, 0.013}});
  cell.go({0, 0, 0.01});
  EXPECT_EQ(cell.world.blocked_width(), 2 * kEdge);
  cell.open(2 * kEdge);
  cell.go({0, 0, 0.05});
  EXPECT_EQ(cell.cube(0).where, CubePlace::kHeld);
  EXPECT_EQ(cell.cube(1).where, CubePlace::kHeld);
}

}  // namespace
}  // namespace sinew::sim
