#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/device/bigrobotarm.h"
#include "sinew/program/sequence_run.h"
#include "support/robots.h"

/// Runs of programs against the firmware, back to back in virtual time.
namespace sinew::sequence {

inline RobotModel arm(BigRobotArmWire wire = BigRobotArmWire::kByte) {
  RobotModel model = test::robot("bigrobotarm");
  std::get<BigRobotArmDevice>(model.device.settings).wire = wire;
  return model;
}
inline const BigRobotArmDevice& device_of(const RobotModel& model) {
  return std::get<BigRobotArmDevice>(model.device.settings);
}

inline Program program_of(std::string_view text) {
  auto program = parse(text, "f", BigRobotArmDevice{});
  if (!program) throw std::runtime_error(to_text(program.error()[0]));
  return std::move(*program);
}

inline BigRobotArmAngles angles_of(const RobotModel& model, const Words& steps) {
  BigRobotArmAngles q{};
  for (std::size_t i = 0; i < q.size(); ++i) {
    q[i] = steps[i] / device_of(model).joints[i].steps_per_rad;
  }
  return q;
}

/// The largest difference between two sets of angles, rad.
inline double apart(const BigRobotArmAngles& a, const BigRobotArmAngles& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

class Cell {
 public:
  Cell(std::string_view text, const RobotModel& robot)
      : model(robot),
        program(program_of(text)),
        firmware(device_of(model), Instant{}),
        driver(device_of(model)),
        run(program, model, driver) {}

  /// Lets time jump from event to event until the run is over or `limit` is reached.
  void go_on(Instant limit = Instant{std::chrono::hours(10)}) {
    if (!started_) run.start(now);
    started_ = true;
    for (int round = 0; round < 100'000; ++round) {
      settle();
      if (run.finished() || now >= limit) return;
      Instant next = limit;
      if (const auto event = firmware.next_event()) next = std::min(next, *event);
      if (const auto due = driver.next_deadline()) next = std::min(next, *due);
      now = std::max(now, next);
      firmware.advance(now);
      settle();
      driver.poll(now);
    }
    FAIL() << "the run goes round and round at one instant";
  }
  /// Until an order is under way that stands in `line`.
  void go_to_line(int line) {
    for (int millisecond = 0; millisecond < 100'000 && !run.finished(); ++millisecond) {
      const auto record = run.under_way();
      if (record && record->order->line == line && firmware.moving()) return;
      go_on(now + std::chrono::milliseconds(1));
    }
    FAIL() << "line " << line << " never came";
  }

  /// Where the motors stand, rad.
  BigRobotArmAngles truth() {
    const auto steps = firmware.rotor_steps(now);
    BigRobotArmAngles q{};
    for (std::size_t i = 0; i < q.size(); ++i) {
      q[i] = steps[i] / device_of(model).joints[i].steps_per_rad;
    }
    return q;
  }

  RobotModel model;
  Program program;
  BigRobotArmFirmware firmware;
  BigRobotArmDriver driver;
  Run run;
  Instant now{};
  bool cut = false;                     ///< nothing arrives at either end
  std::vector<std::uint8_t> to_device;  ///< all that the host sent

 private:
  /// Until nobody has anything more to say at this instant.
  void settle() {
    do {
      run.poll(now);
    } while (exchange());
  }

  bool exchange() {
    bool any = false;
    std::array<std::uint8_t, 64> piece{};
    while (const std::size_t count = driver.take_output(piece)) {
      to_device.insert(to_device.end(), piece.begin(), piece.begin() + static_cast<long>(count));
      if (!cut) firmware.receive(std::span(piece.data(), count), now);
      any = true;
    }
    while (const std::size_t count = firmware.take_output(piece)) {
      if (!cut) driver.receive(std::span(piece.data(), count), now);
      any = true;
    }
    return any;
  }

  bool started_ = false;
};

}  // namespace sinew::sequence
