#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "sinew/control/local_machine.h"
#include "sinew/core/error_code.h"
#include "sinew/program/runs/program_run.h"
#include "support/robots.h"

/// A program on a driver that does what it is told, for tests of runs.
namespace sinew::program {

using namespace std::chrono_literals;
using Phase = Run::Phase;
using Kind = DriverEvent::Kind;

/// Does what it is told in exactly the time it is told, one segment ahead.
class PlainDriver : public Driver {
 public:
  explicit PlainDriver(JointVector q) {
    for (const double value : q) {
      positions_.push_back({PositionQuality::kCommanded, value, value, value});
    }
  }

  void open(Instant /*now*/) override {
    closed_ = false;
    if (!in_doubt_) tell(Kind::kReady);
  }
  void close(Instant /*now*/) override { closed_ = true; }
  std::optional<Error> fault() const override { return gave_up_; }
  DriverState state() const override {
    if (closed_) return DriverState::kClosed;
    if (gave_up_) return DriverState::kFault;
    if (in_doubt_) return DriverState::kOpening;
    return moves_.empty() ? DriverState::kReady : DriverState::kMoving;
  }
  std::span<const JointPosition> positions() const override { return positions_; }
  DriverHealth health() const override { return {}; }
  bool wants_move(Instant /*now*/) const override { return !in_doubt_ && moves_.size() < 2; }
  Expected<void> move(const JointMove& move, Instant now) override {
    if (refuse_) return std::unexpected(*refuse_);
    if (in_doubt_) return std::unexpected(Error{ErrorCode::kBusy});
    const Instant start = moves_.empty() ? now : moves_.back().end;
    moves_.push_back({move, start + move.duration});
    taken_.push_back(move);
    return {};
  }
  void stop(Instant /*now*/) override {
    moves_.clear();
    tell(Kind::kStopped);
  }
  Expected<void> home(Instant /*now*/, std::uint8_t joints) override {
    homings_.push_back(joints);
    for (JointPosition& position : positions_) {
      if (!homes_nowhere_) position = {PositionQuality::kMeasured, homed_, homed_, homed_};
      if (homed_from_) position = {PositionQuality::kUncertain, homed_, *homed_from_, homed_};
    }
    if (homes_by_itself_) tell(Kind::kDone);
    return {};
  }
  Expected<void> tool(const ToolAction& action, Instant /*now*/) override {
    ++tools_;
    tool_ = action;
    tell(Kind::kDone);
    return {};
  }
  void poll(Instant now) override {
    while (!moves_.empty() && moves_.front().end <= now) {
      for (std::size_t i = 0; i < positions_.size(); ++i) {
        const double q = moves_.front().move.q[i];
        positions_[i] = {PositionQuality::kCommanded, q, q, q};
      }
      moves_.pop_front();
      tell(Kind::kDone);
    }
  }
  std::optional<Instant> next_deadline() const override {
    return moves_.empty() ? std::nullopt : std::optional(moves_.front().end);
  }
  std::optional<DriverEvent> take_event() override {
    if (events_.empty()) return std::nullopt;
    const DriverEvent event = events_.front();
    events_.pop_front();
    return event;
  }

  void tell(Kind kind, Error error = {}) { events_.push_back({kind, error}); }
  void lose() {
    for (JointPosition& position : positions_) position.quality = PositionQuality::kLost;
  }

  struct Timed {
    JointMove move;
    Instant end;
  };
  std::vector<JointPosition> positions_;
  std::deque<Timed> moves_;
  std::vector<JointMove> taken_;
  std::deque<DriverEvent> events_;
  std::optional<Error> refuse_;
  double homed_ = 0;
  std::vector<std::uint8_t> homings_;  ///< joints of each search
  std::optional<double> homed_from_;   ///< somewhere between there and homed_
  bool homes_by_itself_ = true;
  bool homes_nowhere_ = false;
  std::optional<Error> gave_up_;
  bool closed_ = true;
  bool in_doubt_ = false;
  int tools_ = 0;
  ToolAction tool_;  ///< the last one
};

inline JointVector at(const RobotModel& robot, double q) {
  JointVector all;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) all.push_back(q);
  return all;
}

struct PlainCell {
  PlainCell(std::string_view id, std::string_view text) : PlainCell(test::robot(id), text) {}
  PlainCell(const RobotModel& model, std::string_view text)
      : robot(model),
        program(*parse(text, "p", robot)),
        driver(at(robot, 0)),
        controller(robot, driver, {.gap = 1h, .lease_life = 1h}, {}),
        machine(controller, 1),
        run(program, machine) {}

  /// One instant: all that follows from each other in it.
  void step() {
    do {
      const control::Inputs inputs{.commands = machine.commands(now)};
      machine.take(controller.step(inputs, now));
      run.poll(now);
    } while (machine.has_commands());
  }
  void start() {
    run.start(now);
    step();
    step();
  }
  /// Runs until it is over, or for an hour of its own time.
  void go(Duration limit = 1h) {
    if (run.phase() == Phase::kOpening) run.start(now);
    while (!run.finished() && now < Instant{} + limit) {
      driver.poll(now);
      step();
      now += 1ms;
    }
  }

  RobotModel robot;
  Program program;
  PlainDriver driver;
  control::Controller controller;
  control::LocalMachine machine;
  Run run;
  Instant now{};
};

}  // namespace sinew::program
