#include "sinew/server/api/demonstration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "sinew/config/builtin_robots.h"
#include "sinew/program/language/program_file.h"
#include "sinew/server/api/api_test_cell.h"

namespace sinew::server {
namespace {

using test::ApiCell;
using test::ApiClient;

TEST(Demonstration, every_robot_with_a_device_has_a_program_that_parses) {
  int programs = 0;
  for (const BuiltinRobot& builtin : builtin_robots()) {
    if (builtin.demonstration.empty()) continue;
    ++programs;
    const RobotModel& robot = sinew::test::robot(std::string(builtin.id));
    EXPECT_TRUE(program::parse(std::string(builtin.demonstration), "shown", robot)) << builtin.id;
  }
  EXPECT_EQ(programs, 5);
}

TEST(Demonstration, each_robot_is_shown_and_moves) {
  ApiCell cell({test::place("a", "learm", "bus"), test::place("m", "maxarm")});
  Demonstration shown(cell.api(), cell.cell());
  const auto truth = [&] { return cell.cell().station(0).view().truth; };
  ASSERT_TRUE(cell.until([&] { return truth() && !truth()->joints.empty(); }));
  const auto base = [&] { return truth()->joints[0].q; };
  double least = base(), most = base();
  EXPECT_TRUE(cell.until([&] {
    shown.poll(cell.now());
    least = std::min(least, base());
    most = std::max(most, base());
    return shown.shown();
  }));
  for (const Demonstration::Part& part : shown.parts()) {
    EXPECT_GT(part.rounds, 0) << part.robot << ": " << part.trouble;
  }
  EXPECT_GT(most - least, 1.0) << "rad of the base, both sides";
  shown.end();
  EXPECT_TRUE(shown.over());
}

/// A cube or two in front of a LeArm, a basket, and a camera above them.
Cell table_with(std::vector<CellCube> cubes) {
  Cell table;
  table.cameras.emplace_back();
  table.cameras[0].name = "eye";
  table.cameras[0].device = kSimulatedCamera;
  table.cameras[0].X_WT.p = {0.15, 0.04, 0};
  table.baskets.emplace_back();
  table.baskets[0].name = "tray";
  table.baskets[0].X_WK.p = {0.06, 0.18, 0};
  table.cubes = std::move(cubes);
  return table;
}

void open_camera(runtime::RunningCell& running) {
  const auto camera = runtime::usual_camera();
  const auto robots = [&running] {
    return running.robots_in_view(runtime::RunningCell::Stand::kTrue);
  };
  running.open_camera(0, {"eye", camera, 0.025}, running.table()->pictures(camera, robots),
                      running.table()->glances(camera, robots));
}

TEST(Demonstration, sorts_what_its_camera_sees_into_the_basket) {
  ApiCell cell({test::place("a", "learm", "bus")}, 5, {}, {}, nullptr, {},
               table_with({{.color = 0, .p_W = {0.17, -0.02, 0}, .turn = 0.4},
                           {.color = 4, .p_W = {0.15, -0.08, 0}, .turn = 1}}));
  open_camera(cell.cell());
  Demonstration shown(cell.api(), cell.cell());
  EXPECT_TRUE(cell.until([&] {
    shown.poll(cell.now());
    std::ptrdiff_t placed = 0;
    cell.cell().table()->cubes().with([&](const sim::CubeWorld& world) {
      placed = std::ranges::count(world.cubes(), sim::CubePlace::kBasket, &sim::CubeState::where);
    });
    return placed == 2;
  })) << shown.parts().front().trouble;
  EXPECT_TRUE(shown.parts().front().trouble.empty()) << shown.parts().front().trouble;
}

TEST(Demonstration, a_pause_by_the_camera_ends_by_itself) {
  ApiCell cell({test::place("a", "learm", "bus")}, 5, {}, {}, nullptr, {},
               table_with({{.color = 0, .p_W = {0.17, -0.02, 0}, .turn = 0.4}}));
  runtime::RunningCell& running = cell.cell();
  open_camera(running);
  Demonstration shown(cell.api(), running);
  const auto job = [&] { return running.jobs(0).view(); };
  // It comes and goes: what is there before the arm sorts is no news.
  runtime::SimulatedTable::Trouble hand;
  hand.hand = running.table()->hand_in_view(0);
  Instant next{};
  bool is_there = false;
  ASSERT_TRUE(cell.until([&] {
    shown.poll(cell.now());
    if (cell.now() >= next) {
      next = cell.now() + std::chrono::milliseconds(1500);
      is_there = !is_there;
      running.table()->set_trouble(is_there ? hand : runtime::SimulatedTable::Trouble{});
    }
    return job().paused;
  }));
  running.table()->set_trouble({});
  EXPECT_TRUE(cell.until([&] {
    shown.poll(cell.now());
    return !job().paused;
  }));
  EXPECT_FALSE(shown.over());
}

TEST(Demonstration, a_visitor_who_takes_a_robot_ends_it_and_has_the_robot) {
  ApiCell cell({test::place("a", "learm", "bus"), test::place("b", "learm", "bus")}, 2);
  Demonstration shown(cell.api(), cell.cell());
  ApiClient visitor(cell);
  const auto moves = [&](std::size_t i) {
    return cell.cell().station(i).view().state == control::MachineState::kMoving;
  };
  ASSERT_TRUE(cell.until([&] {
    shown.poll(cell.now());
    return moves(0) && moves(1);
  }));
  EXPECT_TRUE(visitor.call("cell.status")["result"]["demonstration"].get<bool>());
  EXPECT_FALSE(shown.over()) << "to look is not to move";
  const Json taken = visitor.call("lease.take", {{"robot", "a"}});
  EXPECT_TRUE(taken.contains("result")) << taken.dump();
  EXPECT_TRUE(shown.over());
  EXPECT_TRUE(cell.until([&] { return !moves(0) && !moves(1); })) << "all come to rest";
  const Json status = visitor.call("cell.status")["result"];
  EXPECT_FALSE(status.contains("demonstration"));
  shown.poll(cell.now());
  visitor.finish("a");
  EXPECT_EQ(visitor.run("a", test::kStand)["phase"], "done");
}

TEST(Demonstration, a_stop_of_a_viewer_ends_it) {
  ApiCell cell({test::place("a", "learm", "bus")}, 2);
  Demonstration shown(cell.api(), cell.cell());
  ApiClient viewer(cell, Role::kViewer);
  ASSERT_TRUE(cell.until([&] {
    shown.poll(cell.now());
    return cell.cell().station(0).view().state == control::MachineState::kMoving;
  }));
  viewer.call("robot.stop");
  EXPECT_TRUE(shown.over());
}

}  // namespace
}  // namespace sinew::server
