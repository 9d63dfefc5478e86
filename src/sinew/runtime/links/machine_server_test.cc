#include "sinew/runtime/links/machine_server.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <optional>
#include <thread>

#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/kinds.h"
#include "sinew/io/local_socket.h"
#include "sinew/runtime/links/simwire_bus.h"
#include "support/robots.h"
#include "support/scratch_folder.h"

/// Servers in a thread, a host on the other end of a real pseudo-terminal or socket.
namespace sinew::runtime {
namespace {

using namespace std::chrono_literals;

/// A learm's board behind a pseudo-terminal.
class Board {
 public:
  explicit Board(const char* faults) {
    auto port = io::Port::open_pseudo_terminal();
    if (!port) throw std::runtime_error(port.error().sentence);
    path_ = port->path();
    const RobotModel& robot = test::robot("learm");
    machine_ = std::move(*make_machine(robot, {}, Instant{}));
    const SimulatedCable cable{robot.device.baud, *sim::parse_faults(faults)};
    thread_ = std::thread([this, cable, port = std::move(*port)]() mutable {
      const io::Clock clock;
      ByteLog log;
      const auto served = serve_machine(*machine_.byte, port, clock, cable, log,
                                        {.stop = [this] { return stop_.load(); }, .look = {}});
      if (served) counts_ = *served;
    });
  }
  ~Board() { end(); }
  Board(const Board&) = delete;
  Board& operator=(const Board&) = delete;

  std::array<sim::LinkCounts, 2> end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return counts_;
  }
  const std::string& path() const { return path_; }

 private:
  RobotMachine machine_;
  std::string path_;
  std::array<sim::LinkCounts, 2> counts_{};
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

/// GET_BATTERY_VOLTAGE; how many bytes of its answer came within a second, and after how long.
std::pair<std::size_t, Duration> ask_battery(const std::string& path) {
  auto port = io::Port::open_serial(path, 9600);
  EXPECT_TRUE(port);
  const io::Clock clock;
  EXPECT_TRUE(port->write(std::array<std::uint8_t, 4>{0x55, 0x55, 0x02, 0x0F}));
  std::array<std::uint8_t, 64> buffer{};
  std::size_t size = 0;
  while (size < 6 && clock.now() < Instant{} + 1s) {
    size += port->read({buffer.data() + size, buffer.size() - size}, 200ms).value_or(0);
  }
  return {size, clock.now() - Instant{}};
}

TEST(MachineServer, bytes_take_their_time_at_the_baud_rate_both_ways) {
  Board board("cut@1000s");
  const auto [size, took] = ask_battery(board.path());
  EXPECT_EQ(size, 6U);
  // Four bytes there and six back, ten bits each at 9600 baud.
  EXPECT_GE(took, 10ms);
  const auto counts = board.end();
  EXPECT_EQ(counts[0].in, 4U);
  EXPECT_EQ(counts[1].out, 6U);
}

TEST(MachineServer, cut_cable_carries_nothing_and_is_counted) {
  Board board("half-open@0s:to-host");
  EXPECT_EQ(ask_battery(board.path()).first, 0U);
  const auto counts = board.end();
  EXPECT_EQ(counts[0].cut, 0U);
  EXPECT_EQ(counts[1].cut, 6U);
}

TEST(Simwire, host_and_boards_meet_over_a_socket) {
  const test::ScratchFolder folder;
  auto listener = io::LocalListener::create(folder.at("s"));
  ASSERT_TRUE(listener);
  const RobotModel& robot = test::robot("robot-arm-2");
  const auto& boards = robot.device.settings.get<AxisRegistersDevice>().boards;
  RobotMachine machine = std::move(*make_machine(robot, {}, Instant{}));
  std::thread thread([&] {
    sim::SimwireServer server(*machine.spi, {boards.data(), boards.size()}, "test");
    auto client = listener->accept(5s);
    ASSERT_TRUE(client && *client);
    ByteLog log;
    static_cast<void>(serve_simwire(server, **client, log, [] { return false; }));
  });
  {
    const io::Clock clock;
    auto port = io::connect_local(folder.at("s"));
    ASSERT_TRUE(port);
    auto bus = connect_simwire(std::move(*port), {boards.data(), boards.size()}, clock);
    ASSERT_TRUE(bus) << bus.error().sentence;
    // SYN, then its acknowledgement: the document's first two steps.
    std::array<std::uint8_t, 1> miso{};
    ASSERT_TRUE((*bus)->exchange(1, std::array<std::uint8_t, 1>{0x97}, miso, 200us, 500'000));
    ASSERT_TRUE((*bus)->exchange(1, std::array<std::uint8_t, 1>{0xFF}, miso, 200us, 500'000));
    EXPECT_EQ(miso[0], 0x98);
    EXPECT_TRUE((*bus)->ready(0));
  }
  thread.join();  // the host went away, so the server is done
}

TEST(Simwire, silence_and_nonsense_are_told) {
  const test::ScratchFolder folder;
  auto listener = io::LocalListener::create(folder.at("s"));
  ASSERT_TRUE(listener);
  std::thread thread([&] {
    auto client = listener->accept(5s);
    ASSERT_TRUE(client && *client);
    std::array<std::uint8_t, 64> buffer{};
    static_cast<void>((*client)->read(buffer, 2s));
    static_cast<void>((*client)->write(std::array<std::uint8_t, 4>{'h', 'm', 'm', '\n'}));
  });
  const io::Clock clock;
  auto port = io::connect_local(folder.at("s"));
  ASSERT_TRUE(port);
  const auto bus = connect_simwire(std::move(*port), {}, clock);
  thread.join();
  ASSERT_FALSE(bus);
  EXPECT_NE(bus.error().sentence.find("the answer is not simwire"), std::string::npos);
}

}  // namespace
}  // namespace sinew::runtime
