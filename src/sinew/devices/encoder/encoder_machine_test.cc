#include "sinew/devices/encoder/encoder_machine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/devices/encoder/as5600_machine.h"
#include "sinew/devices/encoder/encoder_device_reader.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using encoder_link::Register;
using encoder_link::Reply;
using std::chrono::microseconds;
using std::chrono::milliseconds;
namespace bits = encoder_link::status;

constexpr double kTick = 2 * kPi / 4096;  // rad

/// A shaft, its chip, the node and a board that asks, in virtual time at a baud rate.
class Cell {
 public:
  explicit Cell(double baud = 9600, double angle = 1.0)
      : byte_time_(from_seconds(10 / baud)), chip_(angle, 11), bus_(chip_), node_(bus_, Instant{}) {
    motion_ = [angle](double) { return angle; };
  }

  double seconds() const { return to_seconds(now_.time_since_epoch()); }
  void pass(Duration time) {
    node_.advance(now_);
    for (const Instant end = now_ + time; now_ < end;) {
      const Instant next = std::min({end, now_ + microseconds(250), node_.next_sample()});
      chip_.turn_to(motion_(to_seconds(next.time_since_epoch())), to_seconds(next - now_));
      now_ = next;
      node_.advance(now_);
    }
  }
  /// One question and its answer over the wire; nothing when the time-out passed.
  std::optional<Reply> ask(Register name) {
    while (!link_.ready(now_)) pass(milliseconds(1));
    for (const std::uint8_t byte : link_.ask(name, now_)) {
      pass(byte_time_);
      node_.receive(std::array{byte}, now_);
    }
    std::array<std::uint8_t, 8> answer{};
    const std::size_t size = node_.take_output(answer);
    std::vector<Reply> replies;
    for (std::size_t i = 0; i < size; ++i) {
      pass(byte_time_);
      if (const auto reply = link_.receive(answer[i], now_)) replies.push_back(reply->value());
    }
    while (replies.empty()) {
      pass(milliseconds(1));
      if (link_.poll(now_)) return std::nullopt;
    }
    return replies[0];
  }

  Duration byte_time_;
  Instant now_{};
  sim::As5600 chip_;
  sim::As5600Bus bus_;
  sim::EncoderBoard node_;
  encoder_link::Conversation link_{{}};
  std::function<double(double)> motion_;  ///< rad of s
};

TEST(EncoderNode, answers_with_where_the_shaft_is) {
  Cell cell;
  cell.pass(milliseconds(200));
  const auto position = cell.ask(Register::kPosition);
  ASSERT_TRUE(position);
  EXPECT_NEAR(position->value, 1.0 / kTick, 2);
  EXPECT_EQ(cell.ask(Register::kStatus)->value,
            bits::kFresh | bits::kMagnet | bits::kSettled | bits::kRestarted);
  EXPECT_EQ(cell.ask(Register::kStatus)->value, bits::kFresh | bits::kMagnet | bits::kSettled);
}

TEST(EncoderNode, tells_speed_in_both_directions_across_many_turns) {
  for (const double ticks_per_second : {-19342.0, -1138.0, 0.0, 300.0, 1138.0, 19342.0}) {
    Cell cell;
    cell.motion_ = [=](double t) { return ticks_per_second * t * kTick; };
    cell.pass(milliseconds(500));
    EXPECT_NEAR(cell.ask(Register::kVelocity)->as_signed(), ticks_per_second, 40);
    EXPECT_NEAR(cell.ask(Register::kAcceleration)->as_signed(), 0, 800);
  }
}

TEST(EncoderNode, follows_constant_acceleration_without_lag) {
  Cell cell;
  constexpr double kAcceleration = 2276;  // ticks/s^2: 200 deg/s^2 on the joint's shaft
  cell.motion_ = [](double t) { return 0.5 * kAcceleration * t * t * kTick; };
  cell.pass(milliseconds(1000));
  const auto velocity = cell.ask(Register::kVelocity);
  // Read when the request had arrived, five bytes before now; the chip's filter trails by 0.5 ms.
  const double then = cell.seconds() - 5 * 10 / 9600.0 - 0.5e-3;
  EXPECT_NEAR(velocity->as_signed(), kAcceleration * then, 40);
  double sum = 0;
  for (int i = 0; i < 20; ++i) sum += cell.ask(Register::kAcceleration)->as_signed();
  EXPECT_NEAR(sum / 20, kAcceleration, 100);
}

TEST(EncoderNode, what_does_not_fit_16_bits_is_held_and_never_wraps) {
  Cell cell;
  cell.motion_ = [](double t) { return 60'000 * t * kTick; };
  cell.pass(milliseconds(500));
  EXPECT_EQ(cell.ask(Register::kVelocity)->as_signed(), 32767);
  cell.motion_ = [](double t) { return -60'000 * t * kTick; };
  cell.pass(milliseconds(500));
  EXPECT_EQ(cell.ask(Register::kVelocity)->as_signed(), -32767);
  const double start = cell.seconds();
  cell.motion_ = [=](double t) { return 0.5 * 38'684 * 2 * std::pow(t - start, 2) * kTick; };
  cell.pass(milliseconds(300));
  EXPECT_EQ(cell.ask(Register::kAcceleration)->as_signed(), 32767);
}

/// Amplitude of a register's answer to a sine of 1, in the register's own unit.
double gain_at(double hertz, bool acceleration) {
  ShaftFilter filter;
  const double w = 2 * kPi * hertz;
  const double ticks = 400;
  shaft_filter_restart(&filter, 2048);
  std::complex<double> sum = 0;
  const int periods = 20;
  const int samples = static_cast<int>(std::lround(periods * 1000 / hertz));
  for (int i = 0; i < 2 * samples; ++i) {
    const double t = i * 1e-3;
    shaft_filter_update(&filter,
                        static_cast<std::uint16_t>(std::lround(2048 + ticks * std::sin(w * t))));
    const double value = acceleration ? static_cast<double>(filter.acceleration) * 1e6
                                      : static_cast<double>(filter.speed) * 1e3;
    if (i >= samples) sum += value * 0x1p-20 * std::polar(1.0, -w * t);
  }
  return 2 * std::abs(sum) / samples / (ticks * w * (acceleration ? w : 1));
}

double bandwidth(bool acceleration) {
  double hertz = 2;
  while (gain_at(hertz, acceleration) > std::sqrt(0.5)) hertz += 0.5;
  return hertz;
}

TEST(EncoderNode, bandwidth_is_what_the_documentation_says) {
  const double velocity = bandwidth(false);
  const double acceleration = bandwidth(true);
  RecordProperty("velocity_hz", std::to_string(velocity));
  RecordProperty("acceleration_hz", std::to_string(acceleration));
  EXPECT_NEAR(velocity, 17, 1);
  EXPECT_NEAR(acceleration, 5.5, 0.5);
}

TEST(EncoderNode, noise_at_rest_and_in_slow_motion_is_what_the_documentation_says) {
  for (const double ticks_per_second : {0.0, 37.0}) {
    sim::As5600 chip(0, 5);
    ShaftFilter filter;
    shaft_filter_restart(&filter, chip.counts());
    double velocity = 0, acceleration = 0;
    constexpr int kSamples = 60'000;
    for (int i = 0; i < kSamples; ++i) {
      chip.turn_to((100.25 + ticks_per_second * i * 1e-3) * kTick, 1e-3);
      shaft_filter_update(&filter, chip.counts());
      if (i < 1000) continue;
      const double v = static_cast<double>(filter.speed) * 1e3 * 0x1p-20;
      const double a = static_cast<double>(filter.acceleration) * 1e6 * 0x1p-20;
      velocity += std::pow(v - ticks_per_second, 2);
      acceleration += a * a;
    }
    EXPECT_LT(std::sqrt(velocity / kSamples), 10) << ticks_per_second;
    EXPECT_LT(std::sqrt(acceleration / kSamples), 210) << ticks_per_second;
    EXPECT_GT(std::sqrt(velocity / kSamples), 1) << ticks_per_second;
  }
}

TEST(EncoderNode, without_a_magnet_it_gives_no_position_and_says_why) {
  Cell cell;
  cell.pass(milliseconds(200));
  cell.ask(Register::kStatus);
  cell.chip_.set_field(0);
  cell.pass(milliseconds(20));
  EXPECT_FALSE(cell.ask(Register::kPosition));
  EXPECT_FALSE(cell.ask(Register::kVelocity));
  EXPECT_FALSE(cell.ask(Register::kAcceleration));
  EXPECT_EQ(cell.ask(Register::kStatus)->value, bits::kTooWeak);
  cell.chip_.set_field(1);
  cell.pass(milliseconds(20));
  EXPECT_TRUE(cell.ask(Register::kPosition));
  EXPECT_FALSE(cell.ask(Register::kVelocity)) << "it has only just begun to know the speed";
  cell.pass(milliseconds(200));
  EXPECT_TRUE(cell.ask(Register::kVelocity));
  EXPECT_NE(cell.ask(Register::kStatus)->value & bits::kRestarted, 0);
}

TEST(EncoderNode, stuck_bus_is_silence_for_positions_and_a_count_of_errors) {
  Cell cell;
  cell.pass(milliseconds(200));
  cell.ask(Register::kStatus);
  cell.bus_.set_stuck(true);
  cell.pass(milliseconds(20));
  EXPECT_FALSE(cell.ask(Register::kPosition));
  const std::uint16_t status = cell.ask(Register::kStatus)->value;
  EXPECT_NE(status & bits::kBusError, 0);
  EXPECT_EQ(status & bits::kFresh, 0);
  EXPECT_GT(status >> 8, 15);
  cell.pass(milliseconds(2000));
  EXPECT_EQ(cell.ask(Register::kStatus)->value >> 8, 255);
}

TEST(EncoderNode, few_lost_readings_are_bridged_at_the_speed_that_it_had) {
  Cell cell;
  cell.motion_ = [](double t) { return 5000 * t * kTick; };
  cell.pass(milliseconds(500));
  cell.bus_.set_stuck(true);
  cell.pass(milliseconds(4));
  cell.bus_.set_stuck(false);
  cell.pass(milliseconds(2));
  EXPECT_NEAR(cell.ask(Register::kVelocity)->as_signed(), 5000, 60);
  EXPECT_NE(cell.ask(Register::kStatus)->value >> 8, 0);
}

TEST(EncoderNode, chip_that_lost_its_supply_for_a_moment_never_reads_as_position_zero) {
  Cell cell;
  cell.pass(milliseconds(200));
  for (int i = 0; i < 50; ++i) {
    cell.chip_.power_cycle();
    cell.pass(milliseconds(1));
    const auto position = cell.ask(Register::kPosition);
    ASSERT_TRUE(position);
    EXPECT_NEAR(position->value, 1.0 / kTick, 2);
  }
}

TEST(EncoderNode, board_that_unwraps_knows_the_turns_at_the_top_speed_of_the_motor) {
  Cell cell;
  const double speed = 19342;  // ticks/s: 100 deg/s at the joint behind 17:1
  cell.motion_ = [=](double t) { return (speed / 10 * std::sin(5 * t)) * kTick * 2; };
  cell.pass(milliseconds(10));
  encoder_link::Unwrap unwrap(1.2 * speed);
  for (int i = 0; i < 300; ++i) {
    const auto position = cell.ask(Register::kPosition);
    ASSERT_TRUE(position);
    const Instant read = cell.now_ - 5 * cell.byte_time_;
    const auto ticks = unwrap.update(position->value, read);
    ASSERT_TRUE(ticks);
    const double truth = cell.motion_(to_seconds(read.time_since_epoch())) / kTick;
    EXPECT_NEAR(static_cast<double>(*ticks), truth, 2 * speed * 1.5e-3);  // sample and chip's lag
  }
  EXPECT_TRUE(unwrap.certain());
}

double asks_per_second(double baud, std::span<const Register> names) {
  Cell cell(baud);
  cell.pass(milliseconds(200));
  const double start = cell.seconds();
  constexpr int kRounds = 200;
  for (int i = 0; i < kRounds; ++i) {
    for (const Register name : names) EXPECT_TRUE(cell.ask(name));
  }
  return kRounds / (cell.seconds() - start);
}

TEST(EncoderNode, rates_are_those_of_eight_bytes_on_the_wire) {
  constexpr std::array kOne{Register::kPosition};
  constexpr std::array kThree{Register::kPosition, Register::kVelocity, Register::kAcceleration};
  EXPECT_NEAR(asks_per_second(9600, kOne), 120, 1);
  EXPECT_NEAR(asks_per_second(9600, kThree), 40, 0.5);
  EXPECT_NEAR(asks_per_second(115'200, kOne), 1440, 10);
  EXPECT_NEAR(asks_per_second(115'200, kThree), 480, 4);
}

TEST(EncoderNode, request_cut_by_a_pause_is_not_answered_and_the_next_one_is) {
  Cell cell;
  cell.pass(milliseconds(200));
  cell.node_.receive(std::array<std::uint8_t, 2>{0xAA, 0x01}, cell.now_);
  cell.pass(milliseconds(10));
  cell.node_.receive(std::array<std::uint8_t, 1>{0x55}, cell.now_);
  std::array<std::uint8_t, 8> out{};
  EXPECT_EQ(cell.node_.take_output(out), 0U);
  EXPECT_TRUE(cell.ask(Register::kPosition));
}

TEST(EncoderNode, flood_of_requests_never_cuts_an_answer) {
  Cell cell;
  cell.pass(milliseconds(200));
  for (int i = 0; i < 100; ++i) {
    cell.node_.receive(encoder_link::encode(encoder_link::Request{Register::kPosition}), cell.now_);
  }
  std::array<std::uint8_t, 64> out{};
  const std::size_t size = cell.node_.take_output(out);
  EXPECT_EQ(size, 20U);
  for (std::size_t i = 0; i < size; i += 5) EXPECT_EQ(out[i], 0xAA);
}

TEST(EncoderNode, any_rubbish_on_the_line_leaves_it_answering) {
  test::for_random_cases(300, [](test::Random& random) {
    Cell cell(115'200);
    cell.pass(milliseconds(20));
    for (int i = 0; i < 40; ++i) {
      const auto byte = static_cast<std::uint8_t>(random.bits());
      cell.node_.receive(std::array{random.chance(0.3) ? std::uint8_t{0xAA} : byte}, cell.now_);
      cell.pass(microseconds(random.integer(0, 200)));
    }
    std::array<std::uint8_t, 32> out{};
    while (cell.node_.take_output(out) != 0) {
    }
    const auto position = cell.ask(Register::kPosition);
    ASSERT_TRUE(position);
    EXPECT_NEAR(position->value, 1.0 / kTick, 2);
  });
}

TEST(EncoderNode, never_allocates) {
  sim::As5600 chip(1, 1);
  sim::As5600Bus bus(chip);
  sim::EncoderBoard node(bus, Instant{});
  std::array<std::uint8_t, 8> out{};
  const test::AllocationCounter allocations;
  for (int i = 0; i < 1000; ++i) {
    chip.turn_to(1 + i * 1e-3, 1e-3);
    node.receive(encoder_link::encode(encoder_link::Request{Register::kVelocity}),
                 Instant{milliseconds(i)});
    node.take_output(out);
  }
  EXPECT_EQ(allocations.count(), 0U);
}

/// What the machine replies to a request that arrives at `now`.
std::vector<std::uint8_t> replies(sim::EncoderMachine& machine, Register name, Instant now) {
  machine.receive(encoder_link::encode(encoder_link::Request{name}), now);
  std::array<std::uint8_t, 16> out{};
  const std::size_t size = machine.take_output(out);
  return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)};
}

TEST(EncoderMachine, turns_at_its_speed_and_loses_magnet_and_supply) {
  using sim::Disturbance;
  using Kind = Disturbance::Kind;
  sim::EncoderMachine machine(from_deg(90), 7, Instant{});
  const double first = machine.truth().joints[0].q;
  const Instant second = Instant{std::chrono::seconds(1)};
  const auto position = replies(machine, Register::kPosition, second);
  ASSERT_EQ(position.size(), 5U);
  const double turned = std::remainder(machine.truth().joints[0].q - first, 2 * kPi);
  EXPECT_NEAR(to_deg(turned), 90, 0.01);
  const int ticks = position[2] | position[3] << 8;
  EXPECT_NEAR(std::remainder(ticks * kTick - machine.truth().joints[0].q, 2 * kPi), 0, 3 * kTick);
  const auto speed = replies(machine, Register::kVelocity, second);
  ASSERT_EQ(speed.size(), 5U);
  EXPECT_NEAR(speed[2] | speed[3] << 8, 1024, 30);

  machine.disturb({.kind = Kind::kMagnet, .joint = 0, .value = 0});
  machine.advance(second + milliseconds(20));
  EXPECT_TRUE(replies(machine, Register::kPosition, second + milliseconds(20)).empty());
  EXPECT_FALSE(replies(machine, Register::kStatus, second + milliseconds(20)).empty());
  machine.disturb({.kind = Kind::kSupply, .value = 2});
  EXPECT_TRUE(replies(machine, Register::kStatus, second + milliseconds(40)).empty());
  machine.disturb({.kind = Kind::kSupply, .value = 5});
  machine.disturb({.kind = Kind::kMagnet, .joint = 0, .value = 1});
  machine.advance(second + milliseconds(400));
  const auto status = replies(machine, Register::kStatus, second + milliseconds(400));
  ASSERT_EQ(status.size(), 5U);
  EXPECT_NE(status[2] & bits::kRestarted, 0) << "turns may be missing";
}

}  // namespace
}  // namespace sinew
