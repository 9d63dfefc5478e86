#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/devices/axis/axis_device_test_fake.h"
#include "sinew/devices/axis_registers/axis_registers_device.h"
#include "sinew/devices/axis_registers/axis_registers_driver.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"

namespace sinew::test {

/// Six boards on one bus, numbers of the robot's fact sheet.
inline AxisRegistersDevice six_boards(AngleEncoding encoding = AngleEncoding::kDegU32) {
  AxisRegistersDevice device;
  device.encoding = encoding;
  constexpr std::array<double, 6> kLower{-170, -90, -135, -170, -120, -360};
  constexpr std::array<std::uint8_t, 6> kSelect{5, 6, 13, 19, 26, 21};
  constexpr std::array<std::uint8_t, 6> kReady{22, 23, 24, 25, 27, 17};
  for (std::size_t i = 0; i < 6; ++i) {
    device.boards.push_back({0, 0, kSelect[i], kReady[i], from_deg(kLower[i])});
  }
  return device;
}

inline std::vector<Joint> six_joints() {
  std::vector<Joint> joints;
  for (const double limit : {170, 90, 135, 170, 120, 360}) {
    Joint joint;
    joint.lower = from_deg(-limit);
    joint.upper = from_deg(limit);
    joint.velocity_max = from_deg(100);
    joint.acceleration_max = from_deg(10);
    joint.jerk_max = from_deg(10);
    joints.push_back(joint);
  }
  return joints;
}

/// What the line does to one transfer.
struct LineFault {
  std::uint8_t deaf = 0;                          ///< bit i: axis i does not see its select
  std::optional<std::size_t> cut = std::nullopt;  ///< bytes after which the clock stops
  bool twice = false;                             ///< the boards see the frame twice
  int mosi_bit = -1;                              ///< flipped
  int miso_bit = -1;
  Duration late{};  ///< the host is told later
};

/// Driver and boards back to back in virtual time.
class RegisterCell {
 public:
  explicit RegisterCell(AxisRegisterProfile profile = AxisRegisterProfile::kDocument,
                        const AxisRegistersDevice& device = six_boards(),
                        const AxisRegistersTiming& timing = {})
      : device_(device), joints(six_joints()), timing_(timing) {
    for (std::size_t i = 0; i < device.boards.size(); ++i) {
      axes.emplace_back(joints[i].lower, joints[i].upper);
    }
    for (std::size_t i = 0; i < device.boards.size(); ++i) {
      boards.emplace_back(axis_register_slave_settings(device, i), profile, axes[i]);
    }
    new_host();
  }

  /// The old one dies where it is; what it learned dies with it.
  void new_host() {
    driver = std::make_unique<AxisRegistersDriver>(device_, joints, timing_);
    events.clear();
  }

  /// Opened, every axis homed at `q_deg` and known there.
  void start_at(double q_deg = 0) {
    for (FakeAxis& axis : axes) axis.place(from_deg(q_deg));
    std::vector<JointPosition> known(axes.size(), {PositionQuality::kCommanded, from_deg(q_deg),
                                                   from_deg(q_deg), from_deg(q_deg)});
    driver->declare_positions(known);
    driver->open(now);
    ASSERT_TRUE(run_until([this] { return driver->state() == DriverState::kReady; }, 60));
    events.clear();
  }

  JointMove to(const std::vector<double>& q_deg) const {
    JointMove move;
    for (const double angle : q_deg) {
      move.q.push_back(from_deg(angle));
      move.qd.push_back(0);
    }
    return move;
  }

  void run_for(Duration duration) {
    const Instant end = now + duration;
    run([&] { return now >= end; }, end);
  }
  /// True where it came to be.
  template <class Predicate>
  bool run_until(Predicate done, double seconds) {
    run(done, now + from_seconds(seconds));
    return done();
  }

  std::vector<DriverEvent> ends() const {
    std::vector<DriverEvent> found;
    for (const DriverEvent& event : events) {
      if (event.kind == DriverEvent::Kind::kDone || event.kind == DriverEvent::Kind::kFailed ||
          event.kind == DriverEvent::Kind::kStopped) {
        found.push_back(event);
      }
    }
    return found;
  }
  bool saw(DriverEvent::Kind kind) const {
    return std::ranges::any_of(events, [kind](const DriverEvent& e) { return e.kind == kind; });
  }
  /// Runs until the command's end, and says which it was.
  DriverEvent finish(double seconds = 120) {
    EXPECT_TRUE(run_until([this] { return !ends().empty(); }, seconds)) << "no end was told";
    const DriverEvent end = ends().empty() ? DriverEvent{} : ends().back();
    events.clear();
    return end;
  }

  /// No position is silently wrong.
  void expect_honest(const char* where = "") const {
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const JointPosition& claim = driver->positions()[i];
      if (claim.quality == PositionQuality::kLost) continue;
      ASSERT_LE(claim.lower - 1e-9, axes[i].q()) << where << " joint " << i;
      ASSERT_GE(claim.upper + 1e-9, axes[i].q()) << where << " joint " << i;
    }
  }

  void exchange(const spi::Transfer& transfer) {
    const LineFault fault = line ? line(transfer, transfers) : LineFault{};
    ++transfers;
    spi::Bytes mosi = transfer.mosi;
    if (fault.mosi_bit >= 0) flip(mosi, fault.mosi_bit);
    spi::Bytes miso = pass(transfer.select & ~fault.deaf, mosi, fault.cut);
    if (fault.twice) pass(transfer.select & ~fault.deaf, mosi, fault.cut);
    if (fault.miso_bit >= 0) flip(miso, fault.miso_bit);
    now += transfer.setup + spi::wire_time(transfer);
    for (FakeAxis& axis : axes) axis.advance(now);
    now += fault.late;
    for (FakeAxis& axis : axes) axis.advance(now);
    driver->exchanged(std::span<const std::uint8_t>(miso.data(), miso.size()), now);
    collect();
  }

  AxisRegistersDevice device_;
  std::vector<Joint> joints;
  AxisRegistersTiming timing_;
  std::deque<FakeAxis> axes;
  std::deque<AxisRegisterSlave> boards;
  std::unique_ptr<AxisRegistersDriver> driver;
  Instant now{};
  std::function<LineFault(const spi::Transfer&, int)> line;
  std::function<void(const spi::Transfer&)> watch;  ///< what leaves the host
  int transfers = 0;
  int contended = 0;  ///< bytes at which two boards said different things
  std::vector<DriverEvent> events;

 private:
  static void flip(spi::Bytes& bytes, int bit) {
    const auto at = static_cast<std::size_t>(bit / 8);
    if (at < bytes.size()) bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (0x80U >> bit % 8));
  }

  spi::Bytes pass(int select, const spi::Bytes& mosi, std::optional<std::size_t> cut) {
    spi::Bytes miso;
    for (std::size_t i = 0; i < boards.size(); ++i) {
      if ((select >> i & 1) != 0) boards[i].select(true);
    }
    for (std::size_t k = 0; k < mosi.size(); ++k) {
      std::optional<std::uint8_t> level;
      bool agree = true;
      for (std::size_t i = 0; i < boards.size(); ++i) {
        if ((select >> i & 1) == 0 || (cut && k >= *cut)) continue;
        const std::uint8_t byte = boards[i].shift(mosi[k]);
        agree = agree && level.value_or(byte) == byte;
        level = static_cast<std::uint8_t>(level.value_or(0xFF) & byte);
      }
      contended += agree ? 0 : 1;
      miso.push_back(level.value_or(0xFF));  // nobody drives the line: pulled up
    }
    for (std::size_t i = 0; i < boards.size(); ++i) {
      if ((select >> i & 1) != 0) boards[i].select(false);
    }
    return miso;
  }

  void collect() {
    while (const auto event = driver->take_event()) events.push_back(*event);
  }

  template <class Predicate>
  void run(Predicate done, Instant end) {
    int stuck = 0;
    while (!done() && now < end) {
      if (const auto transfer = driver->take_transfer(now)) {
        if (watch) watch(*transfer);
        exchange(*transfer);
        stuck = 0;
        continue;
      }
      const Instant next = std::min(end, driver->next_deadline().value_or(end));
      if (next <= now && ++stuck > 3) {
        FAIL() << "the driver keeps itself awake at one instant";
        return;
      }
      now = std::max(now, next);
      for (FakeAxis& axis : axes) axis.advance(now);
      driver->poll(now);
      collect();
    }
  }
};

}  // namespace sinew::test
