#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <functional>
#include <vector>

#include "sinew/devices/icp/icp_driver.h"
#include "sinew/devices/icp/icp_machine.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/icp/icp_test_robot.h"

namespace sinew::test {

/// One direction of the wire: bytes one behind the other, 10 bits each at 9600 baud.
class IcpLine {
 public:
  /// What becomes of a byte: none, one or more bytes, and how much later.
  struct Fate {
    std::vector<std::uint8_t> bytes;
    Duration late{};
  };
  using Fault = std::function<Fate(std::uint8_t byte, std::size_t place)>;

  static constexpr Duration kByteTime{1'041'667};

  void put(std::uint8_t byte, Instant now) {
    const std::size_t place = count_++;
    if (record) record->push_back(byte);
    Fate fate{{byte}, {}};
    if (fault) fate = fault(byte, place);
    for (const std::uint8_t one : fate.bytes) {
      free_ = std::max(now + fate.late, free_) + kByteTime;
      flying_.emplace_back(free_, one);
    }
  }
  std::optional<Instant> next() const {
    if (flying_.empty()) return std::nullopt;
    return flying_.front().first;
  }
  std::optional<std::uint8_t> take(Instant now) {
    if (flying_.empty() || flying_.front().first > now) return std::nullopt;
    const std::uint8_t byte = flying_.front().second;
    flying_.pop_front();
    return byte;
  }
  std::size_t count() const { return count_; }
  void restart_count() { count_ = 0; }

  Fault fault;
  std::vector<std::uint8_t>* record = nullptr;

 private:
  std::deque<std::pair<Instant, std::uint8_t>> flying_;
  Instant free_{};
  std::size_t count_ = 0;
};

/// Driver and machine back to back in virtual time, a byte at a time as the wire carries them.
class IcpCell {
 public:
  explicit IcpCell(const IcpQuirks& quirks = {}, const IcpDevice& device = icp_device(),
                   const IcpTiming& timing = {}, std::uint64_t seed = 1)
      : robot(icp_robot(device)),
        driver(device, robot.joints, timing),
        machine(robot, quirks, seed, Instant{}) {}

  static std::array<JointPosition, kLegs> at_home() {
    std::array<JointPosition, kLegs> all;
    all.fill({PositionQuality::kCommanded, from_mm(268), from_mm(268), from_mm(268)});
    return all;
  }

  /// Opened, positions declared, at rest.
  void begin() {
    run_for(std::chrono::milliseconds(100));
    driver.declare_positions(at_home());
    driver.open(now);
    run_until([&] { return driver.state() == DriverState::kReady; });
    ASSERT_EQ(driver.state(), DriverState::kReady);
    events.clear();
    up.restart_count();
    down.restart_count();
  }

  /// Home plus so many units, leg by leg.
  static JointVector units_off(const std::array<std::int64_t, kLegs>& units) {
    JointVector q;
    for (const std::int64_t unit : units) {
      q.push_back(from_mm(268) + static_cast<double>(unit) / kIcpUnitsPerM);
    }
    return q;
  }
  Expected<void> go(const std::array<std::int64_t, kLegs>& units, Duration duration = {}) {
    return driver.move({units_off(units), {}, duration}, now);
  }

  /// Until the driver is at rest or faulty.
  void settle(Duration limit = std::chrono::seconds(60)) {
    run_until(
        [&] {
          const DriverState state = driver.state();
          return state == DriverState::kReady || state == DriverState::kFault ||
                 state == DriverState::kClosed;
        },
        limit);
  }

  void run_for(Duration duration) {
    const Instant end = now + duration;
    run_until([&] { return now >= end; }, duration);
  }

  template <class Done>
  void run_until(Done&& done, Duration limit = std::chrono::seconds(60)) {
    const Instant end = now + limit;
    exchange();
    while (!done() && now < end) {
      Instant next = end;
      for (const auto& event :
           {machine.next_event(), driver.next_deadline(), up.next(), down.next()}) {
        if (event) next = std::min(next, *event);
      }
      now = std::max(now, next);
      machine.advance(now);
      while (const auto byte = up.take(now)) machine.receive(std::array{*byte}, now);
      while (const auto byte = down.take(now)) {
        driver.receive(std::array{*byte}, now);
        exchange();
      }
      driver.poll(now);
      exchange();
    }
  }

  /// The host is kept from its port: what comes waits there.
  void look_away(Duration duration) {
    const Instant end = now + duration;
    while (now < end) {
      now += std::chrono::milliseconds(1);
      machine.advance(now);
      while (const auto byte = up.take(now)) machine.receive(std::array{*byte}, now);
      answer();
    }
  }

  /// Units that the leg's motor really made from home.
  std::int64_t truth(std::size_t leg) const {
    const double q = machine.truth().joints[leg].believed;
    return std::llround((q - from_mm(268)) * kIcpUnitsPerM);
  }
  /// Every leg is where the driver says, or inside what it admits.
  void expect_honest() const {
    const sim::Truth truth = machine.truth();
    for (std::size_t i = 0; i < kLegs; ++i) {
      const JointPosition& claim = driver.positions()[i];
      if (claim.quality == PositionQuality::kLost) continue;
      // A commanded leg is exactly where it was sent; else the interval's ends count as inside.
      const bool sure = claim.quality == PositionQuality::kCommanded;
      const double slack = 0.01 / kIcpUnitsPerM;
      EXPECT_GE(truth.joints[i].believed, (sure ? claim.q : claim.lower) - slack) << "leg " << i;
      EXPECT_LE(truth.joints[i].believed, (sure ? claim.q : claim.upper) + slack) << "leg " << i;
      // The rotor trails its field by friction and load.
      EXPECT_NEAR(truth.joints[i].q, truth.joints[i].believed, 3 / kIcpUnitsPerM) << "leg " << i;
    }
  }

  std::size_t count(DriverEvent::Kind kind) const {
    return static_cast<std::size_t>(std::count_if(
        events.begin(), events.end(), [&](const DriverEvent& e) { return e.kind == kind; }));
  }
  bool uncertain() const {
    return std::any_of(
        driver.positions().begin(), driver.positions().end(),
        [](const JointPosition& p) { return p.quality != PositionQuality::kCommanded; });
  }

  RobotModel robot;
  IcpDriver driver;
  sim::IcpMachine machine;
  IcpLine up;
  IcpLine down;
  Instant now{};
  std::vector<DriverEvent> events;

 private:
  void exchange() {
    std::array<std::uint8_t, 16> piece{};
    while (const std::size_t size = driver.take_output(piece)) {
      for (std::size_t i = 0; i < size; ++i) up.put(piece[i], now);
    }
    answer();
    while (const auto event = driver.take_event()) events.push_back(*event);
  }

  /// What the machine says goes onto the line.
  void answer() {
    std::array<std::uint8_t, 16> piece{};
    while (const std::size_t size = machine.take_output(piece)) {
      for (std::size_t i = 0; i < size; ++i) down.put(piece[i], now);
    }
  }
};

}  // namespace sinew::test
