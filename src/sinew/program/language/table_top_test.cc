#include "sinew/program/language/table_top.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "sinew/core/error_code.h"
#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/foresight.h"
#include "sinew/program/plans/program_check.h"
#include "sinew/program/runs/plain_cell_test_support.h"

/// Programs that name baskets and cameras of their cell, and what is foreseen of them.
namespace sinew::program {
namespace {

constexpr double kEdge = 25e-3;

Basket tray(const std::string& name = "tray", const Vec3& p_BK = {0.06, 0.18, 0}) {
  return {name, {rotation_z(0.3), p_BK}, {0.11, 0.11, 0.05}};
}

grasping::Cube cube_at(double x, double y, vision::ColorName color) {
  return {{x, y, kEdge / 2}, 0.3, kEdge, static_cast<int>(color)};
}

TableTop table_with(std::vector<Basket> baskets, std::optional<Sighting> seen = {}) {
  return {.baskets = std::move(baskets), .cameras = {"eye", "side"}, .seen = std::move(seen)};
}

std::expected<Program, std::vector<Complaint>> read_in(const TableTop& table, std::string_view text,
                                                       std::string_view robot = "learm") {
  return parse(text, "p.sinew", test::robot(robot),
               {.table = std::make_shared<const TableTop>(table), .load = {}});
}

std::string complaint(const TableTop& table, std::string_view text) {
  const auto program = read_in(table, text);
  return program ? "none" : to_text(program.error().front());
}

Standing ready() {
  return {JointVector{from_deg(-40), from_deg(20), from_deg(40), from_deg(40), 0},
          {.jaws = 0.06, .held = {}}};
}

TEST(TableTop, spots_lie_apart_inside_the_walls_and_full_ones_come_last) {
  const Basket basket = tray();
  const auto spots = spots_in(basket, kEdge, {});
  ASSERT_EQ(spots.size(), 4U);
  for (std::size_t i = 0; i < spots.size(); ++i) {
    EXPECT_LT(std::abs(spots[i].x) + kEdge / std::sqrt(2.0), 0.055);
    EXPECT_LT(std::abs(spots[i].y) + kEdge / std::sqrt(2.0), 0.055);
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_GT(norm(spots[i] - spots[k]), kEdge * std::sqrt(2.0));
    }
  }
  std::vector<Vec3> lying;
  for (int round = 0; round < 8; ++round) {
    const auto now = spots_in(basket, kEdge, lying);
    Vec3 there = spots[static_cast<std::size_t>(round) % 4];
    there.z = round / 4 * kEdge;
    EXPECT_EQ(now.front(), there) << round;
    lying.push_back(basket.X_BK * now.front());
  }
  // What lies beside the basket fills none of it.
  const Vec3 beside = basket.X_BK * Vec3{0.2, 0, 0};
  EXPECT_EQ(spots_in(basket, kEdge, std::vector<Vec3>{beside}).front(), spots.front());
  EXPECT_EQ(spots_in({"cup", {}, {0.03, 0.03, 0.05}}, kEdge, {}), std::vector<Vec3>{Vec3{}});
}

TEST(TableTop, a_stack_in_a_basket_counts_by_its_height_and_what_was_released_there_only_once) {
  const std::vector<Basket> baskets{tray()};
  const Vec3 p_B = baskets[0].X_BK * Vec3{0.02, 0.02, 0};
  const auto seen_on = [&](int level) {
    return std::vector<grasping::Cube>{
        {p_B + Vec3{0, 0, (level - 0.5) * kEdge}, 0, kEdge, static_cast<int>(0)}};
  };
  for (int level = 1; level <= 3; ++level) {
    EXPECT_EQ(lying_in(baskets, {}, seen_on(level)).size(), static_cast<std::size_t>(level));
    const std::vector<Vec3> two{p_B + Vec3{0, 0, 0.1}, p_B + Vec3{2e-3, 0, 0.1}};
    EXPECT_EQ(lying_in(baskets, two, seen_on(level)).size(), level == 3 ? 3U : 2U);
  }
  EXPECT_EQ(lying_in(baskets, std::vector<Vec3>{p_B, {}}, {}).size(), 2U);
}

TEST(TableTop, a_row_names_a_basket_and_complaints_name_those_that_there_are) {
  const TableTop one = table_with({tray()});
  for (const char* text : {"place basket", "place tray", "place to=tray speed=50%"}) {
    const auto program = read_in(one, text);
    ASSERT_TRUE(program) << text << ": " << to_text(program.error().front());
    EXPECT_TRUE(uses_baskets(*program));
    EXPECT_TRUE(handles_cubes(*program));
  }
  const TableTop two = table_with({tray("reds"), tray("blues", {0.1, -0.2, 0})});
  EXPECT_EQ(complaint(two, "place basket"),
            "p.sinew:1:7: 'basket': this cell has several baskets; name one of reds blues");
  EXPECT_EQ(complaint(two, "place greens"),
            "p.sinew:1:7: 'greens' is no basket of this cell and no taught point; its baskets are "
            "reds blues");
  EXPECT_NE(complaint(table_with({}), "place basket").find("write the lines [basket]"),
            std::string::npos);
  EXPECT_EQ(complaint(one, "place tray blend=5mm"),
            "p.sinew:1:1: place stops where it releases: without blend= and time=");
  EXPECT_EQ(complaint(one, "look side"), "none");
  EXPECT_EQ(complaint(one, "look top"),
            "p.sinew:1:6: 'top' is no calibrated camera of this cell; there are eye side");
}

TEST(TableTop, a_taught_point_of_the_same_name_comes_first) {
  const TaughtPoints points{{.name = "tray",
                             .robot = "learm",
                             .place = JointVector{1, from_deg(25), from_deg(60), from_deg(55), 0},
                             .source = "here",
                             .taught_at = ""}};
  const auto program = parse("place tray", "p.sinew", test::robot("learm"),
                             {.points = &points,
                              .table = std::make_shared<const TableTop>(table_with({tray()})),
                              .load = {}});
  ASSERT_TRUE(program);
  EXPECT_FALSE(uses_baskets(*program));
}

TEST(TableTop, a_program_is_checked_without_a_cell_and_does_not_run_without_one) {
  const auto program = parse("place basket", "p.sinew", test::robot("learm"));
  ASSERT_TRUE(program) << to_text(program.error().front());
  EXPECT_TRUE(check(*program, test::robot("learm"), ready()).fine());
  PlainCell cell("learm", "place basket\n");
  cell.go();
  ASSERT_EQ(cell.run.phase(), Phase::kFailed);
  EXPECT_EQ(cell.run.failure()->error.code, ErrorCode::kNoBasket);
  EXPECT_TRUE(cell.driver.taken_.empty());
}

TEST(TableTop, cubes_are_released_over_the_basket_above_its_rim) {
  const RobotModel& robot = test::robot("learm");
  RowPlanner planner(robot);
  const TableTop table = table_with({tray()});
  const auto program = read_in(table, "place basket");
  ASSERT_TRUE(program);
  Standing standing = ready();
  standing.tool = {.jaws = 0.021, .held = kEdge};
  std::vector<Vec3> lying;
  for (int round = 0; round < 4; ++round) {
    const auto rows = rows_to_place(planner, standing, program->steps[0], &table, lying);
    ASSERT_TRUE(rows) << describe(rows.error().error);
    const Vec3 p_K = table.baskets[0].X_BK.inverse() * rows->p_BO;
    EXPECT_LT(std::abs(p_K.x), 0.055 - kEdge / 2);
    EXPECT_LT(std::abs(p_K.y), 0.055 - kEdge / 2);
    EXPECT_GT(p_K.z, 0.05 + kEdge / 2);
    EXPECT_LT(p_K.z, 0.05 + 0.08);
    for (const Vec3& other : lying) EXPECT_GT(norm(other - rows->p_BO), kEdge);
    lying.push_back(rows->p_BO);
  }
}

TEST(TableTop, a_basket_out_of_reach_says_by_how_much) {
  const TableTop table = table_with({tray("tray", {0.5, 0, 0})});
  const auto program = read_in(table, "place tray");
  ASSERT_TRUE(program);
  const auto plan = make_plan(*program, test::robot("learm"), ready());
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().line, 1);
  EXPECT_EQ(plan.error().error.code, ErrorCode::kBasketOutOfReach);
  EXPECT_GT(excess(plan.error().error), 0.05);
  EXPECT_LT(excess(plan.error().error), 0.3);
}

constexpr const char* kSort = "repeat while seen\n  pick\n  place basket\nend\n";

Sighting three_cubes() {
  using vision::ColorName;
  return {.cubes = {cube_at(0.20, 0.02, ColorName::kRed), cube_at(0.14, -0.02, ColorName::kBlue),
                    cube_at(0.17, 0.06, ColorName::kRed)}};
}

TEST(Foresight, as_many_rounds_are_predicted_as_cubes_are_seen) {
  const RobotModel& robot = test::robot("learm");
  const auto unseen = make_plan(*read_in(table_with({tray()}), kSort), robot, ready());
  const auto seen = make_plan(*read_in(table_with({tray()}, three_cubes()), kSort), robot, ready());
  const auto reds = make_plan(
      *read_in(table_with({tray()}, three_cubes()),
               "repeat while seen color=red\n pick color=red\n place basket\nend\njoint base=0deg"),
      robot, ready());
  ASSERT_TRUE(unseen && seen && reds);
  EXPECT_NEAR(seen->duration / unseen->duration, 3.0 / kSeenRoundsMax, 0.01);
  EXPECT_NEAR(reds->duration / seen->duration, 2.0 / 3, 0.1);
  int expected = 0;
  for (const Order& order : seen->orders) {
    expected += order.expected && std::holds_alternative<PickOrder>(order.what) ? 1 : 0;
  }
  EXPECT_EQ(expected, 3);
  EXPECT_TRUE(reds->orders.back().expected) << "what comes behind the loop counts";
}

TEST(Foresight, cubes_are_picked_in_order_and_what_is_left_is_told) {
  const RobotModel& robot = test::robot("learm");
  Sighting seen = three_cubes();
  seen.cubes.push_back(cube_at(0.45, 0, vision::ColorName::kGreen));
  const auto program = read_in(table_with({tray()}, seen), kSort);
  ASSERT_TRUE(program);
  const auto plan = make_plan(*program, robot, ready());
  ASSERT_TRUE(plan) << describe(plan.error().error);
  RowPlanner planner(robot);
  std::vector<Vec3> picked, placed;
  const auto left = foresee(
      *plan, *program, planner, ready(), [&](const Foreseen& now) -> std::expected<void, Refusal> {
        EXPECT_EQ(now.why, nullptr);
        if (now.rows == nullptr) return {};
        const bool pick = std::holds_alternative<PickOrder>(now.order.what);
        (pick ? picked : placed).push_back(pick ? now.rows->cube.p_BO : now.rows->p_BO);
        return {};
      });
  ASSERT_TRUE(left);
  ASSERT_EQ(left->size(), 1U);
  EXPECT_EQ(left->front().color, static_cast<int>(vision::ColorName::kGreen));
  EXPECT_EQ(picked,
            (std::vector<Vec3>{seen.cubes[1].p_BO, seen.cubes[2].p_BO, seen.cubes[0].p_BO}));
  ASSERT_EQ(placed.size(), 3U);
  EXPECT_GT(norm(placed[0] - placed[1]), kEdge);
  EXPECT_GT(norm(placed[1] - placed[2]), kEdge);
}

TEST(Foresight, else_is_taken_where_no_such_cube_is_seen) {
  const RobotModel& robot = test::robot("learm");
  for (const bool blue : {true, false}) {
    Sighting seen{
        .cubes = {cube_at(0.14, -0.02, blue ? vision::ColorName::kBlue : vision::ColorName::kRed)}};
    const auto program =
        read_in(table_with({}, seen), "if seen color=blue\nwait 1s\nelse\nwait 2s\nend\nwait 3s");
    ASSERT_TRUE(program);
    const auto plan = make_plan(*program, robot, ready());
    ASSERT_TRUE(plan);
    RowPlanner planner(robot);
    std::vector<double> waits;
    const auto left = foresee(*plan, *program, planner, ready(),
                              [&](const Foreseen& now) -> std::expected<void, Refusal> {
                                const auto& wait = std::get<WaitOrder>(now.order.what);
                                waits.push_back(to_seconds(wait.duration));
                                return {};
                              });
    ASSERT_TRUE(left);
    EXPECT_EQ(waits, (blue ? std::vector<double>{1, 3} : std::vector<double>{2, 3}));
  }
}

TEST(Foresight, each_cube_has_its_verdict) {
  const RobotModel& robot = test::robot("learm");
  RowPlanner planner(robot);
  Sighting seen{.cubes = {cube_at(0.17, 0.06, vision::ColorName::kRed),
                          cube_at(0.45, 0, vision::ColorName::kGreen)}};
  // One with neighbours at all four sides, which leave less than a finger beside it.
  const Vec3 middle{0.19, -0.08, kEdge / 2};
  for (const auto& [dx, dy] :
       {std::pair{0.0, 0.0}, {0.028, 0.0}, {-0.028, 0.0}, {0.0, 0.028}, {0.0, -0.028}}) {
    seen.cubes.push_back({middle + Vec3{dx, dy, 0}, 0, kEdge, 0});
  }
  int crowded = 0;
  for (const CubeVerdict& verdict : judge_cubes(planner, ready(), seen)) {
    const Vec3& p = seen.cubes[verdict.which].p_BO;
    if (p.x == 0.17) {
      EXPECT_TRUE(verdict.rows);
    }
    if (p.x == 0.45) {
      ASSERT_FALSE(verdict.rows);
      EXPECT_EQ(verdict.rows.error().error.code, ErrorCode::kOutOfReach);
      EXPECT_FALSE(help_with_cube(ErrorCode::kOutOfReach).empty());
    }
    if (p == middle) {
      ++crowded;
      ASSERT_FALSE(verdict.rows);
      const Error& why = verdict.rows.error().error;
      EXPECT_EQ(why.code, ErrorCode::kCubeCrowded);
      EXPECT_LT(why.measured, why.limit);
    }
  }
  EXPECT_EQ(crowded, 1);
}

TEST(Foresight, a_cube_alone_can_be_taken_inside_a_ring) {
  const RobotModel& robot = test::robot("learm");
  RowPlanner planner(robot);
  const Standing home(home_joints(robot));
  const auto at = [&](double x, double y) {
    return best_grasp(planner, home, {x, y, kEdge / 2}, kEdge);
  };
  EXPECT_NE(at(0.17, 0.02), Grasp::kNone);
  EXPECT_NE(at(0.10, -0.14), Grasp::kNone);
  EXPECT_EQ(at(0.45, 0), Grasp::kNone);
  EXPECT_EQ(at(0.02, 0), Grasp::kNone);
  const RobotModel& max = test::robot("maxarm");
  RowPlanner cup(max);
  EXPECT_EQ(best_grasp(cup, Standing(home_joints(max)), {0.03, -0.21, kEdge / 2}, kEdge),
            Grasp::kStraightDown);
}

}  // namespace
}  // namespace sinew::program
