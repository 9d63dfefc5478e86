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
#include "sinew/config/builtin_robots.h"
#include "sinew/config/robot_file.h"
#include "sinew/devices/axis_link/axis_link_device.h"
#include "sinew/devices/axis_link/axis_link_driver.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/devices/axis_registers/axis_registers_device.h"
#include "sinew/devices/axis_registers/axis_registers_driver_link.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/icp/icp_driver.h"
#include "sinew/devices/icp/icp_machine.h"
#include "sinew/devices/icp/icp_settings.h"

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
  AxisRegisterSlave board(axis_register_slave_settings(device, 0), AxisRegisterProfile::kDocument,
                          axis);
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

/// The hexapod of the built-in robots.
RobotModel hexapod() {
  for (const BuiltinRobot& builtin : builtin_robots()) {
    if (builtin.id == "hexapod") return *read_robot(builtin.text, builtin.file_name);
  }
  give_up("no built-in hexapod");
}

/// Microsteps a second over the hexapod's wire, its controller taking no time of its own: what the
/// host leaves idle between an ACK and the next FF would show.
double hexapod_moves_per_second() {
  const RobotModel robot = hexapod();
  const auto& device = robot.device.settings.get<IcpDevice>();
  const Duration byte_time{10'000'000'000 / static_cast<std::int64_t>(robot.device.baud)};
  sim::IcpMachine machine(robot, {}, 1, Instant{});
  IcpDriver driver(device, robot.joints);
  Instant now = Instant{} + 100ms;
  // One byte at a time is on the wire: a byte there, its answer back.
  const auto run_until = [&](const auto& done) {
    for (int i = 0; i < 1'000'000 && !done(); ++i) {
      std::array<std::uint8_t, 1> byte{};
      if (driver.take_output(byte) == 1) {
        now += byte_time;
        machine.receive(byte, now);
      } else if (machine.take_output(byte) == 1) {
        now += byte_time;
        driver.receive(byte, now);
      } else {
        now = std::max(now, driver.next_deadline().value_or(now + 1ms));
        machine.advance(now);
        driver.poll(now);
      }
    }
    if (!done()) give_up("the hexapod's wire stands still");
  };
  FixedVector<JointPosition, kMaxJoints> home;
  JointMove move;
  constexpr std::array kUnits{400, -400, 400, -400, 400, 400};
  for (std::size_t i = 0; i < kUnits.size(); ++i) {
    const double q = robot.joints[i].home;
    home.push_back({PositionQuality::kCommanded, q, q, q});
    move.q.push_back(q + kUnits[i] / device.units_per_m);
  }
  driver.declare_positions({home.data(), home.size()});
  driver.open(now);
  run_until([&] { return driver.state() == DriverState::kReady; });
  const Instant begun = now;
  if (!driver.move(move, now)) give_up("the hexapod takes no move");
  const std::int64_t steps = driver.steps_left();
  run_until([&] { return driver.steps_left() == 0; });
  return static_cast<double>(steps) / to_seconds(now - begun);
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
      {"hexapod, microsteps of six legs merged, 9600 baud", "/s", hexapod_moves_per_second, 239.9,
       true},
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
