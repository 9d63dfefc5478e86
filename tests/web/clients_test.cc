#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "web/web_cell.h"

/// Many clients, slow ones and greedy ones, beside one that moves a robot.
namespace sinew::test {
namespace {

using server::Json;
using server::WebServer;

/// Until its job is over; the phase it ended in.
std::string run(WebClient& client, const std::string& text) {
  const Json begun = client.call("program.run", {{"robot", "left"}, {"text", text}});
  EXPECT_TRUE(begun.contains("result")) << begun.dump();
  while (true) {
    const Json job = client.call("job.status", {{"robot", "left"}});
    if (!job.contains("result")) return job.dump();
    if (job["result"]["over"].get<bool>()) return job["result"]["phase"];
  }
}

/// One message over a connection that stays open.
Answered post(RawConnection& poster, std::uint16_t port, std::string_view token, const char* method,
              const Json& params) {
  const std::string body = server::request_text(1, method, params);
  poster.send("POST /rpc HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) +
              "\r\nContent-Type: application/json\r\nAuthorization: Bearer " + std::string(token) +
              "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  return poster.answer();
}

double base_truth(WebClient& client) {
  const Json truth = client.call("simulation.truth", {{"robot", "left"}});
  return truth["result"]["joints"][0]["position_rad"];
}

/// Jogs the base from message to message of its own watch, and lets go.
void jog(WebClient& client, int messages) {
  ASSERT_TRUE(client.call("lease.take", {{"robot", "left"}}).contains("result"));
  ASSERT_TRUE(client.call("watch", {{"rate_hz", 20}}).contains("result"));
  for (int k = 0; k < messages; ++k) {
    Json message;
    do {
      message = client.next();
      ASSERT_FALSE(message.is_null());
    } while (!message.contains("method") || message["method"] != "status");
    client.send(
        "robot.jog",
        {{"robot", "left"}, {"frame", "joint"}, {"velocity", {0.2, 0, 0, 0, 0}}, {"expiry_s", 1}});
  }
  EXPECT_TRUE(client.call("robot.stop").contains("result"));
  EXPECT_TRUE(client.call("watch", {{"rate_hz", 0}}).contains("result"));
}

TEST(Clients, fifty_hold_and_the_next_one_is_told_why_not) {
  WebCell cell({server::test::place("left", "learm", "bus")});
  WebClient mover(cell.port(), kOperatorToken);
  ASSERT_TRUE(mover.open());
  EXPECT_EQ(run(mover, server::test::kStand), "done");
  std::vector<std::unique_ptr<WebClient>> watchers;
  for (std::size_t k = 1; k < WebServer::kSocketsMax; ++k) {
    watchers.push_back(std::make_unique<WebClient>(cell.port(), kViewerToken));
    ASSERT_TRUE(watchers.back()->open()) << k;
    watchers.back()->send("watch", {{"rate_hz", 10}});
  }
  RawConnection late(cell.port());
  late.send(upgrade_text(cell.port(), kOperatorToken));
  const Answered refused = late.answer();
  EXPECT_EQ(refused.status, 503);
  EXPECT_TRUE(refused.body.contains("as many clients as it serves")) << refused.body;
  const double before = base_truth(mover);
  jog(mover, 20);
  EXPECT_GT(std::abs(base_truth(mover) - before), 0.05);
  for (const auto& watcher : watchers) {
    int statuses = 0;
    while (statuses < 5) {
      const Json message = watcher->next();
      ASSERT_FALSE(message.is_null());
      if (message.contains("method") && message["method"] == "status") ++statuses;
    }
  }
  // One goes, and there is room again.
  watchers.pop_back();
  bool open = false;
  for (int k = 0; k < 1000 && !open; ++k) open = WebClient(cell.port(), kViewerToken).open();
  EXPECT_TRUE(open);
}

TEST(Clients, heads_that_never_end_keep_nobody_out) {
  WebCell cell({server::test::place("left", "learm", "bus")});
  std::vector<RawConnection> slow;
  for (std::size_t k = 0; k < 3 * WebServer::kStrangersMax; ++k) {
    slow.emplace_back(cell.port());
    slow.back().send("GET / HTTP/1.1\r\nHost: 127");
  }
  WebClient client(cell.port(), kOperatorToken);
  ASSERT_TRUE(client.open());
  EXPECT_TRUE(client.call("robot.stop").contains("result"));
  // The oldest had to make room.
  EXPECT_TRUE(slow.front().ends());
}

TEST(Clients, heads_and_bodies_that_dawdle_end) {
  WebCell cell({server::test::place("left", "learm", "bus")});
  RawConnection head(cell.port());
  head.send("GET / HTTP/1.1\r\nHost:");
  RawConnection body(cell.port());
  body.send("POST /rpc HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(cell.port()) +
            "\r\nContent-Type: application/json\r\nAuthorization: Bearer " + kOperatorToken +
            "\r\nContent-Length: 100\r\n\r\n{");
  EXPECT_TRUE(head.ends());
  EXPECT_TRUE(body.ends());
}

/// What is asked and never read ends the client, not the server; the stop of another comes through.
TEST(Clients, who_asks_and_does_not_read_is_cut_off) {
  WebCell cell({server::test::place("left", "learm", "bus")});
  WebClient greedy(cell.port(), kViewerToken);
  ASSERT_TRUE(greedy.open());
  std::string requests;
  bool taken = true;
  // More than the server takes from anybody at once, so that it has answered some before.
  for (int k = 0; k < 200'000 && taken; ++k) {
    taken = greedy.raw().send_frame(server::request_text(1, "cell.describe", Json::object()));
  }
  EXPECT_FALSE(taken);
  WebClient other(cell.port(), kViewerToken);
  ASSERT_TRUE(other.open());
  EXPECT_TRUE(other.call("robot.stop").contains("result"));
}

/// Posts whose connections stay open: the next one finds a place all the same, and none is closed,
/// for its client may be sending just then.
TEST(Clients, who_has_posted_and_lingers_makes_room_and_may_post_again) {
  WebCell cell({server::test::place("left", "learm", "bus")});
  std::vector<RawConnection> posters;
  const auto stop = [&](RawConnection& poster) {
    const Answered answer = post(poster, cell.port(), kViewerToken, "robot.stop", Json::object());
    EXPECT_EQ(answer.status, 200) << answer.body;
    EXPECT_TRUE(answer.body.contains("\"result\"")) << answer.body;
  };
  for (std::size_t k = 0; k < 3 * WebServer::kPostersMax; ++k) {
    posters.emplace_back(cell.port());
    stop(posters.back());
  }
  for (int round = 0; round < 2; ++round) {
    for (RawConnection& poster : posters) stop(poster);
  }
}

/// Whoever moves something keeps his place before others that only ask.
TEST(Clients, who_holds_a_lease_is_the_last_to_make_room) {
  WebCell cell({server::test::place("left", "learm", "bus")});
  const auto took = [&](RawConnection& poster) {
    return post(poster, cell.port(), kOperatorToken, "lease.take", {{"robot", "left"}}).body;
  };
  RawConnection owner(cell.port());
  EXPECT_TRUE(took(owner).contains("result"));
  std::vector<RawConnection> watchers;
  for (std::size_t k = 0; k < 2 * WebServer::kPostersMax; ++k) {
    watchers.emplace_back(cell.port());
    const Answered told =
        post(watchers.back(), cell.port(), kViewerToken, "cell.status", Json::object());
    EXPECT_TRUE(told.body.contains("result")) << told.body;
  }
  RawConnection other(cell.port());
  EXPECT_TRUE(took(other).contains("error")) << "it is still his";
}

TEST(Clients, a_lease_ends_with_its_connection) {
  WebCell cell({server::test::place("left", "learm", "bus")});
  {
    WebClient first(cell.port(), kOperatorToken);
    ASSERT_TRUE(first.call("lease.take", {{"robot", "left"}}).contains("result"));
    WebClient second(cell.port(), kOperatorToken);
    EXPECT_TRUE(second.call("lease.take", {{"robot", "left"}}).contains("error"));
  }
  WebClient third(cell.port(), kOperatorToken);
  Json answer;
  for (int k = 0; k < 10'000 && !answer.contains("result"); ++k) {
    answer = third.call("lease.take", {{"robot", "left"}});
  }
  EXPECT_TRUE(answer.contains("result")) << answer.dump();
}

}  // namespace
}  // namespace sinew::test
