#include "sinew/runtime/links/robot_link.h"

#include <gtest/gtest.h>

#include "sinew/devices/kinds.h"
#include "sinew/runtime/links/robot_variant.h"
#include "sinew/runtime/running_cell.h"
#include "support/robots.h"
#include "support/scratch_folder.h"

namespace sinew::runtime {
namespace {

using namespace std::chrono_literals;

/// Lets a host ask all of its boards.
void opened(SpiDriver& driver, sim::SpiMachine& machine) {
  Instant now{};
  driver.open(now);
  while (driver.state() == DriverState::kOpening && now < Instant{} + 10s) {
    const auto transfer = driver.take_transfer(now);
    if (!transfer) {
      now += 100us;
      machine.advance(now);
      driver.poll(now);
      continue;
    }
    const auto miso = machine.exchange(*transfer, now);
    now += transfer->setup + spi::wire_time(*transfer);
    driver.exchanged({miso.data(), miso.size()}, now);
  }
  EXPECT_EQ(driver.state(), DriverState::kReady);
}

/// What people are told of boards of one profile by a host that takes them for another, once it
/// has asked all of them.
std::string suspicion_of(const char* boards, const char* taken_for) {
  const RobotModel robot = *variant_of(test::robot("robot-arm-2"), taken_for, std::nullopt);
  const RobotModel real = *variant_of(test::robot("robot-arm-2"), boards, std::nullopt);
  const auto machine = make_machine(real, {.profile = boards}, Instant{});
  const RobotDriver driver = make_driver(robot);
  EXPECT_EQ(kind_of(robot.device).suspicion(*driver.spi), "") << "no board has replied yet";
  opened(*driver.spi, *machine->spi);
  return kind_of(robot.device).suspicion(*driver.spi);
}

TEST(RobotLink, boards_whose_status_says_nothing_are_suspected_to_have_the_first_firmware) {
  EXPECT_EQ(suspicion_of("as-built", "document"),
            "the status of every board reads zero: looks like boards with the first firmware; "
            "try --profile as-built");
  EXPECT_EQ(suspicion_of("document", "document"), "");
  EXPECT_EQ(suspicion_of("as-built", "as-built"), "") << "that is what they are taken for";
}

TEST(RobotLink, boards_that_are_silent_are_named_on_both_wires) {
  for (const std::optional<std::string>& wire :
       {std::optional<std::string>("link"), std::optional<std::string>()}) {
    for (const auto& [there, sentence] :
         {std::pair(std::size_t{3},
                    "3 of 6 boards do not answer: J4, J5, J6; to use the others: --without "
                    "J4,J5,J6 of run, commission, doctor or device, in a cell's file without = "
                    "[\"J4\", \"J5\", \"J6\"]"),
          std::pair(std::size_t{5},
                    "1 of 6 boards does not answer: J6; to use the others: --without J6 of run, "
                    "commission, doctor or device, in a cell's file without = [\"J6\"]"),
          std::pair(std::size_t{6}, "")}) {
      const RobotModel robot = *variant_of(test::robot("robot-arm-2"), std::nullopt, wire);
      const auto machine = make_machine(robot, {.profile = {}, .boards = there}, Instant{});
      const RobotDriver driver = make_driver(robot);
      opened(*driver.spi, *machine->spi);
      EXPECT_EQ(kind_of(robot.device).suspicion(*driver.spi), sentence);
      EXPECT_EQ(driver.spi->home(Instant{} + 20s).has_value(), there == 6);
    }
  }
}

TEST(RobotLink, port_of_the_wrong_kind_is_refused_with_what_would_be_right) {
  for (const char* robot : {"learm", "maxarm", "bigrobotarm", "hexapod"}) {
    for (const std::string port : {"simwire:unix:/tmp/x", "simwire:x", "unix:/tmp/x", "spidev"}) {
      const io::Clock clock;
      ByteLog log;
      const auto link = RobotLink::prepare(test::robot(robot), port, clock, log);
      ASSERT_FALSE(link);
      EXPECT_EQ(link.error().sentence,
                port + ": " + robot + " hangs on a serial port, not on SPI; its port is a device " +
                    "as /dev/ttyUSB0, tcp:HOST:PORT, or the pseudo-terminal that sinew sim " +
                    robot + " shows");
    }
    EXPECT_FALSE(wrong_port(test::robot(robot), "/dev/ttyUSB0"));
    EXPECT_FALSE(wrong_port(test::robot(robot), "tcp:localhost:1"));
    EXPECT_FALSE(wrong_port(test::robot(robot), "simwire/arm")) << "a link may have any name";
  }
  EXPECT_TRUE(wrong_port(test::robot("robot-arm-2"), "/dev/ttyUSB0"));
  EXPECT_FALSE(wrong_port(test::robot("robot-arm-2"), "simwire:unix:/tmp/x"));
  EXPECT_FALSE(wrong_port(test::robot("robot-arm-2"), "simwire:tcp:localhost:1"));
  EXPECT_TRUE(wrong_port(test::robot("robot-arm-2"), "tcp:localhost:1"));
}

TEST(RobotLink, what_is_found_on_a_device_that_may_be_simulated_is_kept_apart) {
  const test::ScratchFolder folder;
  for (const char* simulated : {"", "/dev/pts/99", "simwire:unix:/tmp/x", "unix:/tmp/x"}) {
    const bool none = *simulated == '\0';
    EXPECT_TRUE(may_be_simulated(none ? std::nullopt : std::optional<std::string>(simulated)));
  }
  EXPECT_FALSE(may_be_simulated("/dev/ttyUSB0"));
  EXPECT_FALSE(may_be_simulated("spidev"));
  EXPECT_FALSE(may_be_simulated("tcp:localhost:1"));
  const CellFolders folders{
      .journal = folder.at("j"), .flight = {}, .record = {}, .commissioning = folder.at("c")};
  for (const std::string port : {"/dev/pts/nowhere", "/dev/nowhere"}) {
    Cell cell;
    cell.robots.emplace_back();
    cell.robots[0].name = "arm";
    cell.robots[0].port = port;
    const auto running = RunningCell::start(cell, {test::robot("learm")}, folders);
    ASSERT_TRUE(running) << running.error().sentence;
    EXPECT_EQ(results_file(folders, (*running)->station(0)),
              folder.at(port == "/dev/nowhere" ? "c/arm.json" : "c/arm.simulated.json"));
  }
}

TEST(RobotLink, silence_is_told_as_soon_as_the_wire_allows) {
  const auto limit = [](const char* robot, const char* profile) {
    return variant_of(test::robot(robot), profile, std::nullopt)->device.settings->opening().limit;
  };
  EXPECT_LE(limit("learm", "lsc6"), 3s);
  EXPECT_LE(limit("learm", "bus"), 3s);
  EXPECT_LE(limit("learm", "esp32"), 5s);
  EXPECT_LE(limit("bigrobotarm", "document"), 5s);
  EXPECT_LE(limit("hexapod", "table1"), 5s);
  EXPECT_LE(limit("robot-arm-2", "document"), 5s);
  EXPECT_LE(limit("maxarm", "arduino"), 5s);
  EXPECT_GT(limit("maxarm", "micropython"), 14s) << "asleep for 10 s, then homing for 3.5 s";
}

}  // namespace
}  // namespace sinew::runtime
