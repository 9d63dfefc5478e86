#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/devices/grbl/grbl_driver.h"
#include "sinew/devices/grbl/grbl_machine.h"
#include "sinew/sim/link_fault.h"
#include "support/cosine_motion.h"

namespace sinew::test {

/// Joints that turn, every second one the other way round on the wire.
inline RobotModel grbl_robot(std::size_t joints = 3, bool homes = false) {
  RobotModel robot;
  robot.id = "grbl";
  SerialGeometry geometry;
  GrblDevice device;
  device.homes = homes;
  for (std::size_t i = 0; i < joints; ++i) {
    geometry.rows.push_back({0.1, 0.1, 0, 0});
    Joint joint;
    joint.name = std::string("abcdef").substr(i, 1);
    joint.lower = -1.5;
    joint.upper = 2;
    joint.velocity_max = from_deg(90);
    joint.acceleration_max = from_deg(400);
    joint.jerk_max = from_deg(4000);
    robot.joints.push_back(joint);
    const double steps = 3200 * 10 / (2 * kPi);
    device.axes.push_back({i % 2 == 0 ? steps : -steps, homes ? 0.3 : 0.0, i % 2 == 0});
  }
  robot.geometry = geometry;
  robot.device.protocol = "grbl";
  robot.device.baud = 115'200;
  robot.device.capability = {.motion = MotionKind::kStream,
                             .feedback = PositionFeedback::kCommanded,
                             .segment = std::chrono::milliseconds(50)};
  robot.device.settings = device;
  return robot;
}

/// rad: a step of such a robot and a digit of its wire.
inline constexpr double kGrblStep = 2 * kPi / 32'000 + from_deg(1e-3);

/// Driver and machine back to back in virtual time, with 115,200 baud and a faulty link between.
class GrblCell {
 public:
  explicit GrblCell(const RobotModel& model = grbl_robot(), const sim::LinkFaultSpec& faults = {},
                    bool opened = true)
      : robot(model),
        driver(robot.device.settings.get<GrblDevice>(), robot.joints, robot.device.baud),
        machine(robot, now),
        link(faults, now) {
    if (opened) open();
  }

  void open(bool declared = true) {
    driver.open(now);
    EXPECT_TRUE(run_until(DriverState::kReady, std::chrono::seconds(20)));
    if (declared) declare();
    events.clear();
  }
  /// Where the machine really is.
  void declare() {
    std::vector<JointPosition> all;
    for (const sim::JointTruth& joint : machine.truth().joints) {
      all.push_back({PositionQuality::kCommanded, joint.q, joint.q - 1e-6, joint.q + 1e-6});
    }
    driver.declare_positions(all);
  }

  using Motion = CosineMotion;
  /// From where it stands, in segments of 50 ms.
  Motion motion_to(const JointVector& to, double seconds = 1) const {
    return {driver.positions(), to, seconds, 0.05, now};
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
  std::size_t count(DriverEvent::Kind kind) const {
    return static_cast<std::size_t>(std::ranges::count(events, kind, &DriverEvent::kind));
  }
  double q(std::size_t joint) const { return machine.truth().joints[joint].q; }
  /// Every position that is claimed holds the truth.
  void expect_honest() const {
    const auto truth = machine.truth();
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      const JointPosition& claim = driver.positions()[i];
      if (claim.quality == PositionQuality::kLost) continue;
      ASSERT_GE(truth.joints[i].q, claim.lower - 1e-9) << i;
      ASSERT_LE(truth.joints[i].q, claim.upper + 1e-9) << i;
    }
  }

  void step() {
    now += std::chrono::milliseconds(1);
    machine.advance(now);
    std::array<std::uint8_t, 11> bytes{};
    const std::size_t out = connected ? driver.take_output(bytes) : 0;
    link.push(sim::LinkDirection::kToDevice, std::span(bytes).first(out), now);
    std::array<std::uint8_t, 64> piece{};
    while (const std::size_t n = link.take(sim::LinkDirection::kToDevice, now, piece)) {
      machine.receive(std::span(piece).first(n), now);
    }
    const std::size_t back = machine.take_output(bytes);
    link.push(sim::LinkDirection::kToHost, std::span(bytes).first(back), now);
    while (const std::size_t n = link.take(sim::LinkDirection::kToHost, now, piece)) {
      if (connected) driver.receive(std::span(piece).first(n), now);
    }
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
  GrblDriver driver;
  sim::GrblMachine machine;
  sim::LinkFaults link;
  bool connected = true;
  bool honest = true;  ///< looked at in each step
  double fastest = 0;  ///< of any joint, as a share of its limit
  std::optional<Error> refused;
  std::vector<DriverEvent> events;
};

}  // namespace sinew::test
