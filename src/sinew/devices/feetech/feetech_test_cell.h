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
#include "sinew/devices/feetech/feetech_driver.h"
#include "sinew/devices/feetech/feetech_machine.h"
#include "sinew/sim/link_fault.h"
#include "support/cosine_motion.h"

namespace sinew::test {

/// Three joints that turn, the second one against its servo, and jaws.
inline RobotModel feetech_robot(FeetechSeries series = FeetechSeries::kSts) {
  RobotModel robot;
  robot.id = "servos";
  SerialGeometry geometry;
  FeetechDevice device;
  device.series = series;
  const bool sts = series == FeetechSeries::kSts;
  for (int i = 0; i < 3; ++i) {
    geometry.rows.push_back({i == 0 ? 0.1 : 0, i == 0 ? 0 : 0.1, i == 0 ? -kPi / 2 : 0, 0});
    Joint joint;
    joint.name = std::string("abc").substr(static_cast<std::size_t>(i), 1);
    joint.lower = -1.5;
    joint.upper = 1.5;
    joint.velocity_max = from_deg(180);
    joint.acceleration_max = from_deg(900);
    joint.jerk_max = from_deg(9000);
    robot.joints.push_back(joint);
    device.servos.push_back(
        {static_cast<std::uint8_t>(i + 1), sts ? 2048.0 : 512.0, i == 1 ? -1.0 : 1.0, 1.0});
  }
  device.gripper = {6, sts ? 3200.0 : 800.0, sts ? 2030.0 : 510.0, sts ? 0.5 : 1};
  geometry.gripper = JawGripper{0.05, 0.1, 0.1};
  robot.geometry = geometry;
  robot.device.protocol = "feetech";
  robot.device.baud = 1'000'000;
  robot.device.capability = {.motion = MotionKind::kStream,
                             .feedback = PositionFeedback::kMeasured,
                             .segment = std::chrono::milliseconds(20),
                             .hand = HandDrive::kJaws,
                             .free_drive = true};
  robot.device.settings = device;
  return robot;
}

/// rad that a servo is off its goal by the weight of such an arm, its dead band, and rounding.
inline constexpr double kFeetechSag = 0.05;

struct FeetechCellOptions {
  sim::LinkFaultSpec faults{};
  bool opened = true;
  Duration late{};    ///< every byte comes so much later, either way
  bool echo = false;  ///< the adapter hears what it says
};

/// Driver and machine back to back in virtual time, with a megabaud and a faulty link between.
class FeetechCell {
 public:
  using Options = FeetechCellOptions;

  explicit FeetechCell(const RobotModel& model = feetech_robot(), const Options& options = {})
      : robot(model),
        driver(robot.device.settings.get<FeetechDevice>(), robot.joints,
               std::get<SerialGeometry>(robot.geometry).gripper),
        machine(robot, 5, now),
        link(options.faults, now),
        options_(options) {
    if (options.opened) open();
  }

  void open() {
    driver.open(now);
    EXPECT_TRUE(run_until(DriverState::kReady, std::chrono::seconds(20)));
    events.clear();
  }
  sim::FeetechServo& servo(std::size_t i) { return machine.bus().servo(i); }

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

  /// The host does nothing for so long; its port goes on.
  void be_late_by(Duration duration) {
    away_ = true;
    run_for(duration);
    away_ = false;
  }

  void step() {
    now += std::chrono::microseconds(100);  // ten bytes
    machine.advance(now);
    std::array<std::uint8_t, 512> given{};
    const std::size_t more = connected && !away_ ? driver.take_output(given) : 0;
    port_.insert(port_.end(), given.begin(), given.begin() + static_cast<std::ptrdiff_t>(more));
    std::array<std::uint8_t, 10> bytes{};
    const std::size_t out = std::min(port_.size(), bytes.size());
    std::copy_n(port_.begin(), out, bytes.begin());
    port_.erase(port_.begin(), port_.begin() + static_cast<std::ptrdiff_t>(out));
    carry(down_, std::span(bytes).first(out), sim::LinkDirection::kToDevice);
    if (options_.echo && out > 0) driver.receive(std::span(bytes).first(out), now);
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
    const auto truth = machine.truth();
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      fastest = std::max(fastest, std::abs(truth.joints[i].qd) / robot.joints[i].velocity_max);
    }
  }

  RobotModel robot;
  Instant now{};
  FeetechDriver driver;
  sim::FeetechMachine machine;
  sim::LinkFaults link;
  bool connected = true;
  bool honest = true;  ///< looked at in each step
  double fastest = 0;  ///< of any joint, as a share of its limit
  std::optional<Error> refused;
  std::vector<DriverEvent> events;

 private:
  struct Late {
    Instant at;
    std::vector<std::uint8_t> bytes;
  };

  void carry(std::deque<Late>& line, std::span<const std::uint8_t> bytes,
             sim::LinkDirection direction) {
    if (!bytes.empty()) line.push_back({now + options_.late, {bytes.begin(), bytes.end()}});
    while (!line.empty() && line.front().at <= now) {
      link.push(direction, line.front().bytes, now);
      line.pop_front();
    }
  }

  Options options_;
  bool away_ = false;
  std::deque<std::uint8_t> port_;      ///< given to it, not on the wire yet
  std::vector<std::uint8_t> waiting_;  ///< at the host's port
  std::deque<Late> down_, up_;
};

}  // namespace sinew::test
