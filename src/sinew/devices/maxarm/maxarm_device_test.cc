#include "sinew/devices/maxarm/maxarm_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sinew/core/units.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace maxarm;
using namespace std::chrono_literals;
using enum MaxArmVariant;

PalletizerGeometry compiled_lengths() {
  return {.base_height = from_mm(84.4),
          .shoulder_offset = from_mm(8.14),
          .upper_arm = from_mm(128.4),
          .forearm = from_mm(138.0),
          .tool_offset = from_mm(16.8),
          .base_front = from_deg(120),
          .radius_min = from_mm(50)};
}

MaxArmDevice board(MaxArmVariant variant, MaxArmChecksum checksum = MaxArmChecksum::kSpec) {
  MaxArmDevice device;
  device.variant = variant;
  device.checksum = checksum;
  return device;
}

/// A board with servos that are always where they are told to be.
struct Bench {
  explicit Bench(MaxArmVariant variant = kArduino, Duration since_boot = 20s)
      : firmware(board(variant), compiled_lengths(), test::seed(), Instant{}) {
    run_for(since_boot);
  }
  void send(const Request& request) { firmware.receive(encode_request(request), now); }
  void run_for(Duration duration) {
    const Instant end = now + duration;
    while (now < end) {
      now = std::min(end, now + 1ms);
      if (follow) {
        const auto at = firmware.servo_targets(now);
        MaxArmFirmware::Readings readings;
        for (std::size_t i = 0; i < 3; ++i) {
          readings[i] = static_cast<std::int16_t>(std::lround(at[i]));
        }
        firmware.sense(readings);
      }
      firmware.advance(now);
      std::array<std::uint8_t, 64> piece{};
      while (const std::size_t n = firmware.take_output(piece)) {
        for (std::size_t i = 0; i < n; ++i) {
          if (const auto frame = decoder.push(piece[i])) {
            replies.push_back(*frame);
            times.push_back(now);
          }
        }
      }
    }
  }
  ServoPulses targets() const {
    const auto at = firmware.servo_targets(now);
    return {static_cast<int>(std::lround(at[0])), static_cast<int>(std::lround(at[1])),
            static_cast<int>(std::lround(at[2]))};
  }

  MaxArmFirmware firmware;
  ReplyDecoder decoder;
  std::vector<ReplyFrame> replies;
  std::vector<Instant> times;
  Instant now{};
  bool follow = true;
};

struct Vector {
  std::array<std::int16_t, 3> xyz;
  ServoPulses pulses;
  std::array<double, 3> back_mm;  ///< where those pulses really are
};

const std::vector<Vector> kVectors{
    {{0, -163, 212}, {500, 499, 501}, {0, -163.477, 212.221}},
    {{120, -180, 85}, {359, 317, 674}, {120.811, -180.194, 84.978}},
    {{-120, -180, 85}, {640, 317, 674}, {-120.056, -180.698, 84.978}},
    {{0, -280, 75}, {500, 188, 575}, {0, -280.141, 75.248}},
    {{160, 0, 200}, {125, 504, 522}, {160.203, 0, 200.083}},
    {{150, -35, 90}, {179, 405, 728}, {150.469, -34.628, 90.112}},
    {{0, -200, 120}, {500, 382, 642}, {0, -200.152, 120.104}}};

TEST(MaxArmFirmware, points_of_the_table_become_its_cut_pulses_in_both_programs) {
  for (const auto variant : {kArduino, kMicroPython}) {
    for (const Vector& vector : kVectors) {
      const auto pulses = firmware_pulses(compiled_lengths(), variant, vector.xyz);
      ASSERT_TRUE(pulses);
      EXPECT_EQ(*pulses, vector.pulses) << vector.xyz[0] << " " << vector.xyz[1];
      Bench bench(variant);
      bench.send(SetXyz{vector.xyz, 500});
      bench.run_for(1s);
      EXPECT_EQ(bench.targets(), vector.pulses);
    }
  }
}

TEST(MaxArmFirmware, pulses_are_read_back_as_the_point_they_really_are) {
  for (const Vector& vector : kVectors) {
    std::array<std::int16_t, 3> pulses{};
    for (std::size_t i = 0; i < 3; ++i) pulses[i] = static_cast<std::int16_t>(vector.pulses[i]);
    const auto arduino = firmware_xyz(compiled_lengths(), kArduino, pulses);
    const auto python = firmware_xyz(compiled_lengths(), kMicroPython, pulses);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_LE(std::abs(arduino[i] - vector.back_mm[i]), 1);
      EXPECT_LE(std::abs(python[i] - vector.back_mm[i]), 1.5) << "negative ones come out high";
    }
  }
  // Half up, then cut: -162.94 comes out as -162.
  EXPECT_EQ(firmware_xyz(compiled_lengths(), kMicroPython, {500, 500, 500}),
            (std::array<std::int16_t, 3>{0, -162, 213}));
}

TEST(MaxArmFirmware, unreachable_point_swings_arduino_s_servos_to_zero_and_is_ignored_by_python) {
  Bench arduino;
  arduino.send(SetXyz{{0, -400, 100}, 500});
  arduino.run_for(1s);
  EXPECT_EQ(arduino.targets(), (ServoPulses{500, 0, 0}));
  Bench python(kMicroPython);
  for (const auto& xyz : std::vector<std::array<std::int16_t, 3>>{
           {0, -400, 100}, {0, -100, 240}, {100, 100, 100}, {0, -30, 100}}) {
    python.send(SetXyz{xyz, 500});
    python.run_for(1s);
    EXPECT_EQ(python.targets(), (ServoPulses{500, 500, 500})) << xyz[1];
  }
  Bench near;
  near.send(SetXyz{{0, -30, 100}, 500});
  near.run_for(1s);
  EXPECT_EQ(near.targets(), (ServoPulses{500, 500, 500})) << "nearer than 50 mm: both ignore it";
}

TEST(MaxArmFirmware, python_clamps_shoulder_and_forearm_and_arduino_only_the_servo_range) {
  Bench arduino;
  arduino.send(SetAngle{{1200, 900, 100}, 100});
  arduino.run_for(1s);
  EXPECT_EQ(arduino.targets(), (ServoPulses{1000, 900, 100}));
  Bench python(kMicroPython);
  python.send(SetAngle{{1200, 900, 100}, 100});
  python.run_for(1s);
  EXPECT_EQ(python.targets(), (ServoPulses{1000, 700, 470}));
}

TEST(MaxArmFirmware, servos_go_evenly_in_pulses_over_the_given_time) {
  Bench bench;
  bench.send(SetAngle{{700, 300, 600}, 1000});
  bench.run_for(250ms);
  EXPECT_EQ(bench.targets(), (ServoPulses{550, 450, 525}));
  bench.run_for(750ms);
  EXPECT_EQ(bench.targets(), (ServoPulses{700, 300, 600}));
}

TEST(MaxArmFirmware, a_new_set_takes_over_where_the_old_one_is) {
  Bench bench;
  bench.send(SetAngle{{700, 500, 500}, 1000});
  bench.run_for(500ms);
  bench.send(SetAngle{{600, 500, 500}, 100});
  bench.run_for(1s);
  EXPECT_EQ(bench.targets(), (ServoPulses{600, 500, 500}));
}

TEST(MaxArmFirmware, answers_come_in_the_measured_time_and_in_both_sums) {
  for (const auto variant : {kArduino, kMicroPython}) {
    Duration shortest = 10s;
    Duration longest{};
    Bench bench(variant);
    for (int i = 0; i < 300; ++i) {
      const Instant asked = bench.now;
      bench.send(ReadAngle{});
      bench.run_for(700ms + i * 1ms);
      ASSERT_EQ(bench.replies.size(), static_cast<std::size_t>(i) + 1);
      shortest = std::min(shortest, Duration(bench.times.back() - asked));
      longest = std::max(longest, Duration(bench.times.back() - asked));
    }
    EXPECT_GE(shortest, variant == kArduino ? 98ms : 18ms);
    EXPECT_LE(longest, variant == kArduino ? 276ms : 525ms);
    EXPECT_GT(longest - shortest, 150ms);
    EXPECT_EQ(bench.replies[0], (ReplyFrame{Angles{{500, 500, 500}}, Checksum::kSpec}));
  }
  MaxArmFirmware other(board(kArduino, MaxArmChecksum::kWithHeader), compiled_lengths(), 1,
                       Instant{});
  other.advance(Instant{5s});
  other.sense({500, 500, 500});
  other.receive(encode_request(ReadAngle{}), Instant{5s});
  other.advance(Instant{6s});
  std::array<std::uint8_t, 11> bytes{};
  ASSERT_EQ(other.take_output(bytes), 11U);
  EXPECT_EQ(bytes.back(), 0x0A);
}

TEST(MaxArmFirmware, ring_of_ninety_answers_seventeen_of_twenty_four_questions) {
  Bench bench;
  std::vector<std::uint8_t> burst;
  for (int i = 0; i < 24; ++i) {
    for (const std::uint8_t byte : encode_request(ReadAngle{})) burst.push_back(byte);
  }
  bench.firmware.receive(burst, bench.now);
  bench.run_for(10s);
  EXPECT_EQ(bench.replies.size(), 17U);
  EXPECT_EQ(bench.firmware.bytes_lost(), 31U);
}

TEST(MaxArmFirmware, arduino_s_nozzle_blocks_for_its_time_and_a_short_one_restarts_it) {
  Bench bench;
  bench.send(SetPwmServo{2000, 1000});
  bench.send(ReadAngle{});
  bench.run_for(500ms);
  EXPECT_EQ(bench.firmware.nozzle_us(bench.now), 1750);
  bench.run_for(500ms);
  EXPECT_TRUE(bench.replies.empty());
  bench.run_for(300ms);
  EXPECT_EQ(bench.replies.size(), 1U);
  bench.send(SetAngle{{700, 400, 600}, 100});
  bench.run_for(1s);
  bench.send(SetPwmServo{1500, 19});
  EXPECT_TRUE(bench.firmware.starting());
  EXPECT_EQ(bench.firmware.restarts(), 1U);
  bench.run_for(3s);
  EXPECT_EQ(bench.targets(), (ServoPulses{500, 500, 500})) << "it homed by itself";
  Bench python(kMicroPython);
  python.send(SetPwmServo{1500, 19});
  python.run_for(1s);
  EXPECT_EQ(python.firmware.restarts(), 0U);
}

TEST(MaxArmFirmware, starting_board_hears_nothing) {
  for (const auto variant : {kArduino, kMicroPython}) {
    Bench bench(variant, 1s);
    bench.send(ReadAngle{});
    bench.run_for(20s);
    EXPECT_TRUE(bench.replies.empty());
    EXPECT_EQ(bench.firmware.bytes_lost(), 5U);
    bench.send(ReadAngle{});
    bench.run_for(1s);
    EXPECT_EQ(bench.replies.size(), 1U);
  }
}

TEST(MaxArmFirmware, python_dies_of_a_servo_at_zero_or_without_an_answer) {
  for (const std::optional<std::int16_t> reading : {std::optional<std::int16_t>{},
                                                    {std::int16_t{0}},
                                                    {std::int16_t{-3}},
                                                    {std::int16_t{1001}}}) {
    Bench python(kMicroPython);
    python.follow = false;
    python.firmware.sense({500, reading, 500});
    python.send(ReadXyz{});
    python.run_for(2s);
    EXPECT_TRUE(python.firmware.dead());
    python.firmware.sense({500, 500, 500});
    python.send(ReadXyz{});
    python.run_for(2s);
    EXPECT_TRUE(python.replies.empty());
    python.firmware.restart(python.now);
    python.run_for(20s);
    python.send(ReadXyz{});
    python.run_for(2s);
    EXPECT_EQ(python.replies.size(), 1U);
  }
  Bench arduino;
  arduino.follow = false;
  arduino.firmware.sense({500, std::nullopt, 0});
  arduino.send(ReadAngle{});
  arduino.run_for(2s);
  EXPECT_EQ(arduino.replies.at(0).reply, Reply(Angles{{500, -1, 0}}));
}

TEST(MaxArmFirmware, python_is_deaf_behind_a_frame_cut_by_its_look_until_zeros_come) {
  const auto frame = encode_request(SetAngle{{600, 500, 500}, 500});
  int deaf = 0;
  for (int phase = 0; phase < 100; ++phase) {
    Bench bench(kMicroPython);
    bench.run_for(phase * 1ms);
    for (const std::uint8_t byte : frame) {  // about 9600 baud
      bench.firmware.receive(std::array{byte}, bench.now);
      bench.run_for(1ms);
    }
    bench.run_for(300ms);
    bench.send(ReadAngle{});
    bench.run_for(700ms);
    if (!bench.replies.empty()) {
      EXPECT_EQ(bench.targets()[0], 600);
      continue;
    }
    ++deaf;
    EXPECT_EQ(bench.targets()[0], 500);
    bench.firmware.receive(std::array<std::uint8_t, 16>{}, bench.now);
    bench.run_for(150ms);
    bench.send(ReadAngle{});
    bench.run_for(700ms);
    EXPECT_EQ(bench.replies.size(), 1U) << phase;
  }
  // The look falls between two of its eight data bytes.
  EXPECT_GE(deaf, 6);
  EXPECT_LE(deaf, 9);
}

TEST(MaxArmFirmware, suction_takes_its_three_actions_and_ignores_others) {
  Bench bench;
  for (const std::uint8_t action : std::array<std::uint8_t, 4>{1, 2, 1, 3}) {
    bench.send(SetSuction{action});
    EXPECT_EQ(bench.firmware.suction(), action);
    for (const int other : {0, 4, 255}) {
      bench.send(SetSuction{static_cast<std::uint8_t>(other)});
      EXPECT_EQ(bench.firmware.suction(), action);
    }
  }
}

TEST(MaxArmFirmware, any_bytes_are_survived_without_allocating) {
  test::for_random_cases(300, [](test::Random& random) {
    MaxArmFirmware firmware(board(random.chance(0.5) ? kArduino : kMicroPython), compiled_lengths(),
                            random.bits(), Instant{});
    Instant now{20s};
    firmware.sense({500, 500, 500});
    std::array<std::uint8_t, 64> piece{};
    const test::AllocationCounter allocations;
    for (int round = 0; round < 100; ++round) {
      const auto count = static_cast<std::size_t>(random.integer(0, 64));
      for (std::size_t i = 0; i < count; ++i) piece[i] = static_cast<std::uint8_t>(random.bits());
      if (random.chance(0.5)) {
        const auto frame = encode_request(SetXyz{{static_cast<std::int16_t>(random.bits()),
                                                  static_cast<std::int16_t>(random.bits()), 90},
                                                 1000});
        std::copy(frame.begin(), frame.end(), piece.begin());
      }
      firmware.receive(std::span(piece).first(count), now);
      now += std::chrono::milliseconds(random.integer(0, 300));
      firmware.advance(now);
      (void)firmware.take_output(piece);
      for (const double pulse : firmware.servo_targets(now)) {
        EXPECT_TRUE(pulse >= 0 && pulse <= 1000);
      }
    }
    EXPECT_EQ(allocations.count(), 0U);
  });
}

}  // namespace
}  // namespace sinew
