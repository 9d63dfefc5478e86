#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "firmware/emulation_avr/mega_board.h"
#include "sinew/wire/board_image.h"
#include "sinew/wire/crc32c.h"
#include "support/board_promises.h"

// The image of the BigRobotArm's board on an emulated ATmega2560, held to what the board's program
// promises on a computer.

namespace sinew::emulation {
namespace {

using mcu::arm_link::Kind;
using mcu::arm_link::Request;

mcu::Bytes image_bytes() {
  std::ifstream file(mega_image(), std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Of the whole life of the chip.
mcu::arm_link::Reply statistics_of(MegaBoard& board) {
  Request request = {};
  request.kind = Kind::kStatistics;
  const auto reply = board.frame(request);
  EXPECT_TRUE(reply);
  return reply.value_or(mcu::arm_link::Reply{});
}

// What an image may need; docs/firmware/bigrobotarm.md has the figures.
constexpr int kStackFreeLeast = 1024;  // bytes that it has never used
constexpr double kPulseLeast = 2e-6;   // s; drivers need 0.1 to 1.9 us

class MegaImage : public testing::TestWithParam<mcu::BoardPromise> {};

TEST_P(MegaImage, keeps_the_promise) {
  MegaBoard board;
  GetParam().check(board);
  const auto statistics = statistics_of(board);
  EXPECT_EQ(statistics.late_slices, 0);
  const bool flooded = GetParam().name.contains("flood");
  EXPECT_TRUE(flooded || statistics.bytes_lost == 0) << statistics.bytes_lost;
  EXPECT_GE(statistics.stack_free, kStackFreeLeast);
  EXPECT_GE(board.shortest_pulse(), kPulseLeast);
  EXPECT_EQ(board.watchdog_restarts(), 0);
}

INSTANTIATE_TEST_SUITE_P(All, MegaImage, testing::ValuesIn(mcu::board_promises()),
                         [](const auto& promise) { return promise.param.name; });

TEST(MegaImageOnly, reports_the_image_that_was_flashed) {
  MegaBoard board;
  Request request = {};
  request.kind = Kind::kIdentity;
  const auto reply = board.frame(request);
  ASSERT_TRUE(reply);
  ImageIdentity identity{};
  std::copy(std::begin(reply->identity), std::end(reply->identity), identity.begin());
  const auto reported = decode_identity(identity);
  const mcu::Bytes image = image_bytes();
  ASSERT_TRUE(reported);
  EXPECT_EQ(reported->board_name(), "bigrobotarm-atmega2560");
  EXPECT_EQ(reported->size, image.size());
  EXPECT_EQ(reported->checksum, crc32c(image));
  EXPECT_EQ(read_image(image), reported);
}

TEST(MegaImageOnly, drives_its_motors_from_the_start_and_is_silent) {
  MegaBoard board;
  for (std::size_t i = 0; i < MegaBoard::kAxes; ++i) EXPECT_TRUE(board.enabled(i)) << i;
  EXPECT_TRUE(board.take_output().empty());
  board.run_ms(45);
  EXPECT_NEAR(board.gripper_us(), 1473, 2);
}

TEST(MegaImageOnly, its_lamp_says_the_fault) {
  MegaBoard board;
  const auto changes = [&](int ms) {
    int count = 0;
    for (bool before = board.lamp(); ms > 0; --ms) {
      board.run_ms(1);
      count += board.lamp() != before ? 1 : 0;
      before = board.lamp();
    }
    return count;
  };
  EXPECT_LE(changes(3'000), 3) << "a second on, a second off";
  board.set_stop_line(true);
  board.run_ms(10);
  // Four flashes, then dark: 3.5 s in all.
  EXPECT_EQ(changes(3'500), 8);
}

TEST(MegaImageOnly, its_watchdog_bites_where_the_program_hangs) {
  MegaBoard board;
  mcu::TestHost host(board);
  ASSERT_TRUE(host.open());
  board.hang();
  board.run_ms(700);
  const auto statistics = statistics_of(board);
  EXPECT_EQ(statistics.starts, 2);
  EXPECT_EQ(board.watchdog_restarts(), 1);
}

TEST(MegaImageOnly, makes_steps_at_the_highest_rate_of_all_axes_at_once) {
  MegaBoard board;
  mcu::TestHost host(board);
  ASSERT_TRUE(host.open());
  // Smooth to 11,700 steps/s each: as fast as the board goes, and all its time is needed.
  const double way = 3120;
  ASSERT_TRUE(host.stream(
      0.5, [&](std::size_t, double t) { return mcu::smooth(way, 0.5, t); },
      [&](std::size_t, double t) { return mcu::smooth_speed(way, 0.5, t); }));
  for (std::size_t i = 0; i < MegaBoard::kAxes; ++i) EXPECT_EQ(board.steps(i), way) << i;
  const auto statistics = statistics_of(board);
  std::printf("  stack never used: %d bytes; longest loop: %.1f ms; late slices: %d\n",
              statistics.stack_free, statistics.loop_us_max / 1000.0, statistics.late_slices);
  EXPECT_EQ(statistics.late_slices, 0);
}

}  // namespace
}  // namespace sinew::emulation
