// Homing, recovery and commissioning over the API, in real threads.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "sinew/core/units.h"
#include "sinew/runtime/commissioning_file.h"
#include "sinew/server/api/api_test_cell.h"
#include "sinew/server/json/procedure_json.h"
#include "support/scratch_folder.h"

namespace sinew::server {
namespace {

using test::ApiCell;
using test::ApiClient;
using test::place;

/// A procedure and whoever answers it.
class Procedure {
 public:
  Procedure(ApiCell& cell, ApiClient& client, std::string robot, const std::string& kind)
      : cell_(cell), client_(client), robot_(std::move(robot)) {
    const Json begun = client.call("procedure.start", {{"robot", robot_}, {"kind", kind}});
    EXPECT_TRUE(begun.contains("result")) << begun.dump();
  }

  Json status() { return client_.call("procedure.status", {{"robot", robot_}})["result"]; }
  /// Until something is asked that can be answered, or it is over.
  Json asked() {
    Json now;
    const bool came = cell_.until([&] {
      now = status();
      return now["over"].get<bool>() || (now.contains("asks") && now["asks"]["ready"].get<bool>());
    });
    EXPECT_TRUE(came) << now.dump();
    EXPECT_TRUE(!now["over"].get<bool>() || now["phase"] == "done") << now.dump();
    return now;
  }
  /// Waits for the question and answers. @return  why not
  std::string say(const std::string& answer) {
    asked();
    return client_.sentence("procedure.answer", {{"robot", robot_}, {"answer", answer}});
  }
  Json end() {
    Json now;
    EXPECT_TRUE(cell_.until([&] { return (now = status())["over"].get<bool>(); })) << now.dump();
    return now;
  }

 private:
  ApiCell& cell_;
  ApiClient& client_;
  std::string robot_;
};

std::string state_of(ApiClient& client, const char* robot) {
  return client.status(robot)["state"];
}

TEST(ApiProcedures, a_platform_is_recovered_step_by_step_while_others_watch) {
  ApiCell cell({place("six", "hexapod")}, 1);
  ApiClient client(cell);
  ApiClient viewer(cell, Role::kViewer);
  viewer.call("watch", {{"rate_hz", 0}, {"robot", "six"}});
  Procedure recovery(cell, client, "six", "recover");
  const Json first = recovery.asked();
  EXPECT_EQ(first["kind"], "recover");
  EXPECT_EQ(first["step"]["number"], 1);
  EXPECT_EQ(first["step"]["of"], 7);
  EXPECT_EQ(first["asks"]["kind"], "amount");
  EXPECT_EQ(first["joint"], "leg1");
  EXPECT_NE(recovery.say("200mm"), "");
  EXPECT_NE(viewer.sentence("procedure.answer", {{"robot", "six"}, {"answer", "done"}}), "");
  EXPECT_EQ(recovery.say("-0.02mm"), "");
  for (int leg = 0; leg < 6; ++leg) EXPECT_EQ(recovery.say("done"), "");
  const Json place = recovery.asked();
  ASSERT_TRUE(place.contains("asks")) << place.dump();
  EXPECT_EQ(place["asks"]["kind"], "place");
  EXPECT_EQ(place["asks"]["choices"][0], "home");
  EXPECT_EQ(place["steps"][0]["words"], "went -0.02 mm in all");
  // The legs were moved by their own motors: what that says counts.
  EXPECT_EQ(recovery.say("lowered"), "");
  EXPECT_NE(recovery.asked()["trouble"].get<std::string>().find("leg1 cannot stand at"),
            std::string::npos);
  EXPECT_EQ(recovery.say("home moved: put there by hand"), "");
  EXPECT_EQ(recovery.end()["phase"], "done");
  bool moved = false;
  bool ended = false;
  ASSERT_TRUE(cell.until([&] {
    viewer.take_messages();
    for (const Json& message : viewer.messages()) {
      if (message["method"] != "procedure") continue;
      const Json& params = message["params"];
      const bool goes = params.contains("progress") && params["progress"].contains("share");
      moved = moved || (goes && params["joint"] == "leg1");
      ended = ended || params["over"].get<bool>();
    }
    return ended;
  }));
  EXPECT_TRUE(moved) << "how the motion got on";
  std::uint64_t last = 0;
  bool told = false;
  const Json events = client.call("events.list")["result"]["events"];
  for (const Json& event : events) {
    EXPECT_GT(event["number"].get<std::uint64_t>(), last) << event.dump();
    last = event["number"];
    told |= event["kind"] == "procedure" && event.contains("procedure_number");
  }
  EXPECT_TRUE(told) << events.dump();
}

TEST(ApiProcedures, what_is_no_procedure_or_no_answer_is_refused_with_a_sentence) {
  ApiCell cell({place("six", "hexapod")}, 1);
  ApiClient client(cell);
  const auto start = [&](const char* robot, const char* kind) {
    return client.sentence("procedure.start", {{"robot", robot}, {"kind", kind}});
  };
  EXPECT_NE(start("six", "dance").find("home, recover or commission"), std::string::npos);
  EXPECT_NE(client.sentence("procedure.answer", {{"robot", "six"}, {"answer", "go"}})
                .find("no procedure is under way"),
            std::string::npos);
  Procedure recovery(cell, client, "six", "recover");
  recovery.asked();
  EXPECT_NE(start("six", "recover").find("is under way"), std::string::npos);
  EXPECT_NE(client.sentence("program.run", {{"robot", "six"}, {"text", "joint leg1=240mm"}})
                .find("Recovery of"),
            std::string::npos);
  EXPECT_NE(client.sentence("procedure.back", {{"robot", "six"}}).find("first step"),
            std::string::npos);
  ApiClient other(cell);
  EXPECT_NE(
      other.sentence("procedure.cancel", {{"robot", "six"}}).find("procedure.start with take_over"),
      std::string::npos);
  EXPECT_EQ(recovery.say("done"), "");
  EXPECT_EQ(client.sentence("procedure.back", {{"robot", "six"}}), "");
  EXPECT_EQ(recovery.asked()["step"]["id"], "adjust.leg1");
  EXPECT_EQ(client.sentence("procedure.cancel", {{"robot", "six"}}), "");
  EXPECT_EQ(recovery.end()["phase"], "cancelled");
}

TEST(ApiProcedures, a_robot_without_end_stops_goes_to_its_home_pose) {
  ApiCell cell({place("big", "bigrobotarm")}, 20);
  ApiClient client(cell);
  ASSERT_EQ(client.run("big", "joint base=20deg")["phase"], "done");
  Procedure home(cell, client, "big", "home");
  EXPECT_EQ(home.say("yes"), "");
  EXPECT_EQ(home.say("go"), "");
  EXPECT_EQ(home.end()["phase"], "done");
  EXPECT_NEAR(client.status("big")["joints"][0]["position_rad"].get<double>(), 0, 1e-3);
}

TEST(ApiProcedures, anybodys_stop_ends_the_motion_and_leaves_the_question) {
  ApiCell cell({place("six", "hexapod")}, 1);
  ApiClient client(cell);
  ApiClient viewer(cell, Role::kViewer);
  Procedure recovery(cell, client, "six", "recover");
  EXPECT_EQ(recovery.say("-9mm"), "");
  ASSERT_TRUE(cell.until([&] { return recovery.status()["phase"] == "working"; }));
  EXPECT_EQ(viewer.sentence("robot.stop", {{"robot", "six"}}), "");
  const Json stopped = recovery.asked();
  EXPECT_EQ(stopped["phase"], "asking");
  EXPECT_NE(stopped["trouble"].get<std::string>().find("stopped on the way"), std::string::npos)
      << stopped.dump();
  EXPECT_EQ(state_of(client, "six"), "ready");
}

Json procedure_of_six(ApiClient& client) {
  return client.call("procedure.status", {{"robot", "six"}})["result"];
}

/// Control is lost under way: nothing moves, and the procedure waits at its step.
void expect_step_left(ApiCell& cell, ApiClient& watcher) {
  ASSERT_TRUE(cell.until([&] {
    const Json now = procedure_of_six(watcher);
    return now.contains("client_lost") && now["phase"] == "asking";
  })) << procedure_of_six(watcher).dump();
  ASSERT_TRUE(cell.until([&] { return state_of(watcher, "six") == "ready"; }));
  const Json left = procedure_of_six(watcher);
  EXPECT_FALSE(left["over"].get<bool>());
  EXPECT_EQ(left["step"]["id"], "adjust.leg2");
  EXPECT_NE(left["trouble"].get<std::string>().find("control was lost"), std::string::npos)
      << left.dump();
  EXPECT_FALSE(left["asks"]["ready"].get<bool>());
}

/// Through the first step, and under way in the second.
void begin_second_step(ApiCell& cell, Procedure& recovery, ApiClient& watcher) {
  EXPECT_EQ(recovery.say("done"), "");
  EXPECT_EQ(recovery.say("-9mm"), "");
  ASSERT_TRUE(cell.until([&] { return state_of(watcher, "six") != "ready"; }));
}

TEST(ApiProcedures, a_client_that_goes_away_leaves_its_step_to_the_next_one) {
  ApiCell cell({place("six", "hexapod")}, 1);
  ApiClient next(cell);
  {
    ApiClient client(cell);
    Procedure recovery(cell, client, "six", "recover");
    begin_second_step(cell, recovery, next);
  }
  expect_step_left(cell, next);
  EXPECT_NE(next.sentence("program.run", {{"robot", "six"}, {"text", "joint leg1=240mm"}})
                .find("go on with it or cancel it first"),
            std::string::npos);
  EXPECT_NE(next.sentence("procedure.answer", {{"robot", "six"}, {"answer", "done"}}), "");
  const std::size_t answers = procedure_of_six(next)["answers"];
  Procedure again(cell, next, "six", "recover");
  const Json asked = again.asked();
  EXPECT_EQ(asked["answers"], answers + 1) << "what was told before is older";
  EXPECT_EQ(asked["step"]["id"], "adjust.leg2") << "never at step 1";
  EXPECT_EQ(asked["client"], next.id());
  EXPECT_FALSE(asked.contains("client_lost"));
  EXPECT_EQ(again.say("done"), "");
  EXPECT_EQ(again.asked()["step"]["id"], "adjust.leg3");
}

TEST(ApiProcedures, who_takes_control_over_goes_on_or_ends_it) {
  ApiCell cell({place("six", "hexapod")}, 1);
  ApiClient next(cell);
  ApiClient client(cell);
  Procedure recovery(cell, client, "six", "recover");
  begin_second_step(cell, recovery, next);
  EXPECT_EQ(next.sentence("lease.take", {{"robot", "six"}, {"take_over", true}}), "");
  expect_step_left(cell, next);
  EXPECT_EQ(next.sentence("procedure.cancel", {{"robot", "six"}}), "");
  EXPECT_EQ(recovery.end()["phase"], "cancelled");

  EXPECT_EQ(next.sentence("lease.release", {{"robot", "six"}}), "");
  Procedure second(cell, client, "six", "recover");
  second.asked();
  EXPECT_NE(next.sentence("procedure.start", {{"robot", "six"}, {"kind", "recover"}}), "")
      << "its client is there";
  EXPECT_EQ(next.sentence("procedure.start",
                          {{"robot", "six"}, {"kind", "recover"}, {"take_over", true}}),
            "");
  ASSERT_TRUE(cell.until([&] {
    const Json now = procedure_of_six(next);
    return now["client"] == next.id() && now["asks"]["ready"].get<bool>();
  }));
  EXPECT_NE(client.sentence("procedure.answer", {{"robot", "six"}, {"answer", "done"}}), "");
  EXPECT_EQ(next.sentence("procedure.answer", {{"robot", "six"}, {"answer", "done"}}), "");
}

TEST(ApiProcedures, a_client_that_falls_silent_stops_what_it_moves) {
  ApiCell cell({place("six", "hexapod")}, 1);
  ApiClient watcher(cell);
  ApiClient client(cell);
  Procedure recovery(cell, client, "six", "recover");
  begin_second_step(cell, recovery, watcher);
  expect_step_left(cell, watcher);
}

/// An arm that nobody knows the place of, within reach of one that is moved by a little.
std::vector<CellRobot> near_a_lost_one() {
  std::vector<CellRobot> robots{place("big", "bigrobotarm"), place("lost", "learm", "lsc6")};
  robots[0].X_WB.p.y = 0.001;
  robots[1].X_WB.p = {0.45, 0, 0};
  return robots;
}

TEST(ApiProcedures, a_small_step_that_could_meet_another_robot_is_refused) {
  ApiCell cell(near_a_lost_one(), 5);
  ApiClient client(cell);
  ASSERT_EQ(client.sentence("lease.take", {{"robot", "big"}}), "");
  ASSERT_EQ(client.sentence("robot.enable", {{"robot", "big"}}), "");
  ASSERT_EQ(client.sentence("robot.declare", {{"robot", "big"}}), "");
  const Json nudge{{"robot", "big"}, {"joint", "base"}, {"way", 0.01}};
  const Json refused = client.call("robot.nudge", nudge);
  ASSERT_TRUE(refused.contains("error")) << refused.dump();
  EXPECT_EQ(refused["error"]["data"]["code"], "cell_contact");
  EXPECT_NE(refused["error"]["message"].get<std::string>().find("nobody knows where that one is"),
            std::string::npos)
      << refused.dump();
  Procedure recovery(cell, client, "big", "recover");
  EXPECT_EQ(recovery.say("1deg"), "");
  const Json asked = recovery.asked();
  ASSERT_TRUE(asked.contains("trouble")) << asked.dump();
  EXPECT_NE(asked["trouble"].get<std::string>().find("lost"), std::string::npos) << asked.dump();
  EXPECT_EQ(asked["step"]["id"], "adjust.base");
  // What it says helps.
  ASSERT_EQ(client.sentence("lease.take", {{"robot", "lost"}}), "");
  ASSERT_EQ(client.sentence("robot.enable", {{"robot", "lost"}}), "");
  ASSERT_EQ(client.sentence("robot.declare", {{"robot", "lost"}}), "");
  EXPECT_EQ(recovery.say("1deg"), "");
  EXPECT_FALSE(recovery.asked().contains("trouble"));
  EXPECT_EQ(client.sentence("procedure.cancel", {{"robot", "big"}}), "");
  recovery.end();
  ASSERT_TRUE(cell.until([&] { return state_of(client, "big") == "ready"; }));
  EXPECT_EQ(client.sentence("robot.nudge", nudge), "");
}

TEST(ApiProcedures, an_arm_with_end_stops_is_homed_and_says_how_far_the_search_is) {
  ApiCell cell({place("arm", "robot-arm-2")}, 60);
  ApiClient client(cell);
  client.call("watch", {{"rate_hz", 0}});
  Procedure homing(cell, client, "arm", "home");
  EXPECT_EQ(homing.say("yes"), "");
  Json asked = homing.asked();
  // A host that is starved ends a search; whoever stands beside it says go once more.
  for (int tries = 0; tries < 8 && asked["step"]["id"] == "search"; ++tries) {
    ASSERT_EQ(homing.say("go"), "");
    // Each joint's search is short enough to be waited for.
    for (std::size_t joint = 0; joint < 6; ++joint) {
      cell.until([&] {
        asked = homing.status();
        return asked["phase"] != "working" ||
               asked.value("joint", "") ==
                   cell.cell().station(0).robot().joints[std::min(joint + 1, std::size_t{5})].name;
      });
    }
    asked = homing.asked();
  }
  ASSERT_EQ(asked["step"]["id"], "again") << asked.dump();
  EXPECT_NE(asked["steps"][1]["words"].get<std::string>().find("zeros found"), std::string::npos);
  EXPECT_EQ(homing.say("skip"), "");
  for (asked = homing.asked(); !asked["over"].get<bool>(); asked = homing.asked()) {
    ASSERT_EQ(asked["asks"]["kind"], "go") << asked.dump();
    ASSERT_EQ(homing.say("go"), "");
  }
  EXPECT_EQ(homing.end()["phase"], "done");
  EXPECT_NE(client.status("arm")["position"], "lost");
  const bool told = std::ranges::any_of(client.messages(), [](const Json& message) {
    const Json& params = message["params"];
    return message["method"] == "procedure" && params.contains("progress") &&
           params["progress"].contains("at_most_s") && params.contains("joint");
  });
  EXPECT_TRUE(told) << "which joint is searched for, and for how long at most";
}

TEST(ApiProcedures, commissioning_finds_and_keeps_what_is_other_than_in_the_robots_file) {
  const sinew::test::ScratchFolder folder;
  ApiCell cell({place("big", "bigrobotarm")}, 20,
               {.journal = "", .flight = "", .record = "", .commissioning = folder.at("found")});
  const RobotModel& model = cell.cell().station(0).robot();
  const std::string file = folder.at("found/big.simulated.json");
  {
    ApiClient client(cell);
    Procedure half(cell, client, "big", "commission");
    EXPECT_EQ(half.say("yes"), "");
    EXPECT_EQ(half.asked()["steps"][2]["words"], "byte") << "what only the driver knows";
  }
  ApiClient client(cell);
  ASSERT_TRUE(cell.until([&] { return runtime::read_commissioning(file, model).has_value(); }))
      << "kept while it waits for another client";
  EXPECT_EQ(client.sentence("procedure.cancel", {{"robot", "big"}}), "");
  ASSERT_TRUE(cell.until([&] {
    return client.call("procedure.status", {{"robot", "big"}})["result"]["over"].get<bool>();
  }));
  ASSERT_TRUE(runtime::read_commissioning(file, model));
  EXPECT_FALSE(runtime::read_commissioning(file, model)->finished);
  // The supply is not asked for again.
  Procedure whole(cell, client, "big", "commission");
  EXPECT_EQ(whole.asked()["step"]["id"], "place");
  EXPECT_EQ(whole.say("home"), "");
  for (const char* way : {"left", "forward", "backward", "left", "forward"}) {
    EXPECT_EQ(whole.say("go"), "");
    EXPECT_EQ(whole.say(way), "");
  }
  EXPECT_EQ(whole.say("go"), "");
  EXPECT_EQ(whole.say("closed"), "");
  const Json ended = whole.end();
  EXPECT_EQ(ended["phase"], "done") << ended.dump();
  EXPECT_EQ(ended["file"], file);
  EXPECT_EQ(ended["settings"], Json({{"joint.elbow.turn", "other"}}));
  EXPECT_EQ(runtime::read_commissioning(file, model)->settings.size(), 1U);
}

TEST(ApiProcedures, a_robot_that_runs_with_what_was_found_is_not_commissioned_on_top_of_it) {
  CellRobot robot = place("big", "bigrobotarm");
  robot.settings = "found.json";
  ApiCell cell({robot}, 5);
  ApiClient client(cell);
  EXPECT_NE(client.sentence("procedure.start", {{"robot", "big"}, {"kind", "commission"}})
                .find("found.json"),
            std::string::npos);
}

TEST(ApiProcedures, a_procedure_is_read_back_as_it_was_told) {
  ApiCell cell({place("six", "hexapod")}, 1);
  ApiClient client(cell);
  Procedure recovery(cell, client, "six", "recover");
  EXPECT_EQ(recovery.say("done"), "");
  const Json json = recovery.asked();
  const auto read = read_procedure(json);
  ASSERT_TRUE(read);
  EXPECT_EQ(procedure_json("six", *read), json);
  Json broken = json;
  broken.erase("steps");
  EXPECT_FALSE(read_procedure(broken));
  broken = json;
  broken["phase"] = "dancing";
  EXPECT_FALSE(read_procedure(broken));
  EXPECT_FALSE(read_procedure(Json::array()));
}

}  // namespace
}  // namespace sinew::server
