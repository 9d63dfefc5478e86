#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <optional>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/devices/lsc/lsc_driver.h"
#include "sinew/devices/lsc/lsc_machine.h"
#include "sinew/devices/lsc/lsc_settings.h"

/// A LeArm on a bench: driver, wire and machine in virtual time.
namespace sinew::test {

using namespace std::chrono_literals;

/// Where most tests begin.
using LscPose = std::array<double, 5>;
inline constexpr LscPose kLscHere{0.2, 0.3, 0.2, 0.1, 0};
inline constexpr std::array kLscProfiles{LscProfile::kLsc6, LscProfile::kBus, LscProfile::kEsp32};
/// A servo at rest against gravity is off its target by its dead band and its proportional gain.
inline constexpr double kLscSag = 0.03;  // rad

inline ErrorCode refusal(const Expected<void>& result) {
  return result ? ErrorCode{} : result.error().code;
}

inline LscDevice lsc_settings(LscProfile profile) {
  const bool bus = profile == LscProfile::kBus;
  LscDevice device;
  device.profile = profile;
  constexpr std::array<double, 5> kSigns{1, 1, -1, -1, 1};
  for (std::size_t i = 0; i < kSigns.size(); ++i) {
    LscServo servo;
    servo.id = static_cast<std::uint8_t>(6 - i);
    servo.centre = bus ? 500 : 1500;
    servo.units_per_rad = kSigns[i] * (bus ? 750 / kPi : 2000 / kPi);
    servo.lower = bus ? 125 : 500;
    servo.upper = bus ? 875 : 2500;
    device.servos.push_back(servo);
  }
  device.gripper = {1, 1500, 2500};
  if (bus) device.gripper = {1, 200, 700};
  if (profile == LscProfile::kEsp32) device.gripper = {1, 500, 1500};
  return device;
}

/// The arm of robots/learm.toml, in metres.
inline RobotModel learm(LscProfile profile) {
  RobotModel model;
  model.id = "learm";
  SerialGeometry geometry;
  geometry.rows.push_back({0.095, 0, -kPi / 2, 0});
  geometry.rows.push_back({0, 0.105, 0, -kPi / 2});
  geometry.rows.push_back({0, 0.098, 0, 0});
  geometry.rows.push_back({0, 0, -kPi / 2, -kPi / 2});
  geometry.rows.push_back({0.095, 0, 0, kPi});
  geometry.gripper = JawGripper{0.06, 0.055, 0.085};
  model.geometry = geometry;
  for (const char* name : {"base", "shoulder", "elbow", "wrist", "roll"}) {
    Joint joint;
    joint.name = name;
    joint.lower = -kPi / 2;
    joint.upper = kPi / 2;
    joint.velocity_max = kPi;
    joint.acceleration_max = 4 * kPi;
    joint.jerk_max = 40 * kPi;
    model.joints.push_back(joint);
  }
  model.device.protocol = "lsc";
  model.device.baud = 9600;
  model.device.settings = lsc_settings(profile);
  return model;
}

/// One direction of the cable: a byte takes its ten bits, and things happen to some.
class LscLine {
 public:
  enum class Fault : std::uint8_t { kDrop, kDouble, kFlip, kDelay };

  void hit(std::uint64_t byte, Fault fault, std::uint8_t bits = 1) {
    faults_.push_back({byte + count_, fault, bits});
  }
  void push(std::uint8_t byte, Instant now) {
    const std::uint64_t number = count_++;
    free_ = std::max(free_, now) + kByteTime;
    history.push_back(byte);
    if (cut) return;
    for (const Hit& hit : faults_) {
      if (hit.byte != number) continue;
      if (hit.fault == Fault::kDrop) return;
      if (hit.fault == Fault::kDouble) queue_.push_back({byte, free_});
      if (hit.fault == Fault::kFlip) byte ^= hit.bits;
      if (hit.fault == Fault::kDelay) free_ += 60ms;
    }
    queue_.push_back({byte, free_});
  }
  std::optional<Instant> next() const {
    return queue_.empty() ? std::nullopt : std::optional(queue_.front().arrives);
  }
  std::uint8_t pop() {
    const std::uint8_t byte = queue_.front().byte;
    queue_.pop_front();
    return byte;
  }
  std::uint64_t count() const { return count_; }

  bool cut = false;
  std::vector<std::uint8_t> history;

 private:
  static constexpr Duration kByteTime = 1041667ns;  // 10 bits at 9600 baud
  struct Flying {
    std::uint8_t byte;
    Instant arrives;
  };
  struct Hit {
    std::uint64_t byte;
    Fault fault;
    std::uint8_t bits;
  };
  std::deque<Flying> queue_;
  std::vector<Hit> faults_;
  Instant free_{};
  std::uint64_t count_ = 0;
};

class LscCell {
 public:
  explicit LscCell(LscProfile profile, std::uint64_t seed = 7) : LscCell(profile, profile, seed) {}
  /// A board of one kind with a driver that takes it for another.
  LscCell(LscProfile profile, LscProfile board, std::uint64_t seed = 7)
      : model(learm(profile)),
        machine(learm(board), board, seed, Instant{}),
        driver(model.device.settings.get<LscDevice>(), model.joints,
               std::get<SerialGeometry>(model.geometry).gripper) {}

  void run_for(Duration duration) {
    const Instant end = now + duration;
    pump();
    for (int round = 0; round < 2'000'000; ++round) {
      Instant next = end;
      const auto at_most = [&](std::optional<Instant> due) {
        if (due) next = std::min(next, *due);
      };
      at_most(driver.next_deadline());
      at_most(machine.next_event());
      at_most(to_board.next());
      at_most(to_host.next());
      now = std::max(now, next);
      machine.advance(now);
      pump();
      driver.poll(now);
      pump();
      if (now == end) return;
    }
    FAIL() << "driver and machine keep each other awake";
  }

  /// The host does nothing for so long: no poll, no byte taken or given.
  void be_late_by(Duration duration) {
    const Instant end = now + duration;
    while (now < end) {
      Instant next = end;
      for (const auto due : {machine.next_event(), to_board.next()}) {
        if (due) next = std::min(next, *due);
      }
      now = std::max(now, next);
      machine.advance(now);
      carry();
    }
  }
  /// The port takes so many bytes.
  void take(std::size_t most) {
    std::array<std::uint8_t, 64> piece{};
    const std::size_t count = driver.take_output({piece.data(), std::min(most, piece.size())});
    for (std::size_t i = 0; i < count; ++i) to_board.push(piece[i], now);
  }
  void take_events() {
    while (const auto event = driver.take_event()) events.push_back(*event);
  }

  /// Until an event of that kind, or 10 s are over.
  bool run_until(DriverEvent::Kind kind) {
    for (int i = 0; i < 2000; ++i) {
      if (count(kind) > 0) return true;
      run_for(5ms);
    }
    return false;
  }

  std::size_t count(DriverEvent::Kind kind) const {
    return static_cast<std::size_t>(
        std::count_if(events.begin(), events.end(),
                      [&](const DriverEvent& event) { return event.kind == kind; }));
  }
  /// Ends of commands.
  std::size_t ends() const {
    using Kind = DriverEvent::Kind;
    return count(Kind::kDone) + count(Kind::kFailed) + count(Kind::kStopped);
  }
  std::optional<ErrorCode> failure() const {
    for (const DriverEvent& event : events) {
      if (event.kind == DriverEvent::Kind::kFailed) return event.error.code;
    }
    return std::nullopt;
  }

  JointMove to(std::array<double, 5> q, Duration duration, double speed = 0) const {
    JointMove move;
    for (const double joint : q) {
      move.q.push_back(joint);
      move.qd.push_back(speed);
    }
    move.duration = duration;
    return move;
  }

  /// Opens, and where the board needs it makes the first slow move to `q`.
  void start(std::array<double, 5> q = {}) {
    driver.open(now);
    ASSERT_TRUE(run_until(DriverEvent::Kind::kReady));
    if (driver.move(to(q, 2500ms), now)) {
      run_for(5s);
    } else {  // a bus arm knows where it is
      stream(q, 4s);
    }
    ASSERT_EQ(driver.state(), DriverState::kReady);
    events.clear();
    commands = 0;
  }

  /// From where the driver says the arm is, evenly smoothed, in segments of 80 ms. `each` runs
  /// before every segment; false breaks off.
  template <class Each>
  void stream(std::array<double, 5> q, Duration duration, Each&& each) {
    std::array<double, 5> from{};
    for (std::size_t i = 0; i < 5; ++i) from[i] = driver.positions()[i].q;
    const int segments = static_cast<int>(duration / 80ms);
    for (int k = 1; k <= segments; ++k) {
      const double s = 1.0 * k / segments;
      const double smooth = s * s * (3 - 2 * s);
      std::array<double, 5> at{};
      for (std::size_t i = 0; i < 5; ++i) at[i] = from[i] + (q[i] - from[i]) * smooth;
      for (int wait = 0; !driver.wants_move(now) && wait < 200; ++wait) run_for(1ms);
      if (!each(k)) return;
      const auto taken = driver.move(to(at, 80ms, k == segments ? 0 : 1), now);
      if (!taken) return;
      ++commands;
      planned = at;
    }
    run_for(1200ms);
  }
  void stream(std::array<double, 5> q, Duration duration) {
    stream(q, duration, [](int) { return true; });
  }

  double worst(const std::array<double, 5>& q) const {
    double off = 0;
    const sim::Truth truth = machine.truth();
    for (std::size_t i = 0; i < 5; ++i) off = std::max(off, std::abs(truth.joints[i].q - q[i]));
    return off;
  }

  RobotModel model;
  sim::LscMachine machine;
  LscDriver driver;
  LscLine to_board;
  LscLine to_host;
  Instant now{};
  std::vector<DriverEvent> events;
  std::size_t commands = 0;
  std::array<double, 5> planned{};

 private:
  void carry() {
    std::array<std::uint8_t, 16> piece{};
    while (to_board.next() && *to_board.next() <= now) {
      const std::uint8_t byte = to_board.pop();
      machine.receive({&byte, 1}, now);
    }
    while (const std::size_t count = machine.take_output(piece)) {
      for (std::size_t i = 0; i < count; ++i) to_host.push(piece[i], now);
    }
  }
  void pump() {
    take(64);
    carry();
    while (to_host.next() && *to_host.next() <= now) {
      const std::uint8_t byte = to_host.pop();
      driver.receive({&byte, 1}, now);
    }
    take_events();
  }
};

}  // namespace sinew::test
