#include "sinew/devices/encoder/as5600_machine.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "sinew/core/units.h"
#include "support/allocation_guard.h"

namespace sinew::sim {
namespace {

constexpr std::uint8_t kRawAngle = 0x0C;

std::uint16_t word(const std::array<std::uint8_t, 2>& bytes) {
  return static_cast<std::uint16_t>(bytes[0] << 8 | bytes[1]);
}

TEST(As5600, counts_go_round_with_the_magnet_and_wrap) {
  As5600 chip(0.1, 1);
  for (int i = 10; i < 3000; ++i) chip.turn_to(0.01 * i, 0.1);
  chip.turn_to(30, 0.1);
  EXPECT_NEAR(chip.counts(), std::fmod(30 / (2 * kPi), 1) * 4096, 2);
  chip.turn_to(-0.01, 1);
  chip.turn_to(-0.01, 1);  // the filter has come to rest too
  EXPECT_NEAR(chip.counts(), 4096 - 0.01 / (2 * kPi) * 4096, 2);
}

TEST(As5600, noise_at_rest_is_that_of_the_data_sheet) {
  As5600 chip(1, 7);
  double sum = 0, squares = 0;
  constexpr int kSamples = 100'000;
  for (int i = 0; i < kSamples; ++i) {
    // Spread over a count, so that rounding adds its own 0.29 counts rms and no more.
    const double angle = (1000 + i * 1.0 / kSamples) / 4096 * 2 * kPi;
    chip.turn_to(angle, 1);
    const double error = chip.counts() + 0.5 - (1000 + i * 1.0 / kSamples);
    sum += error;
    squares += error * error;
  }
  const double rms = std::sqrt(squares / kSamples - sum * sum / kSamples / kSamples);
  const double expected = std::hypot(0.015 / 360 * 4096, 1 / std::sqrt(12.0));
  EXPECT_NEAR(rms, expected, 0.03);
  EXPECT_NEAR(sum / kSamples, 0, 0.02);
}

TEST(As5600, step_has_settled_within_a_percent_after_2_2_ms) {
  As5600 chip(0, 1);
  constexpr double kStep = 1.0;  // rad
  chip.turn_to(kStep, 1e-9);
  int steps = 0;
  while (std::abs(chip.counts() - kStep / (2 * kPi) * 4096) > 0.01 * 652 + 1 && steps < 100) {
    chip.turn_to(kStep, 1e-4);
    ++steps;
  }
  EXPECT_GE(steps, 18);
  EXPECT_LE(steps, 22);
}

TEST(As5600, turning_evenly_it_trails_by_speed_times_its_time_constant) {
  As5600 chip(0, 1);
  const double speed = 30;  // rad/s: 100 deg/s behind 17:1
  double angle = 0;
  for (int i = 0; i < 100; ++i) chip.turn_to(angle += speed * 1e-3, 1e-3);
  const double trail = std::remainder(angle / (2 * kPi) * 4096 - chip.counts(), 4096);
  EXPECT_NEAR(trail, speed * 2.2e-3 / 4.6 / (2 * kPi) * 4096, 2);
}

TEST(As5600, pointer_stays_on_the_raw_angle_and_walks_elsewhere) {
  As5600 chip(2, 1);
  As5600Bus bus(chip);
  const std::array pointer{kRawAngle};
  ASSERT_TRUE(bus.write(As5600::kAddress, pointer));
  std::array<std::uint8_t, 2> first{}, again{};
  ASSERT_TRUE(bus.read(As5600::kAddress, first));
  ASSERT_TRUE(bus.read(As5600::kAddress, again));
  EXPECT_EQ(word(first), chip.counts());
  EXPECT_EQ(word(again), chip.counts());

  const std::array status{std::uint8_t{0x0B}};
  ASSERT_TRUE(bus.write(As5600::kAddress, status));
  std::array<std::uint8_t, 3> three{};
  ASSERT_TRUE(bus.read(As5600::kAddress, three));
  EXPECT_EQ(three[0], As5600::kMagnetDetected);
  EXPECT_EQ(three[1] << 8 | three[2], chip.counts());
}

TEST(As5600, low_byte_alone_walks_on) {
  As5600 chip(2, 1);
  As5600Bus bus(chip);
  const std::array pointer{std::uint8_t{0x0D}};
  ASSERT_TRUE(bus.write(As5600::kAddress, pointer));
  std::array<std::uint8_t, 3> bytes{};  // RAW low, ANGLE high, ANGLE low
  ASSERT_TRUE(bus.read(As5600::kAddress, bytes));
  EXPECT_EQ(bytes[0], chip.counts() & 0xFF);
  EXPECT_EQ(bytes[1] << 8 | bytes[2], chip.counts());
}

TEST(As5600, after_power_up_a_read_without_a_pointer_gives_settings_and_no_angle) {
  As5600 chip(2, 1);
  As5600Bus bus(chip);
  chip.power_cycle();
  std::array<std::uint8_t, 2> bytes{0xEE, 0xEE};
  ASSERT_TRUE(bus.read(As5600::kAddress, bytes));
  EXPECT_EQ(word(bytes), 0);
}

TEST(As5600, addresses_that_it_does_not_have_are_not_acknowledged_and_read_as_zero) {
  As5600 chip(2, 1);
  As5600Bus bus(chip);
  for (const std::uint8_t address : std::to_array<std::uint8_t>({0x09, 0x10, 0x19, 0x1D, 0x80})) {
    EXPECT_FALSE(bus.write(As5600::kAddress, std::array{address})) << int{address};
    std::array<std::uint8_t, 1> byte{0xEE};
    ASSERT_TRUE(bus.read(As5600::kAddress, byte));
    EXPECT_EQ(byte[0], 0);
  }
  EXPECT_FALSE(bus.write(0x40, std::array{kRawAngle}));
}

TEST(As5600, tells_of_a_magnet_that_is_gone_weak_or_strong) {
  As5600 chip(2, 1);
  As5600Bus bus(chip);
  const auto status = [&](double field) {
    chip.set_field(field);
    std::array<std::uint8_t, 1> byte{};
    EXPECT_TRUE(bus.write(As5600::kAddress, std::array{std::uint8_t{0x0B}}));
    EXPECT_TRUE(bus.read(As5600::kAddress, byte));
    return byte[0];
  };
  EXPECT_EQ(status(1), As5600::kMagnetDetected);
  EXPECT_EQ(status(0), As5600::kMagnetTooWeak);
  EXPECT_EQ(status(0.3), As5600::kMagnetDetected | As5600::kMagnetTooWeak);
  EXPECT_EQ(status(3), As5600::kMagnetDetected | As5600::kMagnetTooStrong);

  chip.set_field(0);  // angles are noise all over the turn then
  std::uint16_t lowest = 4095, highest = 0;
  for (int i = 0; i < 100; ++i) {
    chip.turn_to(2, 1e-3);
    lowest = std::min(lowest, chip.counts());
    highest = std::max(highest, chip.counts());
  }
  EXPECT_GT(highest - lowest, 2000);
}

TEST(As5600, stuck_bus_acknowledges_nothing_and_leaves_the_bytes_alone) {
  As5600 chip(2, 1);
  As5600Bus bus(chip);
  bus.set_stuck(true);
  std::array<std::uint8_t, 2> bytes{0xEE, 0xEE};
  EXPECT_FALSE(bus.write(As5600::kAddress, std::array{kRawAngle}));
  EXPECT_FALSE(bus.read(As5600::kAddress, bytes));
  EXPECT_EQ(word(bytes), 0xEEEE);
}

TEST(As5600, never_allocates) {
  As5600 chip(2, 1);
  As5600Bus bus(chip);
  const test::AllocationCounter allocations;
  std::array<std::uint8_t, 3> bytes{};
  for (int i = 0; i < 1000; ++i) {
    chip.turn_to(i * 0.01, 1e-3);
    bus.write(As5600::kAddress, std::array{kRawAngle});
    bus.read(As5600::kAddress, bytes);
  }
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::sim
