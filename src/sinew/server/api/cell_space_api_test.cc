// Robots that stand in each other's reach: over the API, in real threads.

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <memory>

#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/planning/collision/cell_claim.h"
#include "sinew/server/api/api_test_cell.h"

namespace sinew::server {
namespace {

using test::ApiCell;
using test::ApiClient;

/// Stretched out over the table, to where it looks; 0.3 m.
std::string out(double base_deg, const std::string& how = "") {
  return "joint base=" + std::to_string(base_deg) +
         "deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg" + how;
}

CellRobot facing(const std::string& name, double x, double turn,
                 const std::string& profile = "bus") {
  CellRobot robot = test::place(name, "learm", profile);
  robot.X_WB.p.x = x;
  robot.X_WB.R = rotation_z(turn);
  return robot;
}

/// Two arms 0.5 m apart that look at each other.
std::vector<CellRobot> pair_of_arms(const std::string& right_profile = "bus") {
  return {facing("left", 0, 0), facing("right", 0.5, kPi, right_profile)};
}

void enable(ApiClient& client, const std::string& robot) {
  ASSERT_EQ(client.sentence("lease.take", {{"robot", robot}}), "");
  ASSERT_EQ(client.sentence("robot.enable", {{"robot", robot}}), "");
}

void begin(ApiClient& client, const std::string& robot, const std::string& text) {
  const Json begun = client.call("program.run", {{"robot", robot}, {"text", text}});
  ASSERT_TRUE(begun.contains("result")) << begun.dump();
}

/// How near the two machines really are, m.
double apart(ApiClient& client, ApiCell& cell) {
  std::vector<std::unique_ptr<planning::RobotBodies>> robots;
  std::vector<planning::JointArray> q;
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& place = cell.cell().cell().robots[i];
    robots.push_back(
        std::make_unique<planning::RobotBodies>(cell.cell().station(i).robot(), place.X_WB));
    const Json truth = client.call("simulation.truth", {{"robot", place.name}})["result"];
    planning::JointArray joints{};
    for (std::size_t j = 0; j < robots[i]->joints(); ++j) {
      joints[j] = truth["joints"][j]["position_rad"].get<double>();
    }
    q.push_back(joints);
  }
  const auto claim = planning::claim_of_rest(*robots[1], {q[1], {}});
  const planning::CellObstacle obstacle{&claim, 0, 0};
  return planning::nearest_obstacle(*robots[0], q[0], {&obstacle, 1}).distance;
}

TEST(CellSpaceApi, a_row_that_meets_a_resting_robot_is_refused_before_anything_moves) {
  ApiCell cell(pair_of_arms());
  ApiClient client(cell);
  enable(client, "left");
  enable(client, "right");
  ASSERT_EQ(client.run("left", out(0))["phase"], "done");
  const Json job = client.run("right", out(90) + "\n" + out(0));
  ASSERT_EQ(job["phase"], "failed") << job.dump();
  EXPECT_EQ(job["error"]["code"], "cell_contact");
  EXPECT_EQ(job["error"]["line"], 2) << "and the first row was not begun";
  EXPECT_EQ(job["orders_done"], 0);
  EXPECT_EQ(job["error"]["other"], "left");
  EXPECT_GT(job["error"]["share"], 0.1);
  EXPECT_GT(job["error"]["way_m"], 0.01);
  EXPECT_NE(job["error"]["sentence"].get<std::string>().find("of left ("), std::string::npos)
      << job["error"].dump();
  // What it says helps.
  ASSERT_EQ(client.run("left", out(90))["phase"], "done");
  EXPECT_EQ(client.run("right", out(0))["phase"], "done");
}

TEST(CellSpaceApi, of_two_that_want_the_same_space_at_once_exactly_one_gets_it) {
  for (int round = 0; round < 3; ++round) {
    ApiCell cell(pair_of_arms(), 10);
    ApiClient client(cell);
    enable(client, "left");
    enable(client, "right");
    client.send("program.run", {{"robot", "left"}, {"text", out(0)}});
    client.send("program.run", {{"robot", "right"}, {"text", out(0)}});
    const Json left = client.finish("left");
    const Json right = client.finish("right");
    const int done = (left["phase"] == "done" ? 1 : 0) + (right["phase"] == "done" ? 1 : 0);
    EXPECT_EQ(done, 1) << left.dump() << right.dump();
    const Json& loser = left["phase"] == "done" ? right : left;
    ASSERT_TRUE(loser.contains("error")) << loser.dump();
    EXPECT_EQ(loser["error"]["code"], "cell_contact") << "nobody waits for a robot that rests";
    EXPECT_GT(apart(client, cell), 0);
  }
}

TEST(CellSpaceApi, a_row_waits_for_a_robot_that_is_moving_away) {
  ApiCell cell(pair_of_arms(), 5);
  ApiClient client(cell);
  enable(client, "left");
  enable(client, "right");
  ASSERT_EQ(client.run("left", out(0))["phase"], "done");
  begin(client, "left", out(90, " speed=10%"));
  ASSERT_TRUE(cell.until([&] { return client.status("left")["state"] == "moving"; }));
  begin(client, "right", out(0));
  Json waits;
  ASSERT_TRUE(cell.until([&] {
    waits = client.call("job.status", {{"robot", "right"}})["result"];
    return waits.contains("waits_for");
  }));
  EXPECT_EQ(waits["waits_for"], "left");
  EXPECT_NE(client.status("right")["state"], "moving");
  EXPECT_EQ(client.finish("right")["phase"], "done");
  EXPECT_EQ(client.finish("left")["phase"], "done");
  EXPECT_GT(apart(client, cell), 0);
}

TEST(CellSpaceApi, who_was_stopped_gives_back_what_it_did_not_come_to) {
  ApiCell cell(pair_of_arms(), 5);
  ApiClient client(cell);
  enable(client, "left");
  enable(client, "right");
  ASSERT_EQ(client.run("left", out(90))["phase"], "done");
  begin(client, "left", out(0, " speed=3%"));
  ASSERT_TRUE(cell.until([&] { return client.status("left")["state"] == "moving"; }));
  begin(client, "right", out(0));
  ASSERT_TRUE(cell.until([&] {
    return client.call("job.status", {{"robot", "right"}})["result"].contains("waits_for");
  }));
  EXPECT_EQ(client.sentence("robot.stop", {{"robot", "left"}}), "");
  EXPECT_EQ(client.finish("left")["phase"], "stopped");
  EXPECT_EQ(client.finish("right")["phase"], "done");
  EXPECT_GT(apart(client, cell), 0);
}

TEST(CellSpaceApi, a_lost_robot_has_its_whole_reach_until_somebody_says_where_it_stands) {
  ApiCell cell(pair_of_arms("lsc6"));
  ApiClient client(cell);
  enable(client, "left");
  if (client.status("right")["position"] == "lost") {
    const Json job = client.run("left", out(0));
    ASSERT_EQ(job["phase"], "failed") << job.dump();
    EXPECT_EQ(job["error"]["other"], "right");
    EXPECT_NE(job["error"]["sentence"].get<std::string>().find("nobody knows"), std::string::npos)
        << job["error"].dump();
    enable(client, "right");
    ASSERT_EQ(client.sentence("robot.declare", {{"robot", "right"}}), "");
  } else {
    ADD_FAILURE() << client.status("right").dump();
  }
  EXPECT_EQ(client.run("left", out(0))["phase"], "done");
}

TEST(CellSpaceApi, an_object_is_kept_out_of_and_a_table_is_stood_on) {
  CellObject post{.name = "post", .X_WX = {}, .half = {0.03, 0.03, 0.12}};
  post.X_WX.p = {0.25, 0, 0.12};
  CellObject table{.name = "table", .X_WX = {}, .half = {0.6, 0.6, 0.01}};
  table.X_WX.p.z = -0.01;
  ApiCell cell({facing("left", 0, 0)}, 20, {}, {post, table});
  ApiClient client(cell);
  enable(client, "left");
  const Json beside = client.run("left", out(90));
  EXPECT_EQ(beside["phase"], "done") << beside.dump();
  const Json job = client.run("left", out(0));
  ASSERT_EQ(job["phase"], "failed") << job.dump();
  EXPECT_EQ(job["error"]["code"], "cell_contact");
  EXPECT_EQ(job["error"]["other"], "post");
  EXPECT_FALSE(job["error"].contains("other_link"));
  EXPECT_EQ(client.run("left", out(60))["phase"], "done");
}

TEST(CellSpaceApi, a_jog_stops_before_the_other_robot_and_comes_back) {
  ApiCell cell(pair_of_arms(), 2);
  ApiClient client(cell);
  enable(client, "left");
  enable(client, "right");
  ASSERT_EQ(client.run("right", out(0))["phase"], "done");
  ASSERT_EQ(client.run("left", out(75))["phase"], "done");
  const auto base = [&] {
    return client.status("left")["joints"][0]["position_rad"].get<double>();
  };
  // However slowly this computer turns, the stick is held until something has come of it.
  double nearest = 1;
  const auto jog_until = [&](double velocity, const auto& done) {
    return cell.until([&] {
      const Json turn{{"robot", "left"},
                      {"frame", "joint"},
                      {"velocity", {velocity, 0, 0, 0, 0}},
                      {"expiry_s", 0.5}};
      EXPECT_EQ(client.sentence("robot.jog", turn), "");
      for (int wait = 0; wait < 10; ++wait) cell.turn();
      nearest = std::min(nearest, apart(client, cell));
      return done();
    });
  };
  double last = base();
  int at_rest = 0;
  EXPECT_TRUE(jog_until(-0.6, [&] {
    at_rest = std::abs(base() - last) < from_deg(0.02) && last < from_deg(70) ? at_rest + 1 : 0;
    last = base();
    return at_rest == 15;
  }));
  std::cout << "  " << to_mm(nearest) << " mm between them at the nearest, base at "
            << to_deg(base()) << " deg\n";
  EXPECT_GT(nearest, 0);
  EXPECT_LT(nearest, 0.06) << "and it does come near";
  EXPECT_GT(base(), from_deg(5)) << "alone it would have gone on";
  const double stopped = base();
  EXPECT_TRUE(jog_until(0.6, [&] { return base() > stopped + from_deg(10); }));
}

}  // namespace
}  // namespace sinew::server
