#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "sinew/devices/maxarm/maxarm_driver.h"
#include "sinew/devices/maxarm/maxarm_machine.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/devices/maxarm/maxarm_test_model.h"
#include "sinew/sim/link_fault.h"

namespace sinew::test {

/// Driver and machine back to back in virtual time, with 9600 baud and a faulty link between.
class MaxArmCell {
 public:
  struct Options {
    MaxArmChecksum checksum = MaxArmChecksum::kSpec;
    MaxArmVariant variant = MaxArmVariant::kArduino;
    std::uint64_t seed = 1;
    sim::LinkFaultSpec faults{};
    bool opened = true;
    std::optional<MaxArmVariant> taken_for{};     ///< by the driver; what it is where left out
    Duration warm_up = std::chrono::seconds(20);  ///< powered so long before the port opens
  };

  MaxArmCell() : MaxArmCell(Options()) {}
  explicit MaxArmCell(const Options& options)
      : robot(model(options.taken_for.value_or(options.variant))),
        driver(robot.device.settings.get<MaxArmDevice>(), robot.joints),
        machine(robot, options.checksum, options.variant, options.seed, Instant{}),
        now(Instant{options.warm_up}),
        link(options.faults, now) {
    machine.advance(now);
    if (!options.opened) return;
    driver.open(now);
    EXPECT_TRUE(run_until(DriverState::kReady, std::chrono::seconds(20)));
    events.clear();
    sent.clear();
    sent_at.clear();
  }

  /// A target by its pulses.
  JointMove to(const std::array<double, 3>& pulses, Duration duration) const {
    JointMove move;
    move.q.resize(3);
    move.qd.resize(3);
    const auto& servos = robot.device.settings.get<MaxArmDevice>().servos;
    for (std::size_t i = 0; i < 3; ++i) {
      move.q[i] = (pulses[i] - servos[i].offset) / servos[i].pulses_per_rad;
    }
    move.duration = duration;
    return move;
  }

  double true_pulse(std::size_t joint) const {
    const auto& servo = robot.device.settings.get<MaxArmDevice>().servos[joint];
    return servo.offset + servo.pulses_per_rad * machine.truth().joints[joint].q;
  }

  void run_for(Duration duration) {
    const Instant end = now + duration;
    while (now < end) step(end);
  }
  bool run_until(DriverState state, Duration limit) {
    const Instant end = now + limit;
    while (now < end && driver.state() != state) step(end);
    return driver.state() == state;
  }
  /// Runs until the command's one end, and says which.
  std::optional<DriverEvent> run_to_end(Duration limit) {
    const std::size_t first = events.size();
    const Instant end = now + limit;
    while (now < end) {
      for (std::size_t i = first; i < events.size(); ++i) {
        using Kind = DriverEvent::Kind;
        const Kind kind = events[i].kind;
        if (kind == Kind::kDone || kind == Kind::kFailed || kind == Kind::kStopped) {
          return events[i];
        }
      }
      step(end);
    }
    return std::nullopt;
  }

  RobotModel robot;
  MaxArmDriver driver;
  sim::MaxArmMachine machine;
  Instant now;
  sim::LinkFaults link;
  std::vector<DriverEvent> events;
  std::vector<std::uint8_t> sent;         ///< all that left the host
  std::vector<Instant> sent_at;           ///< one per byte, as it arrives
  std::function<void()> each_step;        ///< looks at the cell after every step
  std::function<bool(std::size_t)> lose;  ///< true: the n-th byte for the device vanishes

 private:
  static RobotModel model(MaxArmVariant variant) {
    RobotModel robot = maxarm_model();
    robot.device.settings.get<MaxArmDevice>().variant = variant;
    return robot;
  }

  static constexpr Duration kByteTime = std::chrono::nanoseconds(1'041'667);

  /// One byte each way in a byte's time, as the port does it.
  void step(Instant end) {
    std::array<std::uint8_t, 1> byte{};
    std::array<std::uint8_t, 64> piece{};
    now = std::min(end, now + kByteTime);
    machine.advance(now);
    if (driver.take_output(byte) == 1) {
      sent.push_back(byte[0]);
      sent_at.push_back(now);
      if (!lose || !lose(sent.size() - 1)) link.push(sim::LinkDirection::kToDevice, byte, now);
    }
    while (const std::size_t n = link.take(sim::LinkDirection::kToDevice, now, piece)) {
      machine.receive(std::span(piece).first(n), now);
    }
    if (machine.take_output(byte) == 1) link.push(sim::LinkDirection::kToHost, byte, now);
    while (const std::size_t n = link.take(sim::LinkDirection::kToHost, now, piece)) {
      driver.receive(std::span(piece).first(n), now);
    }
    driver.poll(now);
    while (const auto event = driver.take_event()) events.push_back(*event);
    if (each_step) each_step();
  }
};

}  // namespace sinew::test
