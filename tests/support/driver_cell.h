#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "sinew/driver/driver.h"
#include "sinew/model/robot_model.h"
#include "sinew/sim/link_fault.h"
#include "support/cosine_motion.h"

namespace sinew::test {

/// What is between a driver and its machine, and what the driver is fed with.
struct DriverCellLine {
  Duration step{};             ///< of virtual time
  std::size_t bytes_a_step{};  ///< that the wire carries, at most 64
  double segment = 0.02;       ///< s
  Duration late{};             ///< every byte comes so much later, either way
  bool echo = false;           ///< the adapter hears what it says
};

/// A streaming driver and its machine back to back in virtual time, with a faulty link between.
template <class Driver, class Machine>
class DriverCell {
 public:
  /// @param make_driver   of a robot
  /// @param make_machine  of a robot, and an instant
  DriverCell(const RobotModel& model, const DriverCellLine& line, const sim::LinkFaultSpec& faults,
             auto make_driver, auto make_machine)
      : robot(model),
        driver(make_driver(robot)),
        machine(make_machine(robot, now)),
        link(faults, now),
        line_(line) {}

  void open() {
    driver.open(now);
    EXPECT_TRUE(run_until(DriverState::kReady, std::chrono::seconds(20)));
    events.clear();
  }

  using Motion = CosineMotion;
  /// From where it stands.
  Motion motion_to(const JointVector& to, double seconds = 1) const {
    return {driver.positions(), to, seconds, line_.segment, now};
  }
  /// Feeds what the driver wants, until it wants no more of it.
  void feed(Motion& motion) {
    while (motion.next <= motion.segments && driver.wants_move(now)) {
      const auto taken = driver.move(motion.piece(), now);
      if (!taken) return static_cast<void>(refused = taken.error());
      ++motion.next;
    }
  }
  /// The motion to its end, or for so long.
  void run(Motion& motion, Duration limit = std::chrono::seconds(60)) {
    const Instant end = now + limit;
    while (now < end && !refused) {
      feed(motion);
      const bool over = motion.next > motion.segments && driver.state() != DriverState::kMoving;
      if (over || driver.state() == DriverState::kFault) return;
      step();
    }
  }
  void run_for(Duration duration) {
    const Instant end = now + duration;
    while (now < end) step();
  }
  bool run_until(DriverState state, Duration limit) {
    const Instant end = now + limit;
    while (now < end && driver.state() != state) step();
    return driver.state() == state;
  }
  /// The host does nothing for so long; its port goes on.
  void be_late_by(Duration duration) {
    away_ = true;
    run_for(duration);
    away_ = false;
  }

  std::size_t count(DriverEvent::Kind kind) const {
    return static_cast<std::size_t>(std::ranges::count(events, kind, &DriverEvent::kind));
  }
  std::optional<Error> failure() const {
    const auto failed = std::ranges::find(events, DriverEvent::Kind::kFailed, &DriverEvent::kind);
    return failed == events.end() ? std::nullopt : std::optional(failed->error);
  }
  double q(std::size_t joint) const { return machine.truth().joints[joint].q; }
  /// Every position that is claimed holds the truth.
  void expect_honest() const {
    if (::testing::Test::HasFailure()) return;
    const auto truth = machine.truth();
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      const JointPosition& claim = driver.positions()[i];
      if (claim.quality == PositionQuality::kLost) continue;
      ASSERT_GE(truth.joints[i].q, claim.lower - 1e-9)
          << i << " at " << to_seconds(now - Instant{});
      ASSERT_LE(truth.joints[i].q, claim.upper + 1e-9)
          << i << " at " << to_seconds(now - Instant{});
    }
  }

  void step() {
    now += line_.step;
    machine.advance(now);
    std::array<std::uint8_t, 512> given{};
    const std::size_t more = connected && !away_ ? driver.take_output(given) : 0;
    port_.insert(port_.end(), given.begin(), given.begin() + static_cast<std::ptrdiff_t>(more));
    std::array<std::uint8_t, 64> bytes{};
    const std::size_t out = std::min(port_.size(), line_.bytes_a_step);
    std::copy_n(port_.begin(), out, bytes.begin());
    port_.erase(port_.begin(), port_.begin() + static_cast<std::ptrdiff_t>(out));
    carry(down_, std::span(bytes).first(link_down ? 0 : out), sim::LinkDirection::kToDevice);
    if (line_.echo && out > 0) driver.receive(std::span(bytes).first(out), now);
    std::array<std::uint8_t, 64> piece{};
    while (const std::size_t n = link.take(sim::LinkDirection::kToDevice, now, piece)) {
      machine.receive(std::span(piece).first(n), now);
    }
    const std::size_t back = machine.take_output(std::span(bytes).first(line_.bytes_a_step));
    carry(up_, std::span(bytes).first(back), sim::LinkDirection::kToHost);
    while (const std::size_t n = link.take(sim::LinkDirection::kToHost, now, piece)) {
      if (connected) waiting_.insert(waiting_.end(), piece.begin(), piece.begin() + n);
    }
    if (away_) return;
    driver.receive(waiting_, now);
    waiting_.clear();
    driver.poll(now);
    while (const auto event = driver.take_event()) events.push_back(*event);
    if (honest) expect_honest();
    const auto truth = machine.truth();
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      fastest = std::max(fastest, std::abs(truth.joints[i].qd) / robot.joints[i].velocity_max);
    }
  }

  RobotModel robot;
  Instant now{};
  Driver driver;
  Machine machine;
  sim::LinkFaults link;
  bool connected = true;
  bool link_down = false;  ///< what the host sends vanishes
  bool honest = true;      ///< looked at in each step
  double fastest = 0;      ///< of any joint, as a share of its limit
  std::optional<Error> refused;
  std::vector<DriverEvent> events;

 private:
  struct Late {
    Instant at;
    std::vector<std::uint8_t> bytes;
  };

  void carry(std::deque<Late>& line, std::span<const std::uint8_t> bytes,
             sim::LinkDirection direction) {
    if (!bytes.empty()) line.push_back({now + line_.late, {bytes.begin(), bytes.end()}});
    while (!line.empty() && line.front().at <= now) {
      link.push(direction, line.front().bytes, now);
      line.pop_front();
    }
  }

  DriverCellLine line_;
  bool away_ = false;
  std::deque<std::uint8_t> port_;      ///< given to it, not on the wire yet
  std::vector<std::uint8_t> waiting_;  ///< at the host's port
  std::deque<Late> down_, up_;
};

}  // namespace sinew::test
