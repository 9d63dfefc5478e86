#include "sinew/runtime/links/simulated_line.h"

#include <gtest/gtest.h>

#include "sinew/devices/icp/icp_settings.h"
#include "sinew/runtime/links/robot_link.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/robots.h"

namespace sinew::runtime {
namespace {

using namespace std::chrono_literals;

/// A robot's own driver and its simulated device, in simulated time.
struct LineCell {
  explicit LineCell(const char* id, std::optional<std::string> wire = std::nullopt,
                    double scale = 100)
      : robot(*variant_of(test::robot(id), std::nullopt, wire)),
        clock(io::Clock::simulated(scale)),
        link(RobotLink::simulate(robot, {}, clock, log)) {
    link->driver().open(clock.now());
  }
  bool wait_for(DriverState state, Duration limit) {
    const Instant end = clock.now() + limit;
    while (link->driver().state() != state && clock.now() < end) {
      if (!link->line().turn(2ms)) return false;
      while (link->driver().take_event()) {
      }
    }
    return link->driver().state() == state;
  }

  RobotModel robot;
  io::Clock clock;
  ByteLog log;
  io::IoResult<RobotLink> link;
};

TEST(SimulatedLine, every_robot_is_found_over_its_own_bytes) {
  for (const char* id : {"robot-arm-2", "learm", "bigrobotarm", "maxarm", "hexapod"}) {
    LineCell cell(id);
    EXPECT_TRUE(cell.wait_for(DriverState::kReady, 30s)) << id;
    EXPECT_TRUE(cell.link->truth()) << id;
  }
}

TEST(SimulatedLine, bytes_take_as_long_as_on_the_wire) {
  LineCell cell("hexapod");
  ASSERT_TRUE(cell.wait_for(DriverState::kReady, 30s));
  const Instant begin = cell.clock.now();
  const std::size_t bytes = cell.link->line().count().to_device;
  JointMove move;
  for (const JointPosition& joint : cell.link->driver().positions()) move.q.push_back(joint.q);
  std::vector<JointPosition> here;
  for (const Joint& joint : cell.robot.joints) {
    here.push_back({PositionQuality::kCommanded, joint.home, joint.home, joint.home});
    move.q[here.size() - 1] = joint.home;
  }
  cell.link->driver().declare_positions(here);
  constexpr double kUnits = 200;
  move.q[0] += kUnits / cell.robot.device.settings.get<IcpDevice>().units_per_m;
  ASSERT_TRUE(cell.link->driver().move(move, cell.clock.now()));
  ASSERT_TRUE(cell.wait_for(DriverState::kReady, 60s));
  // FF and the step, each answered: four bytes of ten bits at 9600 baud for each unit.
  const std::size_t sent = cell.link->line().count().to_device - bytes;
  EXPECT_GE(sent, 2 * 200U);
  EXPECT_GE(to_seconds(cell.clock.now() - begin), kUnits * 40 / 9600);
  EXPECT_NEAR(cell.link->truth()->joints[0].q, move.q[0], 17 / 4571428.6);
}

TEST(SimulatedLine, a_computer_that_looks_away_costs_nothing) {
  LineCell cell("hexapod", std::nullopt, 1000);
  // Long beyond what the driver waits for an answer, in the device's time and in ours.
  for (int stall = 0; stall < 4; ++stall) {
    ASSERT_TRUE(cell.link->line().turn(2ms));
    io::Clock().pause(100ms);
  }
  EXPECT_TRUE(cell.wait_for(DriverState::kReady, 30s));
  EXPECT_EQ(cell.link->driver().health().timeouts, 0U);
  EXPECT_EQ(cell.link->driver().health().retries, 0U);
}

/// The thread of a hexapod at x200 spun through 340,000 empty turns a second.
TEST(SimulatedLine, no_turn_of_a_fast_machine_is_empty) {
  LineCell cell("hexapod", std::nullopt, 200);
  for (int turn = 0; turn < 200; ++turn) {
    const Instant before = cell.clock.now();
    ASSERT_TRUE(cell.link->line().turn(2ms));
    ASSERT_GT(cell.clock.now(), before) << "turn " << turn;
  }
}

TEST(SimulatedLine, boards_exchange_many_frames_in_a_turn_and_fewer_at_rest) {
  LineCell cell("robot-arm-2", "link", 20);
  ASSERT_TRUE(cell.wait_for(DriverState::kReady, 30s));
  const auto frames_in = [&](Duration time) {
    const std::size_t bytes = cell.link->line().count().to_device;
    int turns = 0;
    for (const Instant end = cell.clock.now() + time; cell.clock.now() < end; ++turns) {
      EXPECT_TRUE(cell.link->line().turn(2ms));
    }
    return std::pair((cell.link->line().count().to_device - bytes) / 16, turns);
  };
  // One cycle of six frames each millisecond.
  const auto [frames, turns] = frames_in(1s);
  EXPECT_GE(frames, 5'900U);
  EXPECT_LE(turns, 150);
  cell.link->line().set_at_rest(true);
  const auto [at_rest, turns_at_rest] = frames_in(1s);
  EXPECT_LE(at_rest, 1'500U);
  EXPECT_GE(at_rest, 900U) << "none of them reaches its deadline";
  EXPECT_EQ(cell.link->driver().health().timeouts, 0U);
  EXPECT_EQ(cell.link->driver().state(), DriverState::kReady);
}

TEST(SimulatedLine, a_device_of_this_process_and_boards_behind_simwire_have_their_own_time) {
  EXPECT_TRUE(clock_for(std::nullopt, 1).is_simulated());
  EXPECT_TRUE(clock_for("simwire:unix:/tmp/boards", 1).is_simulated());
  EXPECT_FALSE(clock_for("/dev/ttyUSB0", 1).is_simulated());
  EXPECT_FALSE(clock_for("spidev", 1).is_simulated());
}

}  // namespace
}  // namespace sinew::runtime
