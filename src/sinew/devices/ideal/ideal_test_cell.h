#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/devices/ideal/ideal_driver.h"
#include "sinew/devices/ideal/ideal_machine.h"
#include "sinew/sim/link_fault.h"
#include "support/cosine_motion.h"

namespace sinew::test {

/// Three joints that turn, and jaws.
inline RobotModel ideal_robot() {
  RobotModel robot;
  robot.id = "three";
  SerialGeometry geometry;
  for (int i = 0; i < 3; ++i) geometry.rows.push_back({0.1, 0.1, 0, 0});
  geometry.gripper = JawGripper{0.04, 0.1, 0.1};
  robot.geometry = geometry;
  for (int i = 0; i < 3; ++i) {
    Joint joint;
    joint.name = std::string("abc").substr(static_cast<std::size_t>(i), 1);
    joint.lower = -2;
    joint.upper = 2 + i;
    joint.velocity_max = 2;
    joint.acceleration_max = 8;
    joint.jerk_max = 80;
    robot.joints.push_back(joint);
  }
  return robot;
}

/// Driver and machine back to back in virtual time, with a megabaud and a faulty link between.
class IdealCell {
 public:
  /// @param late  every byte comes so much later, either way
  explicit IdealCell(const sim::LinkFaultSpec& faults = {}, bool opened = true, Duration late = {},
                     const RobotModel& model = ideal_robot())
      : robot(model),
        driver(robot.joints, std::get<SerialGeometry>(robot.geometry).gripper, 1'000'000),
        machine(robot, now),
        link(faults, now),
        late_(late) {
    if (opened) open();
  }

  void open() {
    driver.open(now);
    EXPECT_TRUE(run_until(DriverState::kReady, std::chrono::seconds(20)));
    events.clear();
  }

  using Motion = CosineMotion;
  /// From where it stands, in segments of 20 ms.
  Motion motion_to(const JointVector& to, double seconds = 1) const {
    return {driver.positions(), to, seconds, 0.02, now};
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
  void run(Motion& motion, Duration limit) {
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
  std::size_t count(DriverEvent::Kind kind) const {
    return static_cast<std::size_t>(std::ranges::count(events, kind, &DriverEvent::kind));
  }
  /// Every position that is claimed holds the truth.
  void expect_honest() const {
    const auto truth = machine.truth();
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      const JointPosition& claim = driver.positions()[i];
      if (claim.quality == PositionQuality::kLost) continue;
      EXPECT_GE(truth.joints[i].q, claim.lower - 1e-9) << i;
      EXPECT_LE(truth.joints[i].q, claim.upper + 1e-9) << i;
    }
  }

  /// The host does nothing for so long; its port goes on.
  void host_away(Duration duration) {
    away_ = true;
    run_for(duration);
    away_ = false;
  }

  void step() {
    now += std::chrono::microseconds(100);  // ten bytes
    machine.advance(now);
    std::array<std::uint8_t, 10> bytes{};
    const std::size_t out = connected ? driver.take_output(bytes) : 0;
    carry(down_, std::span(bytes).first(link_down ? 0 : out), sim::LinkDirection::kToDevice);
    std::array<std::uint8_t, 64> piece{};
    while (const std::size_t n = link.take(sim::LinkDirection::kToDevice, now, piece)) {
      machine.receive(std::span(piece).first(n), now);
    }
    const std::size_t back = machine.take_output(bytes);
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
  }

  RobotModel robot;
  Instant now{};
  IdealDriver driver;
  sim::IdealMachine machine;
  sim::LinkFaults link;
  bool connected = true;
  bool link_down = false;  ///< what the host sends vanishes
  bool honest = true;      ///< looked at in each step
  std::optional<Error> refused;
  std::vector<DriverEvent> events;

 private:
  struct Late {
    Instant at;
    std::vector<std::uint8_t> bytes;
  };

  void carry(std::deque<Late>& line, std::span<const std::uint8_t> bytes,
             sim::LinkDirection direction) {
    if (!bytes.empty()) line.push_back({now + late_, {bytes.begin(), bytes.end()}});
    while (!line.empty() && line.front().at <= now) {
      link.push(direction, line.front().bytes, now);
      line.pop_front();
    }
  }

  Duration late_;
  bool away_ = false;
  std::deque<Late> down_, up_;
  std::vector<std::uint8_t> waiting_;  ///< at the host's port
};

}  // namespace sinew::test
