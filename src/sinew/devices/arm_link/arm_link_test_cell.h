#pragma once

#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "sinew/devices/arm_link/arm_link_device.h"
#include "sinew/devices/arm_link/arm_link_driver.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_test_robot.h"

namespace sinew::test {

/// Driver and board back to back, with the port's own speed.
class ArmLinkCell {
 public:
  explicit ArmLinkCell(const ArmLinkTiming& timing = {})
      : robot(big_robot_arm()),
        board(robot.device.settings.get<BigRobotArmDevice>(), Instant{}),
        driver(device(), robot.joints, timing) {}

  ArmLinkDevice device() const {
    ArmLinkDevice device;
    device.arm = ArmLinkDevice::of_no_wire(robot.device.settings.get<BigRobotArmDevice>());
    return device;
  }
  void declare(const std::array<double, 5>& q) {
    std::array<JointPosition, 5> places{};
    for (std::size_t i = 0; i < 5; ++i) {
      places[i] = {PositionQuality::kCommanded, q[i], q[i], q[i]};
    }
    driver.declare_positions(places);
  }
  void make_ready() {
    driver.open(now);
    run_until(DriverState::kReady);
    declare({});
    events.clear();
  }
  void run(Duration duration) {
    for (const Instant end = now + duration; now < end;) step();
  }
  bool run_until(DriverState state, Duration limit = std::chrono::seconds(30)) {
    for (const Instant end = now + limit; now < end;) {
      if (driver.state() == state) return true;
      step();
    }
    return driver.state() == state;
  }
  /// A straight way to `q`, smooth, in segments of 20 ms, as a planner has it.
  bool move_to(const std::array<double, 5>& q, double seconds,
               const std::function<bool()>& look = {}) {
    const auto from = at();
    const int segments = static_cast<int>(std::ceil(seconds / 0.02));
    for (int k = 1; k <= segments;) {
      if (look && look()) return false;
      if (driver.wants_move(now)) {
        const double s = 1.0 * k / segments;
        const double share = s * s * s * (10 + s * (-15 + 6 * s));
        const double speed = 30 * s * s * (1 - s) * (1 - s) / (segments * 0.02);
        JointMove move;
        move.duration = std::chrono::milliseconds(20);
        for (std::size_t i = 0; i < 5; ++i) {
          move.q.push_back(from[i] + share * (q[i] - from[i]));
          move.qd.push_back(k == segments ? 0 : speed * (q[i] - from[i]));
        }
        const auto taken = driver.move(move, now);
        if (!taken) {
          refused = taken.error();
          return false;
        }
        ++k;
      }
      step();
      if (driver.state() != DriverState::kMoving) return false;
    }
    for (int i = 0; i < 20'000 && driver.state() == DriverState::kMoving; ++i) {
      if (look && look()) return false;
      step();
    }
    return driver.state() == DriverState::kReady;
  }
  std::array<double, 5> at() const {
    std::array<double, 5> q{};
    for (std::size_t i = 0; i < 5; ++i) q[i] = driver.positions()[i].q;
    return q;
  }
  /// Where the motors are, rad.
  double actual(std::size_t joint) const {
    return board.rotor_steps(now)[joint] / device().arm.joints[joint].steps_per_rad;
  }
  int count(DriverEvent::Kind kind) const {
    return static_cast<int>(std::count_if(events.begin(), events.end(),
                                          [&](const auto& one) { return one.kind == kind; }));
  }

  RobotModel robot;
  ArmLinkBoard board;
  ArmLinkDriver driver;
  Instant now = Instant{} + std::chrono::seconds(1);
  std::vector<DriverEvent> events;
  std::optional<Error> refused;
  /// What happens to a byte on the line; nothing: it is lost.
  std::function<std::optional<std::uint8_t>(std::uint8_t)> line = [](std::uint8_t byte) {
    return std::optional(byte);
  };
  bool cut = false;
  Duration late{};  ///< what the board sends arrives so much later

 private:
  static constexpr Duration kByte = std::chrono::microseconds(40);
  std::deque<std::pair<Instant, std::uint8_t>> flying_;

  void step() {
    now += kByte;
    std::uint8_t byte = 0;
    if (driver.take_output({&byte, 1}) == 1 && !cut) {
      if (const auto heard = line(byte)) board.receive({&*heard, 1}, now);
    }
    board.advance(now);
    if (board.take_output({&byte, 1}) == 1 && !cut) {
      if (const auto heard = line(byte)) flying_.push_back({now + late, *heard});
    }
    while (!flying_.empty() && flying_.front().first <= now) {
      const std::uint8_t heard = flying_.front().second;
      flying_.pop_front();
      driver.receive({&heard, 1}, now);
    }
    const auto due = driver.next_deadline();
    if (due && *due <= now) driver.poll(now);
    while (const auto event = driver.take_event()) events.push_back(*event);
  }
};

}  // namespace sinew::test
