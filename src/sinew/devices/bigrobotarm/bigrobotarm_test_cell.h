#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <functional>
#include <utility>
#include <vector>

#include "sinew/devices/bigrobotarm/bigrobotarm_driver.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_machine.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_test_robot.h"

namespace sinew::test {

/// One direction of a serial line in virtual time: 250 000 baud, 40 us a byte.
class Lane {
 public:
  static constexpr Duration kByteTime = std::chrono::microseconds(40);

  /// Changes one byte into none, one or several.
  using Fault = std::function<std::vector<std::uint8_t>(std::uint8_t)>;

  void push(std::uint8_t byte, Instant now) {
    std::vector<std::uint8_t> bytes{byte};
    if (fault) bytes = fault(byte);
    for (const std::uint8_t one : bytes) {
      free_ = std::max(free_, now) + kByteTime;
      line_.push_back({one, free_ + delay});
    }
  }
  std::optional<Instant> next() const {
    return line_.empty() ? std::nullopt : std::optional(line_.front().arrives);
  }
  std::optional<std::uint8_t> take(Instant now) {
    if (line_.empty() || line_.front().arrives > now) return std::nullopt;
    const std::uint8_t byte = line_.front().value;
    line_.pop_front();
    return byte;
  }
  void clear() { line_.clear(); }

  Fault fault;
  Duration delay{};

 private:
  struct Flying {
    std::uint8_t value;
    Instant arrives;
  };
  std::deque<Flying> line_;
  Instant free_{};
};

/// A place to move to, rad.
inline constexpr std::array<double, 5> kThere{0.5, -0.2, 0.4, 0.3, -0.5};

/// Driver and machine back to back.
class BigRobotArmCell {
 public:
  explicit BigRobotArmCell(RobotModel model = big_robot_arm(),
                           BigRobotArmProfile profile = BigRobotArmProfile::kAsBuilt,
                           std::uint64_t seed = 1)
      : robot(std::move(model)),
        machine(robot, profile, device().dialect, seed, Instant{}),
        driver(device(), robot.joints) {}

  const BigRobotArmDevice& device() const { return robot.device.settings.get<BigRobotArmDevice>(); }

  /// Opened, and told where the arm really stands.
  void make_ready() {
    driver.open(now);
    run_until(DriverState::kReady);
    declare();
    events.clear();
    to_device.clear();
  }
  /// What whoever looks at the arm can say: its place within a full step.
  void declare() {
    const sim::Truth truth = machine.truth();
    std::array<JointPosition, 5> places{};
    for (std::size_t i = 0; i < 5; ++i) {
      const double q = truth.joints[i].q;
      places[i] = {PositionQuality::kCommanded, q, q, q};
    }
    driver.declare_positions(places);
  }

  /// @param look  called at every instant at which something happens
  void run_to(Instant end, const std::function<bool()>& look = {}) {
    exchange();
    for (int round = 0; round < 4'000'000; ++round) {
      if (look && look()) return;
      if (now >= end) return;
      // Not further than a tick of the arm while something moves.
      Instant next = std::min(end, now + std::chrono::milliseconds(idle() ? 1000 : 5));
      for (const auto& due :
           {machine.next_event(), driver.next_deadline(), to_machine.next(), to_host.next()}) {
        if (due) next = std::min(next, *due);
      }
      now = std::max(now, next);
      machine.advance(now);
      exchange();
      driver.poll(now);
      exchange();
    }
    FAIL() << "driver and machine keep each other awake";
  }
  void run(Duration duration) { run_to(now + duration); }
  void run_until(DriverState state, Duration limit = std::chrono::seconds(60)) {
    run_to(now + limit, [&] { return driver.state() == state; });
  }

  JointMove move_to(const std::array<double, 5>& q, Duration duration = {}) const {
    JointMove move;
    for (const double one : q) {
      move.q.push_back(one);
      move.qd.push_back(0);
    }
    move.duration = duration;
    return move;
  }

  /// The joint whose truth lies outside what is claimed, by how many full steps; -1: none.
  int liar() const {
    const sim::Truth truth = machine.truth();
    for (std::size_t i = 0; i < 5; ++i) {
      const JointPosition& claim = driver.positions()[i];
      const double q = truth.joints[i].q;
      if (claim.quality == PositionQuality::kLost) continue;
      if (q < claim.lower || q > claim.upper) return static_cast<int>(i);
    }
    return -1;
  }
  std::vector<DriverEvent::Kind> kinds() const {
    std::vector<DriverEvent::Kind> all;
    all.reserve(events.size());
    for (const DriverEvent& event : events) all.push_back(event.kind);
    return all;
  }
  int count(DriverEvent::Kind kind) const {
    return static_cast<int>(std::count_if(events.begin(), events.end(),
                                          [&](const auto& event) { return event.kind == kind; }));
  }

  RobotModel robot;
  sim::BigRobotArmMachine machine;
  BigRobotArmDriver driver;
  Lane to_machine;
  Lane to_host;
  bool cut = false;  ///< nothing arrives at either end
  Instant now{};
  std::vector<DriverEvent> events;
  std::vector<std::uint8_t> to_device;  ///< all that the host sent

 private:
  bool idle() const { return !machine.truth().moving && !to_machine.next() && !to_host.next(); }
  void exchange() {
    std::array<std::uint8_t, 64> piece{};
    while (const std::size_t count = driver.take_output(piece)) {
      for (std::size_t i = 0; i < count; ++i) {
        to_device.push_back(piece[i]);
        if (!cut) to_machine.push(piece[i], now);
      }
    }
    while (const auto byte = to_machine.take(now)) machine.receive({&*byte, 1}, now);
    while (const std::size_t count = machine.take_output(piece)) {
      for (std::size_t i = 0; i < count; ++i) {
        if (!cut) to_host.push(piece[i], now);
      }
    }
    while (const auto byte = to_host.take(now)) driver.receive({&*byte, 1}, now);
    while (const auto event = driver.take_event()) events.push_back(*event);
  }
};

}  // namespace sinew::test
