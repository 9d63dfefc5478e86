#include <gtest/gtest.h>

#include "sinew/core/units.h"
#include "sinew/server/api/api_test_cell.h"

namespace sinew::server {
namespace {

using test::ApiCell;
using test::ApiClient;
using test::place;

double leg_mm(ApiClient& client, std::size_t leg) {
  const Json truth = client.call("simulation.truth", {{"robot", "six"}})["result"];
  return to_mm(truth["joints"][leg]["position_m"].get<double>());
}

TEST(ApiRecovery, one_leg_goes_a_little_and_nothing_else_moves) {
  ApiCell cell({place("six", "hexapod"), place("arm", "learm", "bus")}, 5);
  ApiClient client(cell);
  EXPECT_EQ(client.call("cell.describe")["result"]["robots"][0]["nudge_max_m"], 0.5e-3);
  client.call("lease.take", {{"robot", "six"}});
  client.call("robot.enable", {{"robot", "six"}});
  const double before = leg_mm(client, 2);
  const Json begun =
      client.call("robot.nudge", {{"robot", "six"}, {"joint", "leg3"}, {"way", -20e-6}});
  ASSERT_TRUE(begun.contains("result")) << begun.dump();
  ASSERT_TRUE(cell.until([&] { return client.status("six")["state"] == "ready"; }));
  EXPECT_NEAR(leg_mm(client, 2), before - 0.02, 0.0005);
  EXPECT_NEAR(leg_mm(client, 0), before, 0.0005);
}

TEST(ApiRecovery, what_is_no_small_step_is_refused_with_a_sentence) {
  ApiCell cell({place("six", "hexapod"), place("arm", "learm", "bus")}, 5);
  ApiClient client(cell);
  const auto nudge = [&](const Json& joint, const Json& way, const char* robot = "six") {
    return client.sentence("robot.nudge", {{"robot", robot}, {"joint", joint}, {"way", way}});
  };
  EXPECT_NE(nudge("leg3", 1e-5).find("take the lease first"), std::string::npos);
  client.call("lease.take", {{"robot", "six"}});
  client.call("lease.take", {{"robot", "arm"}});
  client.call("robot.enable", {{"robot", "six"}});
  EXPECT_NE(nudge("leg7", 1e-5).find("there are leg1, leg2"), std::string::npos);
  EXPECT_NE(nudge("leg3", 2e-3).find("one step of leg3 may be 0.5 mm at most"), std::string::npos)
      << nudge("leg3", 2e-3);
  EXPECT_NE(nudge("leg3", 0), "");
  EXPECT_NE(nudge("leg3", "far").find("a number"), std::string::npos);
  EXPECT_NE(nudge("base", 0.01, "arm").find("moves to places only"), std::string::npos);
  ApiClient viewer(cell, Role::kViewer);
  EXPECT_NE(viewer.sentence("robot.nudge", {{"robot", "six"}, {"joint", "leg1"}, {"way", 1e-5}}),
            "");
}

TEST(ApiRecovery, a_place_against_what_is_measured_needs_to_be_told_as_moved_with_a_reason) {
  ApiCell cell({place("arm", "learm", "bus")}, 5);
  ApiClient client(cell);
  const Json stood =
      client.run("arm", "joint base=0deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg");
  ASSERT_EQ(stood["phase"], "done");
  client.call("lease.take", {{"robot", "arm"}});
  const Json status = client.status("arm");
  ASSERT_EQ(status["position"], "measured");
  const double base = status["joints"][0]["position_rad"];
  Json positions = Json::array();
  for (const Json& joint : status["joints"]) positions.push_back(joint["position_rad"]);
  positions[0] = base > 0 ? base - 0.5 : base + 0.5;
  Json params{{"robot", "arm"}, {"positions", positions}};
  EXPECT_NE(client.sentence("robot.declare", params).find("base cannot stand at"),
            std::string::npos);
  params["moved"] = "  ";
  EXPECT_NE(client.sentence("robot.declare", params).find("needs a reason"), std::string::npos);
  params["moved"] = "lifted it by hand";
  // Its sensors go before any hand: what would be dropped is not accepted.
  EXPECT_NE(client.sentence("robot.declare", params).find("knows better than a statement"),
            std::string::npos);
  bool told = false;
  const Json events = client.call("events.list")["result"]["events"];
  for (const Json& event : events) {
    told = told || (event["kind"] == "declaration_refused" && event.value("reason", "") != "" &&
                    event["positions"].size() == 5 && event["trouble"] != "");
  }
  EXPECT_TRUE(told);
}

TEST(ApiRecovery, a_statement_leaves_an_event_with_its_place_and_what_was_known_and_why) {
  ApiCell cell({place("six", "hexapod")}, 5);
  ApiClient client(cell);
  client.call("lease.take", {{"robot", "six"}});
  client.call("robot.enable", {{"robot", "six"}});
  EXPECT_EQ(client.sentence("robot.declare", {{"robot", "six"}}), "");
  EXPECT_EQ(client.sentence("robot.declare", {{"robot", "six"}, {"shown", true}}), "");
  Json positions = Json::array();
  const Json status = client.status("six");
  for (const Json& joint : status["joints"]) {
    positions.push_back(joint["position_m"].get<double>() - 1e-3);
  }
  EXPECT_EQ(
      client.sentence("robot.declare",
                      {{"robot", "six"}, {"positions", positions}, {"moved", "let down by hand"}}),
      "");
  Json last;
  const Json events = client.call("events.list")["result"]["events"];
  for (const Json& event : events) {
    if (event["kind"] == "declared") last = event;
  }
  ASSERT_FALSE(last.is_null());
  EXPECT_EQ(last["positions"], positions);
  EXPECT_EQ(last["reason"], "let down by hand");
  EXPECT_TRUE(last["client"].is_number());
  EXPECT_NEAR(last["known"][0]["position_m"].get<double>(), positions[0].get<double>() + 1e-3,
              1e-9);
}

}  // namespace
}  // namespace sinew::server
