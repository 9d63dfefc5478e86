#include "sinew/server/api/demonstration.h"

#include <algorithm>

#include "sinew/config/builtin_robots.h"
#include "sinew/model/error_sentence.h"
#include "sinew/program/plans/cube_rows.h"
#include "sinew/server/json/json_rpc.h"

namespace sinew::server {
namespace {

/// A lease lives for a second; whoever speaks keeps it.
constexpr Duration kTurn = std::chrono::milliseconds(200);
constexpr Duration kPause = std::chrono::seconds(1);
constexpr Duration kRetry = std::chrono::seconds(5);
constexpr Duration kPaused = std::chrono::seconds(8);
constexpr double kRide = 20;  // s

std::string_view program_of(const std::string& robot) {
  const auto found = std::ranges::find(builtin_robots(), robot, &BuiltinRobot::id);
  return found != builtin_robots().end() ? found->demonstration : std::string_view();
}

/// Where the end stops are known already, the row behind `home`; nothing where there is no such
/// row.
std::optional<int> behind_home(std::string_view text) {
  int line = 1;
  while (!text.empty()) {
    const std::string_view row = text.substr(0, text.find('\n'));
    if (row == "home") return line + 1;
    ++line;
    text.remove_prefix(std::min(text.size(), row.size() + 1));
  }
  return std::nullopt;
}

/// The robot that picks and stands nearest to the simulated table.
std::optional<std::size_t> sorter_of(const runtime::RunningCell& cell) {
  constexpr double kNear = 0.5;  // m
  const CellCamera* camera = cell.cell().simulated_camera();
  if (camera == nullptr) return std::nullopt;
  std::optional<std::size_t> nearest;
  double least = kNear;
  for (std::size_t i = 0; i < cell.size(); ++i) {
    const double far = norm(cell.cell().robots[i].X_WB.p - camera->X_WT.p);
    if (far >= least || !program::can_pick(cell.station(i).robot())) continue;
    nearest = i;
    least = far;
  }
  return nearest;
}

/// Empty where this robot has no cubes to sort, or nothing to sort them into.
std::string rows_to_sort(const runtime::RunningCell& cell, std::size_t robot) {
  const auto& baskets = cell.cell().baskets;
  if (baskets.empty() || sorter_of(cell) != robot) return {};
  return "repeat while seen\n  pick\n  place " + baskets.front().name + "\nend\n";
}

}  // namespace

Demonstration::Demonstration(Api& api, const runtime::RunningCell& cell)
    : api_(api), cell_(cell), session_(api.open(Role::kOperator, Delivery::kAnswersOnly)) {
  for (std::size_t i = 0; i < cell.size(); ++i) {
    const runtime::Station& station = cell.station(i);
    // A demonstration that nobody expects is for machines that are none.
    parts_.push_back({.robot = station.name(),
                      .time_scale = station.clock().scale(),
                      .plays = station.simulated(),
                      .job = cell.jobs(i).view().id,
                      .rides = program_of(station.robot().id).empty(),
                      .sorts = rows_to_sort(cell, i)});
  }
  take_picture();
  if (session_) api_.yield(*session_);
}

/// How long the next round takes is predicted with the cubes in it.
void Demonstration::take_picture() {
  for (std::size_t i = 0; i < cell_.cell().cameras.size(); ++i) {
    if (runtime::Camera* camera = cell_.camera(i)) camera->refresh();
  }
}

void Demonstration::poll(Instant now) {
  if (over()) return;
  take_answers();
  if (now < next_) return;
  next_ = now + kTurn;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (parts_[i].plays) look_at(i, now);
  }
  if (over()) return;
  api_.receive(*session_, request_text(0, "lease.renew", {{"robot", parts_.front().robot}}), now);
}

void Demonstration::end() {
  if (!over()) api_.close(*session_);
}

bool Demonstration::shown() const {
  return std::ranges::all_of(parts_,
                             [](const Part& part) { return !part.plays || part.rounds > 0; });
}

void Demonstration::look_at(std::size_t robot, Instant now) {
  Part& part = parts_[robot];
  const runtime::JobView job = cell_.jobs(robot).view();
  if (!job.over) {
    part.progress = job.progress;
    part.duration = job.duration;
    go_on(robot, job, now);
    return;
  }
  if (job.id != part.job) {
    part.job = job.id;
    const bool done = job.phase == program::Run::Phase::kDone;
    part.rounds += done ? 1 : 0;
    part.failures = done ? 0 : part.failures + 1;
    part.progress = done ? 1 : part.progress;
    if (job.failure) part.trouble = sentence_of(job.failure->error, cell_.station(robot).robot());
    if (done) part.trouble.clear();
    part.due = now + (done ? kPause : kRetry);
    if (!part.sorts.empty()) cell_.table()->begin_again();
    take_picture();
  }
  if (part.failures >= kFailuresMax) part.plays = false;
  if (part.plays && now >= part.due) begin_round(robot, now);
}

/// What its camera has paused goes on by itself: a demonstration has no person who does it, and its
/// machines are simulated.
void Demonstration::go_on(std::size_t robot, const runtime::JobView& job, Instant now) {
  Part& part = parts_[robot];
  if (!job.paused || !job.paused_by) {
    part.pauses = {};
    return;
  }
  if (part.pauses == Instant{}) part.pauses = now;
  if (now - part.pauses < kPaused) return;
  part.pauses = now;
  api_.receive(*session_, request_text(0, "robot.resume", {{"robot", part.robot}}), now);
}

void Demonstration::begin_round(std::size_t robot, Instant now) {
  const runtime::Station& station = cell_.station(robot);
  Part& part = parts_[robot];
  part.due = now + kRetry;
  const auto state = station.view().state;
  if (state == control::MachineState::kFault) {
    api_.receive(*session_, request_text(0, "robot.acknowledge", {{"robot", station.name()}}), now);
    part.due = now + kPause;
    return;
  }
  Json wish{{"robot", station.name()}};
  if (part.rides) {
    wish["duration_s"] = kRide;
    wish["seed"] = part.rounds + 1;
  } else {
    const std::string_view text = program_of(station.robot().id);
    wish["text"] = std::string(text) + part.sorts;
    wish["name"] = "demonstration";
    const auto line = behind_home(text);
    if (part.rounds > 0 && line) wish["from_line"] = *line;
  }
  const char* method = part.rides ? "robot.bullride" : "program.run";
  api_.receive(*session_, request_text(static_cast<std::int64_t>(robot) + 1, method, wish), now);
}

void Demonstration::take_answers() {
  while (const auto text = api_.take_output(*session_)) {
    const Json answer = Json::parse(*text, nullptr, false);
    if (!answer.contains("error") || !answer["id"].is_number_unsigned()) continue;
    const auto id = answer["id"].get<std::size_t>();
    if (id == 0 || id > parts_.size()) continue;
    Part& part = parts_[id - 1];
    part.trouble = answer["error"]["message"].get<std::string>();
    // A variant of the robot that its program does not suit.
    if (part.rides) ++part.failures;
    part.rides = true;
  }
}

}  // namespace sinew::server
