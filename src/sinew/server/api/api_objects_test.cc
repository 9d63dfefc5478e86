#include <gtest/gtest.h>

#include "sinew/server/api/api_test_cell.h"
#include "sinew/server/json/partial_update.h"

namespace sinew::server {
namespace {

using test::ApiCell;
using test::ApiClient;
using test::place;

TEST(ApiObjects, are_listed_and_queried_by_name) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell, Role::kViewer);
  EXPECT_EQ(client.call("objects.list")["result"]["objects"],
            (Json{"cell", "robot/left", "job/left"}));
  const Json one = client.call("objects.query", {{"objects", {"robot/left"}}})["result"]["objects"];
  EXPECT_EQ(one.size(), 1U);
  EXPECT_EQ(one["robot/left"]["position"], "lost");
  // Each field of its status is there, but the job.
  const Json status = client.status("left");
  for (auto field = status.begin(); field != status.end(); ++field) {
    EXPECT_TRUE(one["robot/left"].contains(field.key())) << field.key();
  }
  EXPECT_EQ(client.call("objects.query")["result"]["objects"].size(), 3U);
  EXPECT_NE(client.sentence("objects.query", {{"objects", {"robot/lfet"}}}).find("robot/left"),
            std::string::npos);
  EXPECT_NE(client.sentence("objects.query", {{"objects", {3}}}).find("a list of strings"),
            std::string::npos);
}

/// What was told whole, and all updates since, are together what a query says.
TEST(ApiObjects, partial_updates_add_up_to_the_whole) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  Json known = client.call("objects.subscribe", {{"objects", {"robot/left", "job/left"}},
                                                 {"rate_hz", 100}})["result"]["objects"];
  client.run("left", test::kStand);
  EXPECT_EQ(client.run("left", "joint base=30deg")["phase"], "done");
  bool same = false;
  std::size_t partial = 0;
  EXPECT_TRUE(cell.until([&] {
    client.take_messages();
    for (const Json& message : client.messages()) {
      if (message["method"] != "objects") continue;
      for (const auto& [name, update] : message["params"]["objects"].items()) {
        if (!update.contains("robot")) ++partial;
        apply_update(known[name], update);
      }
    }
    client.messages().clear();
    const Json now = client.call("objects.query", {{"objects", {"job/left"}}})["result"]["objects"];
    same = partial_update(known["job/left"], now["job/left"]).empty() &&
           known["robot/left"]["state"] == "ready";
    return same;
  }));
  EXPECT_TRUE(same) << known.dump(1);
  EXPECT_GT(partial, 5U);
  EXPECT_EQ(known["job/left"]["phase"], "done");
}

TEST(ApiObjects, an_empty_list_ends_the_messages) {
  ApiCell cell({place("left", "learm", "bus")});
  ApiClient client(cell);
  client.call("objects.subscribe", {{"objects", {"robot/left"}}, {"rate_hz", 100}});
  client.call("objects.subscribe", {{"objects", Json::array()}});
  client.messages().clear();
  client.run("left", test::kStand);
  for (const Json& message : client.messages()) EXPECT_NE(message["method"], "objects");
}

TEST(ApiObjects, answers_alone_carry_no_messages) {
  ApiCell cell({place("left", "learm", "bus")});
  const auto session = cell.api().open(Role::kOperator, Delivery::kAnswersOnly);
  for (const char* method : {"watch", "objects.subscribe"}) {
    const Json params = method[0] == 'w' ? Json::object() : Json{{"objects", {"cell"}}};
    cell.api().receive(*session, request_text(1, method, params), cell.now());
    cell.turn();
    const auto answer = cell.api().take_output(*session);
    ASSERT_TRUE(answer);
    EXPECT_NE(answer->find("a connection that stays"), std::string::npos) << *answer;
  }
}

}  // namespace
}  // namespace sinew::server
