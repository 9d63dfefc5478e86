#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "sinew/devices/axis_link/axis_link_device.h"
#include "sinew/devices/axis_link/axis_link_driver.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/devices/axis_link/axis_link_test_axis.h"

namespace sinew::test {

/// What the line does to one transfer.
struct LinkFault {
  bool lost = false;       ///< no axis sees its select
  std::size_t bytes = 16;  ///< clocks that arrive
  bool twice = false;      ///< the axis gets the frame a second time, later
  int mosi_bit = -1;       ///< flipped
  int miso_bit = -1;
  bool old_reply = false;    ///< the host gets the answer of the transfer before
  bool old_request = false;  ///< the axis gets this axis's request of 40 frames ago as well
};

/// Driver and nodes back to back in virtual time; 50 us a frame for select and system call.
class LinkCell {
 public:
  explicit LinkCell(std::size_t count = 6, const AxisLinkTiming& timing = {},
                    std::uint32_t clock_hz = 4'000'000,
                    Duration deadline = axis_link::kDeadlineDefault) {
    device.clock_hz = clock_hz;
    device.deadline = deadline;
    for (std::size_t i = 0; i < count; ++i) {
      device.boards.push_back({});
      joints.push_back(link_joint(i));
      axes.push_back(std::make_unique<LinkTestAxis>(joints[i]));
      nodes.push_back(node(i, 1));
    }
    sent_targets.resize(count);
    sent_frames.resize(count);
    driver = std::make_unique<AxisLinkDriver>(device, joints, timing);
  }

  std::unique_ptr<AxisLinkNode> node(std::size_t axis, std::uint16_t boot) {
    return std::make_unique<AxisLinkNode>(
        *axes[axis], axis_link_node_settings(joints[axis], static_cast<std::uint8_t>(axis), boot));
  }
  void reboot(std::size_t axis) {
    axes[axis]->reboot();
    nodes[axis] = node(axis, 2);
  }
  /// Opened, every axis homed at `q`.
  void open_at(double q) {
    for (auto& axis : axes) axis->place(q);
    driver->open(now);
    run_for(std::chrono::milliseconds(20));
    ASSERT_EQ(driver->state(), DriverState::kReady);
    ASSERT_EQ(driver->positions()[0].quality, PositionQuality::kMeasured);
    events.clear();
  }

  JointMove move_to(double q, Duration duration, double qd = 0) const {
    JointMove move;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      move.q.push_back(q);
      move.qd.push_back(qd);
    }
    move.duration = duration;
    return move;
  }

  void run_for(Duration duration) {
    run_until([] { return false; }, duration);
  }
  /// Until `done`, or `limit` is over; whether it was done.
  template <class Done>
  bool run_until(const Done& done, Duration limit) {
    const Instant end = now + limit;
    while (now < end) {
      if (done()) return true;
      if (!step()) {
        const Instant due = driver->next_deadline().value_or(end);
        advance(std::min({end, now + std::chrono::milliseconds(1),
                          std::max(now + std::chrono::microseconds(20), due)}));
        driver->poll(now);
      }
      collect();
    }
    return done();
  }
  bool run_to_event(DriverEvent::Kind kind, Duration limit = std::chrono::seconds(30)) {
    return run_until([&] { return count(kind) > 0; }, limit);
  }

  /// One transfer, where one is due.
  bool step() {
    const auto transfer = driver->take_transfer(now);
    if (!transfer) return false;
    LinkFault fault;
    if (disturb) fault = disturb(*transfer);
    record(*transfer);
    const Instant end = now + overhead + spi::wire_time(*transfer);
    const auto miso = clock(*transfer, fault);
    advance(end);
    ++frames;
    driver->exchanged(miso, now);
    return true;
  }

  std::size_t count(DriverEvent::Kind kind) const {
    return static_cast<std::size_t>(
        std::ranges::count_if(events, [&](const auto& event) { return event.kind == kind; }));
  }
  std::optional<Error> failure() const {
    for (const auto& event : events) {
      if (event.kind == DriverEvent::Kind::kFailed) return event.error;
    }
    return std::nullopt;
  }

  /// No axis was ever told a target that the driver did not send to it.
  void expect_only_sent_targets() const {
    for (std::size_t i = 0; i < axes.size(); ++i) {
      for (const double q : axes[i]->targets) {
        if (q == axes[i]->home_angle) continue;
        EXPECT_TRUE(sent_targets[i].contains(q)) << "axis " << i << " was told " << q;
      }
    }
  }
  /// What positions() says holds: measured as of the last frame, uncertain now.
  void expect_truth_inside() const {
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const JointPosition& claim = driver->positions()[i];
      if (claim.quality == PositionQuality::kLost) continue;
      const bool measured = claim.quality == PositionQuality::kMeasured;
      // What it can go in two rounds, where it is known to have been at the last one.
      const double slack = measured ? 1.1 * joints[i].velocity_max * 2.5e-3 : 1e-9;
      EXPECT_GE(axes[i]->q(), claim.lower - slack) << "axis " << i;
      EXPECT_LE(axes[i]->q(), claim.upper + slack) << "axis " << i;
    }
  }

  AxisLinkDevice device;
  std::vector<Joint> joints;
  std::vector<std::unique_ptr<LinkTestAxis>> axes;
  std::vector<std::unique_ptr<AxisLinkNode>> nodes;
  std::unique_ptr<AxisLinkDriver> driver;
  std::function<LinkFault(const spi::Transfer&)> disturb;
  Duration overhead = std::chrono::microseconds(50);
  Instant now{};
  std::vector<DriverEvent> events;
  std::vector<std::set<double>> sent_targets;
  std::vector<std::vector<spi::Bytes>> sent_frames;
  std::uint64_t frames = 0;
  bool keep_record = true;
  std::size_t late_by = 0;  ///< transfers by which each answer is behind; of one axis

 private:
  void advance(Instant to) {
    now = to;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      axes[i]->advance(now);
      nodes[i]->advance(now);
    }
  }
  void collect() {
    while (const auto event = driver->take_event()) events.push_back(*event);
  }
  void record(const spi::Transfer& transfer) {
    if (!keep_record) return;
    for (std::size_t i = 0; i < axes.size(); ++i) {
      if ((transfer.select >> i & 1) == 0) continue;
      sent_frames[i].push_back(transfer.mosi);
      const auto request = axis_link::decode_request(
          std::span<const std::uint8_t>(transfer.mosi).first<axis_link::kFrameSize>());
      ASSERT_TRUE(request);
      if (request->mode == axis_link::Mode::kTrack) {
        sent_targets[i].insert(axis_link::from_units(request->target));
      }
    }
  }
  void give(std::size_t axis, const spi::Bytes& bytes, std::size_t count, spi::Bytes* miso) {
    nodes[axis]->select(true);
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint8_t out = nodes[axis]->shift(bytes[k]);
      if (miso != nullptr) (*miso)[k] &= out;  // several at once pull the line down
    }
    nodes[axis]->select(false);
  }
  spi::Bytes clock(const spi::Transfer& transfer, const LinkFault& fault) {
    spi::Bytes mosi = transfer.mosi;
    spi::Bytes miso;
    miso.resize(mosi.size());
    if (fault.mosi_bit >= 0) flip(mosi, fault.mosi_bit);
    if (!fault.lost) std::ranges::fill(miso, std::uint8_t{0xFF});
    for (std::size_t i = 0; i < axes.size() && !fault.lost; ++i) {
      if ((transfer.select >> i & 1) == 0) continue;
      give(i, mosi, std::min(fault.bytes, mosi.size()), &miso);
      if (fault.twice) give(i, mosi, mosi.size(), nullptr);
      const std::size_t sent = sent_frames[i].size();
      if (fault.old_request && sent > 40) {
        give(i, sent_frames[i][sent - 40], mosi.size(), nullptr);
      }
    }
    if (fault.miso_bit >= 0) flip(miso, fault.miso_bit);
    if (fault.old_reply) return last_miso_;
    last_miso_ = miso;
    if (late_by == 0) return miso;
    held_.push_back(miso);
    miso = held_.front();
    if (held_.size() > late_by) held_.pop_front();
    return miso;
  }
  static void flip(spi::Bytes& bytes, int bit) {
    auto& byte = bytes[static_cast<std::size_t>(bit / 8)];
    byte = static_cast<std::uint8_t>(byte ^ 1U << (bit % 8));
  }

  std::deque<spi::Bytes> held_;
  spi::Bytes last_miso_ = spi::Bytes{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
};

}  // namespace sinew::test
