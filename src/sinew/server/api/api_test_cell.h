#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sinew/io/clock.h"
#include "sinew/runtime/links/robot_variant.h"
#include "sinew/server/api/api.h"
#include "support/robots.h"

namespace sinew::server::test {

/// Where the LeArm stands clear of itself and of the table.
inline const std::string kStand =
    "joint base=0deg shoulder=20deg elbow=40deg wrist=40deg roll=0deg";

/// A cell of simulated robots and the Api over it, in real threads; time runs `scale` times as
/// fast, with sanitizers half of that.
class ApiCell {
 public:
  explicit ApiCell(const std::vector<CellRobot>& robots, double scale = 20,
                   const runtime::CellFolders& folders = {},
                   const std::vector<CellObject>& objects = {},
                   runtime::CellSettings* settings = nullptr, const std::string& event_file = {},
                   const Cell& table = {}) {
#ifdef __SANITIZE_ADDRESS__
    scale /= 2;
#endif
    Cell cell{.title = "test",
              .time_scale = scale,
              .robots = robots,
              .objects = objects,
              .cameras = table.cameras,
              .baskets = table.baskets,
              .cubes = table.cubes};
    // Those that nobody has placed stand beside each other, out of reach.
    for (std::size_t i = 0; i < robots.size(); ++i) {
      if (robots[i].X_WB.p == Vec3{}) cell.robots[i].X_WB.p.x = 3 * static_cast<double>(i);
    }
    std::vector<RobotModel> models;
    for (const CellRobot& robot : robots) {
      models.push_back(
          *runtime::variant_of(sinew::test::robot(robot.robot), robot.profile, robot.wire));
    }
    auto running = runtime::RunningCell::start(cell, std::move(models), folders);
    if (!running) {
      ADD_FAILURE() << running.error().sentence;
      return;
    }
    cell_ = std::move(*running);
    api_ = std::make_unique<Api>(*cell_, "test", settings, event_file);
  }

  Api& api() { return *api_; }
  runtime::RunningCell& cell() { return *cell_; }
  Instant now() const { return clock_.now(); }

  /// One turn of the server.
  void turn() {
    while (api_->work(clock_.now())) {
    }
    api_->poll(clock_.now());
    clock_.pause(std::chrono::milliseconds(2));
  }
  /// Turns until `done`, for 90 s at most. @return whether it was
  template <class Done>
  bool until(const Done& done) {
    const Instant end = clock_.now() + std::chrono::seconds(90);
    while (!done()) {
      if (clock_.now() > end) return false;
      turn();
    }
    return true;
  }

 private:
  io::Clock clock_;
  std::unique_ptr<runtime::RunningCell> cell_;
  std::unique_ptr<Api> api_;
};

/// A client of it, in the test's own thread. It stays alive while it calls.
class ApiClient {
 public:
  explicit ApiClient(ApiCell& cell, Role role = Role::kOperator)
      : cell_(cell), id_(*cell.api().open(role)) {}
  ~ApiClient() { leave(); }
  ApiClient(const ApiClient&) = delete;
  ApiClient& operator=(const ApiClient&) = delete;

  void leave() {
    if (id_ != 0) cell_.api().close(id_);
    id_ = 0;
  }
  SessionId id() const { return id_; }

  void send(std::string_view method, const Json& params = Json::object()) {
    cell_.api().receive(id_, request_text(++last_, method, params), cell_.now());
  }
  /// What came of a request; a message {"result"} or {"error"}.
  Json call(std::string_view method, const Json& params = Json::object()) {
    send(method, params);
    Json answer;
    const std::uint64_t wanted = last_;
    const bool came = cell_.until([&] {
      while (const auto text = cell_.api().take_output(id_)) {
        Json message = Json::parse(*text);
        if (message.contains("id") && message["id"] == wanted) {
          answer = std::move(message);
          return true;
        }
        if (message.contains("method")) messages_.push_back(std::move(message));
      }
      return false;
    });
    EXPECT_TRUE(came) << method << ": no answer";
    return answer;
  }
  std::string sentence(std::string_view method, const Json& params = Json::object()) {
    const Json answer = call(method, params);
    return answer.contains("error") ? std::string(answer["error"]["message"]) : std::string();
  }
  Json status(const std::string& robot) {
    return call("robot.status", {{"robot", robot}})["result"];
  }
  /// Until the job of this robot is over, renewing its lease; the job as it ended.
  Json finish(const std::string& robot) {
    Json job;
    const bool over = cell_.until([&] {
      job = call("job.status", {{"robot", robot}})["result"];
      return job["over"].get<bool>();
    });
    EXPECT_TRUE(over) << job.dump();
    return job;
  }
  Json run(const std::string& robot, const std::string& text) {
    const Json started = call("program.run", {{"robot", robot}, {"text", text}});
    EXPECT_TRUE(started.contains("result")) << started.dump();
    return finish(robot);
  }
  std::vector<Json>& messages() { return messages_; }
  void take_messages() {
    while (const auto text = cell_.api().take_output(id_)) {
      messages_.push_back(Json::parse(*text));
    }
  }

 private:
  ApiCell& cell_;
  SessionId id_;
  std::uint64_t last_ = 0;
  std::vector<Json> messages_;
};

inline double truth_deg(ApiClient& client, const std::string& robot, std::size_t joint) {
  const Json truth = client.call("simulation.truth", {{"robot", robot}})["result"];
  return to_deg(truth["joints"][joint]["position_rad"].get<double>());
}

inline CellRobot place(const std::string& name, const std::string& robot,
                       const std::optional<std::string>& profile = {},
                       const std::optional<std::string>& wire = {}) {
  CellRobot one;
  one.name = name;
  one.robot = robot;
  one.profile = profile;
  one.wire = wire;
  return one;
}

}  // namespace sinew::server::test
