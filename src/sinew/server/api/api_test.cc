#include "sinew/server/api/api.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"
#include "sinew/runtime/records/mcap_reader.h"
#include "sinew/server/api/api_test_cell.h"
#include "support/property.h"
#include "support/scratch_folder.h"

namespace sinew::server {
namespace {

using test::ApiCell;
using test::ApiClient;
using test::place;

TEST(Api, tells_what_is_in_the_cell) {
  ApiCell cell({place("left", "learm", "bus"), place("six", "hexapod")});
  ApiClient client(cell);
  const Json description = client.call("cell.describe")["result"];
  EXPECT_EQ(description["title"], "test");
  ASSERT_EQ(description["robots"].size(), 2U);
  EXPECT_EQ(description["robots"][0]["name"], "left");
  EXPECT_TRUE(description["robots"][0]["joints"][0].contains("lower_rad"));
  EXPECT_TRUE(description["robots"][1]["joints"][0].contains("lower_m"));
  const Json status = client.call("cell.status")["result"]["robots"];
  EXPECT_EQ(status[0]["position"], "lost");
  EXPECT_EQ(status[1]["position"], "commanded");
}

TEST(Api, a_program_moves_the_machine_and_not_only_its_picture) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  EXPECT_EQ(client.run("left", test::kStand)["phase"], "done");
  EXPECT_EQ(client.run("left", "joint base=30deg")["phase"], "done");
  // Servos sag and have a dead band: the wire's page says what is left open.
  EXPECT_NEAR(truth_deg(client, "left", 0), 30, 1.5);
  EXPECT_EQ(client.status("left")["state"], "ready");
}

TEST(Api, a_program_that_cannot_be_run_is_refused_with_row_and_reason) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  const Json wrong = client.call("program.run", {{"robot", "left"}, {"text", "jiont base=3deg"}});
  EXPECT_NE(wrong["error"]["message"].get<std::string>().find("program:1:1"), std::string::npos);
  EXPECT_EQ(wrong["error"]["data"]["complaints"][0]["line"], 1);
  client.run("left", test::kStand);
  const Json far = client.run("left", "joint base=10deg\nline x=900mm");
  EXPECT_EQ(far["phase"], "failed");
  EXPECT_EQ(far["error"]["line"], 2);
  EXPECT_EQ(client.status("left")["state"], "ready");
}

TEST(Api, a_program_brings_its_points_and_what_it_calls) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  client.run("left", test::kStand);
  const std::string points =
      "[points.there]\nrobot = \"learm\"\njoints_deg = [25, 20, 40, 40, 0]\n";
  const Json request{{"robot", "left"},
                     {"text", "call go"},
                     {"points", points},
                     {"called", {{"go", "joint to=there"}}}};
  const Json begun = client.call("program.run", request);
  ASSERT_TRUE(begun.contains("result")) << begun.dump();
  EXPECT_EQ(client.finish("left")["phase"], "done");
  EXPECT_NEAR(truth_deg(client, "left", 0), 25, 1.5);
  EXPECT_NE(client.sentence("program.run", {{"robot", "left"}, {"text", "call go"}})
                .find("does not bring the program 'go'"),
            std::string::npos);
}

TEST(Api, one_client_moves_and_the_other_is_told_who_does) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient first(cell);
  ApiClient second(cell);
  const Json lease = first.call("lease.take", {{"robot", "left"}});
  EXPECT_GT(lease["result"]["epoch"], 0U);
  EXPECT_NE(second.sentence("lease.take", {{"robot", "left"}}), "");
  EXPECT_NE(second.sentence("robot.enable", {{"robot", "left"}}), "");
  EXPECT_EQ(first.sentence("robot.enable", {{"robot", "left"}}), "");
  EXPECT_EQ(first.sentence("lease.release", {{"robot", "left"}}), "");
  EXPECT_EQ(second.sentence("lease.take", {{"robot", "left"}}), "");
}

TEST(Api, anybody_stops_and_the_program_is_over) {
  ApiCell cell({place("left", "learm", "bus"), place("six", "hexapod")}, 5);
  ApiClient owner(cell);
  ApiClient viewer(cell, Role::kViewer);
  owner.run("left", test::kStand);
  owner.call("program.run",
             {{"robot", "left"}, {"text", "joint base=90deg speed=5%\njoint base=0deg speed=5%"}});
  ASSERT_TRUE(cell.until([&] { return owner.status("left")["state"] == "moving"; }));
  EXPECT_EQ(viewer.sentence("robot.stop"), "");
  EXPECT_EQ(owner.finish("left")["phase"], "stopped");
  const double where = truth_deg(owner, "left", 0);
  for (int k = 0; k < 100; ++k) cell.turn();
  EXPECT_NEAR(truth_deg(owner, "left", 0), where, 1.5);
  EXPECT_NE(viewer.sentence("lease.take", {{"robot", "left"}}), "");
}

/// A stop that comes while a program is still being planned leaves nothing that begins behind it.
TEST(Api, nothing_begins_behind_a_stop) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  client.run("left", test::kStand);
  std::string text;
  for (int k = 0; k < 300; ++k) text += "line y=40mm\nline y=-40mm\n";
  for (int round = 0; round < 10; ++round) {
    const double before = truth_deg(client, "left", 0);
    client.call("program.run", {{"robot", "left"}, {"text", text}});
    for (int k = 0; k < round; ++k) cell.turn();
    EXPECT_EQ(client.sentence("robot.stop", {{"robot", "left"}}), "");
    const std::string phase = client.finish("left")["phase"];
    EXPECT_EQ(phase, "stopped");
    const Json status = client.status("left");
    EXPECT_EQ(status["state"], "ready") << status.dump();
    EXPECT_NEAR(truth_deg(client, "left", 0), before, 40);
  }
}

TEST(Api, a_jog_goes_as_long_as_somebody_asks_for_it) {
  ApiCell cell({place("left", "learm", "bus"), place("big", "bigrobotarm")}, 5);
  ApiClient client(cell);
  client.run("left", test::kStand);
  const double before = truth_deg(client, "left", 0);
  const Json turn{{"robot", "left"}, {"frame", "joint"}, {"velocity", {0.3, 0, 0, 0, 0}}};
  for (int k = 0; k < 40; ++k) {
    ASSERT_EQ(client.sentence("robot.jog", turn), "");
    for (int wait = 0; wait < 8; ++wait) cell.turn();
  }
  ASSERT_TRUE(cell.until([&] { return client.status("left")["state"] == "ready"; }));
  EXPECT_GT(truth_deg(client, "left", 0), before + 3);
  EXPECT_NE(client.sentence("robot.jog", {{"robot", "left"}, {"frame", "up"}, {"velocity", {1}}}),
            "");
  EXPECT_NE(
      client.sentence("robot.jog", {{"robot", "big"}, {"frame", "joint"}, {"velocity", {0.1}}})
          .find("whole moves"),
      std::string::npos);
}

TEST(Api, a_program_pauses_and_goes_on) {
  ApiCell cell({place("left", "learm", "bus")}, 5);
  ApiClient client(cell);
  client.run("left", test::kStand);
  client.call("program.run", {{"robot", "left"}, {"text", "joint base=60deg speed=10%"}});
  ASSERT_TRUE(cell.until([&] { return client.status("left")["state"] == "moving"; }));
  EXPECT_EQ(client.sentence("robot.hold", {{"robot", "left"}}), "");
  ASSERT_TRUE(cell.until([&] { return client.status("left")["state"] == "held"; }));
  EXPECT_EQ(client.call("job.status", {{"robot", "left"}})["result"]["phase"], "paused");
  EXPECT_EQ(client.sentence("robot.resume", {{"robot", "left"}}), "");
  EXPECT_EQ(client.finish("left")["phase"], "done");
  EXPECT_NEAR(truth_deg(client, "left", 0), 60, 1.5);
}

TEST(Api, a_ride_throws_the_machine_about_and_brings_it_back) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  client.run("left", test::kStand);
  const Json begun =
      client.call("robot.bullride", {{"robot", "left"}, {"duration_s", 20}, {"seed", 3}});
  ASSERT_TRUE(begun.contains("result")) << begun.dump();
  const Json job = client.finish("left");
  EXPECT_EQ(job["phase"], "done") << job.dump();
  EXPECT_GT(job["orders"], 5);
  EXPECT_NEAR(truth_deg(client, "left", 0), 0, 1.5);
  EXPECT_NE(client.sentence("robot.bullride", {{"robot", "left"}, {"duration_s", 0}}), "");
}

TEST(Api, who_watches_hears_of_states_jobs_and_events) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  client.call("watch", {{"rate_hz", 100}});
  client.run("left", test::kStand);
  EXPECT_TRUE(cell.until([&] {
    client.take_messages();
    return std::ranges::any_of(client.messages(), [](const Json& message) {
      return message["method"] == "job" && message["params"]["over"];
    });
  }));
  std::size_t status = 0;
  std::vector<std::string> phases;
  std::vector<std::string> states;
  for (const Json& message : client.messages()) {
    if (message["method"] == "status") ++status;
    if (message["method"] == "job") phases.push_back(message["params"]["phase"]);
    if (message["method"] == "event" && message["params"]["kind"] == "state") {
      states.push_back(message["params"]["state"]);
    }
  }
  EXPECT_GT(status, 5U);
  ASSERT_FALSE(phases.empty());
  EXPECT_NE(std::ranges::find(phases, "done"), phases.end());
  EXPECT_NE(std::ranges::find(states, "recovering"), states.end());
  const Json events = client.call("events.list")["result"]["events"];
  ASSERT_GT(events.size(), 3U);
  EXPECT_EQ(events[0]["number"], 1);
}

TEST(Api, who_reads_nothing_has_little_to_read_and_then_the_latest) {
  ApiCell cell({place("left", "learm", "bus")}, 1);
  ApiClient client(cell);
  client.call("watch", {{"rate_hz", 100}});
  const auto count = [&] {
    client.take_messages();
    return std::ranges::count(client.messages(), "status",
                              [](const Json& one) { return one["method"]; });
  };
  count();
  const auto before = count();
  const Instant begin = cell.now();
  while (cell.now() - begin < std::chrono::seconds(1)) cell.turn();
  EXPECT_LE(count() - before, static_cast<std::ptrdiff_t>(Api::kOutputSlow));
  // Of all that it missed it hears nothing: the next one is of now.
  for (int turn = 0; turn < 10; ++turn) cell.turn();
  const auto next = count();
  EXPECT_GT(next, before);
  const double told = client.messages().back()["params"]["robots"][0]["at_s"];
  EXPECT_NEAR(told, client.status("left")["at_s"].get<double>(), 0.2);
}

TEST(Api, a_jobs_life_has_its_plan_with_what_holds_it_back) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  client.run("left", test::kStand);
  const Json job = client.run("left", "joint base=40deg\njoint base=0deg");
  EXPECT_EQ(job["limited"]["joint"], "base") << job.dump();
  std::vector<std::string> phases;
  Json planned;
  const Json told = client.call("events.list")["result"]["events"];
  for (const Json& event : told) {
    if (event["kind"] != "job" || event["job"] != job["job"]) continue;
    phases.push_back(event["phase"]);
    if (event["phase"] == "planned") planned = event;
  }
  ASSERT_FALSE(planned.is_null()) << told.dump();
  EXPECT_NEAR(planned["predicted_s"].get<double>(), job["predicted_s"].get<double>(), 1e-9);
  EXPECT_EQ(planned["limited"], job["limited"]);
  EXPECT_EQ(std::ranges::count(phases, "planned"), 1);
  EXPECT_LT(std::ranges::find(phases, "planned"), std::ranges::find(phases, "done"));
  // What cannot be planned never was.
  client.call("program.run", {{"robot", "left"}, {"text", "joint elbow=130deg"}});
  EXPECT_EQ(client.finish("left")["phase"], "failed");
  const Json events = client.call("events.list")["result"]["events"];
  EXPECT_EQ(events.back()["phase"], "failed") << events.dump();
  EXPECT_EQ(std::ranges::count(events, "planned",
                               [](const Json& event) { return event.value("phase", ""); }),
            2);
  // Its control loop says how long its cycles take.
  EXPECT_TRUE(cell.until([&] { return client.status("left").contains("cycle"); }));
  const Json cycle = client.status("left")["cycle"];
  EXPECT_GT(cycle["mean_s"], 0);
  EXPECT_GE(cycle["longest_s"], cycle["mean_s"]);
  EXPECT_LT(cycle["mean_s"], 0.1);
}

TEST(Api, each_job_leaves_a_record_and_says_where) {
  const sinew::test::ScratchFolder folder;
  ApiCell cell({place("left", "learm", "bus")}, 20,
               {.journal = "", .flight = "", .record = folder.at("jobs")});
  ApiClient client(cell);
  EXPECT_EQ(client.run("left", test::kStand)["phase"], "done");
  Json told;
  EXPECT_TRUE(cell.until([&] {
    const Json events = client.call("events.list")["result"]["events"];
    for (const Json& event : events) {
      if (event["kind"] == "record") told = event;
    }
    return !told.is_null();
  }));
  EXPECT_EQ(told["robot"], "left");
  EXPECT_FALSE(told.contains("trouble"));
  const std::string bytes = sinew::test::text_of(told["path"]);
  const auto content =
      runtime::read_mcap({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  EXPECT_FALSE(content.trouble);
  EXPECT_GT(content.messages.size(), 20U);
}

TEST(Api, a_client_that_does_not_read_is_ended_and_holds_nobody_up) {
  ApiCell cell({place("left", "learm", "bus")});
  const SessionId greedy = *cell.api().open(Role::kOperator);
  for (int k = 0; k < 400; ++k) {
    cell.api().receive(greedy, request_text(1, "cell.status", Json::object()), cell.now());
    cell.api().work(cell.now());
  }
  EXPECT_TRUE(cell.api().too_slow(greedy));
  ApiClient other(cell);
  EXPECT_EQ(other.sentence("robot.stop"), "");
  cell.api().close(greedy);
}

/// Large answers are bounded by their bytes, long before their number is.
TEST(Api, a_client_that_does_not_read_large_answers_is_ended_sooner) {
  ApiCell cell({place("left", "learm", "bus")});
  const SessionId greedy = *cell.api().open(Role::kViewer);
  std::size_t asked = 0;
  while (!cell.api().too_slow(greedy) && asked < 2 * Api::kOutputMax) {
    cell.api().receive(greedy, request_text(1, "rpc.discover", Json::object()), cell.now());
    cell.api().work(cell.now());
    ++asked;
  }
  const std::size_t size = cell.api().take_output(greedy)->size();
  EXPECT_LT(asked, Api::kOutputMax);
  EXPECT_LE((asked - 2) * size, Api::kOutputBytesMax);
  EXPECT_GE((asked + 1) * size, Api::kOutputBytesMax);
}

TEST(Api, serves_so_many_clients_and_no_more) {
  ApiCell cell({place("left", "learm", "bus")});
  std::vector<SessionId> ids;
  while (const auto id = cell.api().open(Role::kViewer)) ids.push_back(*id);
  EXPECT_EQ(ids.size(), Api::kSessionsMax);
  cell.api().close(ids.back());
  EXPECT_TRUE(cell.api().open(Role::kViewer));
}

/// @param angle  rad that joints may be beyond their limits
void expect_inside(const runtime::Station& station, double angle) {
  const auto view = station.view();
  ASSERT_TRUE(view.truth);
  const RobotModel& model = station.robot();
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const double slack = model.joints[j].kind == JointKind::kPrismatic ? 1e-4 : angle;
    EXPECT_GE(view.truth->joints[j].q, model.joints[j].lower - slack);
    EXPECT_LE(view.truth->joints[j].q, model.joints[j].upper + slack);
  }
}

/// Whatever words a client knows, in whatever order: an answer, no crash, nothing beyond limits.
TEST(Api, survives_clients_that_say_anything) {
  bool freed = false;
  ApiCell cell({place("left", "learm", "bus"), place("six", "hexapod")}, 20);
  constexpr std::string_view kPrograms[] = {
      "joint base=10deg", "line z=100mm",         "home", "jaws 10mm", "joint leg1=260mm",
      "wait 1ms",         "loop 3\nwait 1ms\nend"};
  // An arm that nobody has moved yet hangs limp, beyond a limit or not.
  ApiClient(cell).run("left", test::kStand);
  sinew::test::for_random_cases(40, [&](sinew::test::Random& random) {
    ApiClient one(cell);
    ApiClient two(cell);
    for (int k = 0; k < 60; ++k) {
      ApiClient& client = random.chance(0.5) ? one : two;
      const auto all = methods();
      const Method& method = all[static_cast<std::size_t>(
          random.integer(0, static_cast<std::int64_t>(all.size()) - 1))];
      Json params = Json::object();
      for (const Param& param : method.params) {
        if (!param.required && random.chance(0.5)) continue;
        switch (param.type) {
          case ParamType::kRobot:
            params[std::string(param.name)] = random.chance(0.7) ? "left" : "six";
            break;
          case ParamType::kText:
            params[std::string(param.name)] =
                param.name == "frame" ? "joint"
                                      : kPrograms[static_cast<std::size_t>(random.integer(0, 6))];
            break;
          case ParamType::kNumber:
            params[std::string(param.name)] = random.uniform(-1, 3);
            break;
          case ParamType::kWhole:
            params[std::string(param.name)] = random.integer(0, 1000);
            break;
          case ParamType::kFlag:
            params[std::string(param.name)] = random.chance(0.5);
            break;
          case ParamType::kTexts:
            params[std::string(param.name)] = {{"grip", "jaws 10mm"}};
            break;
          case ParamType::kNames:
            params[std::string(param.name)] = {"cell", random.chance(0.5) ? "robot/left" : "no"};
            break;
          case ParamType::kNumbers:
            for (std::int64_t n = random.integer(0, 7); n > 0; --n) {
              params[std::string(param.name)].push_back(random.uniform(-1, 1));
            }
            if (!params.contains(param.name)) params[std::string(param.name)] = Json::array();
            break;
        }
      }
      freed = freed || method.id == MethodId::kRobotFreeDrive;
      client.send(method.name, params);
      if (random.chance(0.3)) cell.turn();
      client.take_messages();
      client.messages().clear();
    }
    EXPECT_EQ(one.sentence("robot.stop"), "");
  });
  // Motors that are off let it fall to its mechanical ends.
  for (std::size_t i = 0; i < 2; ++i) {
    expect_inside(cell.cell().station(i), from_deg(freed ? 15 : 4));
  }
}

}  // namespace
}  // namespace sinew::server
