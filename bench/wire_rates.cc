// How many setpoints a second each wire carries: drivers against devices in virtual wire time, so
// that the figures are those of the protocol and not of this machine. Part of `make bench`.
// A row fails the program where its goal is not met.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "bench/ideal_axis.h"
#include "sinew/device/axis_link_node.h"
#include "sinew/device/axis_register_slave.h"
#include "sinew/driver/axis_link.h"
#include "sinew/driver/axis_register_link.h"

namespace sinew::bench {
namespace {

using namespace std::chrono_literals;

[[noreturn]] void give_up(std::string_view what) {
  std::fprintf(stderr, "wire_rates: %.*s\n", static_cast<int>(what.size()), what.data());
  std::exit(1);
}

/// ms that one WRITE of one byte takes on the register wire, with all waits of its document.
double register_write_ms() {
  AxisRegistersDevice device;
  device.boards.push_back({});
  IdealAxis axis;
  AxisRegisterSlave board(device, 0, AxisRegisterProfile::kDocument, axis);
  AxisRegisterLink link(device, {});
  Instant now{};
  Instant begun{};
  constexpr int kWrites = 10;
  // The first one also finds the board.
  for (int i = 0; i <= kWrites; ++i) {
    link.start({.select = 1,
                .operation = axis_registers::Operation::kWrite,
                .address = device.registers.homing,
                .size = 1,
                .data = {0}},
               now);
    if (i == 1) begun = *link.next_deadline();
    std::optional<AxisRegisterOutcome> outcome;
    while (!outcome) {
      now = std::max(now, *link.next_deadline());
      const auto transfer = link.take_transfer(now);
      if (!transfer) give_up("the register link has nothing to send");
      spi::Bytes miso;
      miso.resize(transfer->mosi.size());
      board.exchange(transfer->mosi, std::span(miso.data(), miso.size()));
      now += transfer->setup + spi::wire_time(*transfer);
      link.exchanged(miso, now);
      outcome = link.take_outcome();
    }
    if (outcome->error) give_up("a register WRITE failed");
  }
  AxisRegisterRequest next;
  next.select = 1;
  link.start(next, now);  // the last pause belongs to the last WRITE
  return to_seconds(*link.next_deadline() - begun) * 1e3 / kWrites;
}

/// Setpoints a second that each of `axes` axes in series on one bus gets, in the middle of a move.
/// @param overhead  charged for each frame's chip select and system call
double axis_link_hz(std::size_t axes, std::uint32_t clock_hz, Duration overhead) {
  AxisLinkDevice device;
  device.clock_hz = clock_hz;
  std::vector<Joint> joints(axes, free_joint());
  std::vector<IdealAxis> ideal(axes);
  std::vector<AxisLinkNode> nodes;
  nodes.reserve(axes);
  for (std::size_t i = 0; i < axes; ++i) {
    device.boards.push_back({});
    nodes.emplace_back(ideal[i], axis_link_node_settings(joints[i], static_cast<std::uint8_t>(i)));
  }
  AxisLinkTiming timing;
  timing.cycle = Duration::zero();  // as fast as the wire goes
  AxisLinkDriver driver(device, joints, timing);
  Instant now{};
  std::uint64_t setpoints = 0;
  const auto run_for = [&](Duration duration) {
    for (const Instant end = now + duration; now < end;) {
      const auto transfer = driver.take_transfer(now);
      if (!transfer) give_up("the axis link has nothing to send");
      now += overhead + spi::wire_time(*transfer);
      spi::Bytes miso;
      for (std::size_t i = 0; i < axes; ++i) {
        nodes[i].advance(now);
        if ((transfer->select >> i & 1) == 0) continue;
        nodes[i].select(true);
        for (const std::uint8_t byte : transfer->mosi) miso.push_back(nodes[i].shift(byte));
        nodes[i].select(false);
        if (transfer->mosi[1] == static_cast<std::uint8_t>(axis_link::Mode::kTrack)) ++setpoints;
      }
      driver.exchanged(miso, now);
    }
  };
  driver.open(now);
  run_for(50ms);
  JointMove move{.q = {}, .qd = {}, .duration = 2s};
  for (std::size_t i = 0; i < axes; ++i) {
    move.q.push_back(1);
    move.qd.push_back(0);
  }
  if (!driver.move(move, now)) give_up("the axis link takes no move");
  run_for(100ms);
  setpoints = 0;
  const Instant begun = now;
  run_for(1s);
  if (driver.state() != DriverState::kMoving || driver.health().unexpected != 0) {
    give_up("the axis link lost frames on a clean wire");
  }
  return static_cast<double>(setpoints) / to_seconds(now - begun) / static_cast<double>(axes);
}

/// One line of the table. A wire's new row is a new entry below.
struct Row {
  std::string_view what;
  std::string_view unit;
  std::function<double()> measure;
  double goal;
  bool goal_is_least;  ///< else the goal is the most
};

int run() {
  const std::array rows = std::to_array<Row>({
      {"register WRITE, 1 byte, 500 kHz, documented waits", "ms", register_write_ms, 81.9, false},
      {"axis link, 6 axes in series, 500 kHz, 50 us a frame", "Hz",
       [] { return axis_link_hz(6, 500'000, 50us); }, 540, true},
      {"axis link, 6 axes in series, 4 MHz, 50 us a frame", "Hz",
       [] { return axis_link_hz(6, 4'000'000, 50us); }, 2000, true},
  });
  std::printf("%-56s %12s %10s\n", "wire, in virtual time", "measured", "goal");
  bool all_met = true;
  for (const Row& row : rows) {
    const double measured = row.measure();
    const bool met = row.goal_is_least ? measured >= row.goal : measured <= row.goal;
    all_met = all_met && met;
    std::printf("%-56.*s %9.2f %-2.*s %s %6.1f  %s\n", static_cast<int>(row.what.size()),
                row.what.data(), measured, static_cast<int>(row.unit.size()), row.unit.data(),
                row.goal_is_least ? ">=" : "<=", row.goal, met ? "met" : "NOT MET");
  }
  return all_met ? 0 : 1;
}

}  // namespace
}  // namespace sinew::bench

int main() {
  return sinew::bench::run();
}
