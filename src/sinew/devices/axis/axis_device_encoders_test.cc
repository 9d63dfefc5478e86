#include "sinew/devices/axis/axis_device_encoders.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/property.h"

namespace sinew {
namespace {

using test::for_random_cases;
using test::Random;

constexpr double kTick = 1e-3;

/// Readings of a joint at q, with both shafts mounted anyhow.
AxisInputs at(double q, double mounting = 1.234) {
  AxisInputs inputs;
  const auto motor = static_cast<std::int64_t>(std::floor((q * 17 + mounting) / (2 * kPi) * 4096));
  inputs.motor_counts = static_cast<std::uint16_t>(((motor % 4096) + 4096) % 4096);
  inputs.joint_counts = static_cast<std::int32_t>(std::floor(q / (2 * kPi) * 2400));
  return inputs;
}

TEST(EncoderChannel, unwraps_at_half_a_turn_in_both_directions) {
  EncoderChannel channel(4096, 1e6, 1);
  channel.read(4000, true, kTick);
  channel.read(100, true, kTick);
  EXPECT_EQ(channel.counts(), 196);
  channel.read(4090, true, kTick);
  EXPECT_EQ(channel.counts(), 90);
  channel.read((4090 + 2047) % 4096, true, 1);
  EXPECT_EQ(channel.counts(), 90 + 2047);
}

TEST(EncoderChannel, quadrature_counter_may_run_over_its_32_bits) {
  EncoderChannel channel(0, 1e4, 1);
  channel.read(std::numeric_limits<std::int32_t>::max() - 1, true, kTick);
  channel.read(std::numeric_limits<std::int32_t>::min() + 3, true, kTick);
  EXPECT_EQ(channel.counts(), 5);
}

TEST(EncoderChannel, jump_that_no_shaft_makes_is_a_missing_reading) {
  EncoderChannel channel(4096, 1000, 0.02);
  channel.read(0, true, kTick);
  channel.read(500, true, kTick);
  EXPECT_FALSE(channel.good());
  channel.read(1, true, kTick);
  EXPECT_FALSE(channel.good());
  channel.read(1, true, kTick);
  EXPECT_TRUE(channel.good());
  EXPECT_EQ(channel.counts(), 1);
  EXPECT_FALSE(channel.lost());
}

TEST(EncoderChannel, glitch_that_a_gap_would_excuse_is_not_believed) {
  EncoderChannel channel(4096, 40'000, 0.02);
  channel.read(0, true, kTick);
  for (int i = 0; i < 13; ++i) channel.read(0, false, kTick);
  channel.read(512, true, kTick);
  EXPECT_FALSE(channel.good());
  channel.read(3, true, kTick);
  channel.read(3, true, kTick);
  EXPECT_TRUE(channel.good());
  EXPECT_EQ(channel.counts(), 3);
}

TEST(EncoderChannel, number_that_is_no_position_is_a_missing_reading) {
  EncoderChannel channel(4096, 1e9, 0.02);
  channel.read(7, true, kTick);
  channel.read(4096, true, kTick);
  EXPECT_FALSE(channel.good());
  channel.read(-1, true, kTick);
  EXPECT_FALSE(channel.good());
}

TEST(EncoderChannel, gap_that_is_too_long_stays_a_loss) {
  EncoderChannel channel(4096, 1e5, 0.02);
  channel.read(0, true, kTick);
  for (int i = 0; i < 19; ++i) channel.read(0, false, kTick);
  EXPECT_FALSE(channel.lost());
  channel.read(0, false, 2 * kTick);
  channel.read(0, true, kTick);
  channel.read(0, true, kTick);
  EXPECT_TRUE(channel.good());
  EXPECT_TRUE(channel.lost());
  channel.restart();
  channel.read(300, true, kTick);
  EXPECT_FALSE(channel.lost());
  EXPECT_EQ(channel.counts(), 0);
}

TEST(AxisEncoders, counts_over_any_number_of_turns) {
  AxisEncoders encoders(AxisEncoderSettings{});
  encoders.read(at(0), 0);
  double q = 0;
  const double speed = from_deg(150);
  for (int i = 0; i < 4'000; ++i) encoders.read(at(q += speed * kTick), kTick);
  for (int i = 0; i < 9'000; ++i) encoders.read(at(q -= speed * kTick), kTick);
  EXPECT_NEAR(encoders.q(), q, 2 * kPi / 4096 / 17 + 1e-9);
  EXPECT_NEAR(encoders.joint_q(), q, 2 * kPi / 2400 + 1e-9);
  EXPECT_NEAR(encoders.qd(), -speed, from_deg(0.3));
  EXPECT_FALSE(encoders.motor_lost());
}

TEST(AxisEncoders, velocity_has_the_stated_bandwidth_and_noise) {
  AxisEncoders encoders(AxisEncoderSettings{});
  encoders.read(at(0), 0);
  // A step of the velocity is there within 5 % after 50 ms...
  const double speed = from_deg(10);
  double q = 0;
  for (int i = 0; i < 50; ++i) encoders.read(at(q += speed * kTick), kTick);
  EXPECT_NEAR(encoders.qd(), speed, 0.05 * speed);
  // ...and the counts show as a third of a degree per second.
  double worst = 0;
  for (int i = 0; i < 2'000; ++i) {
    encoders.read(at(q += speed * kTick), kTick);
    worst = std::max(worst, std::abs(encoders.qd() - speed));
  }
  std::cout << "  velocity noise " << to_deg(worst) << " deg/s\n";
  EXPECT_LT(to_deg(worst), 0.35);
}

TEST(AxisEncoders, named_mark_is_that_place_for_both) {
  AxisEncoders encoders(AxisEncoderSettings{});
  encoders.read(at(0), 0);
  for (int i = 1; i <= 100; ++i) encoders.read(at(i * 1e-3), kTick);
  encoders.mark();
  for (int i = 101; i <= 150; ++i) encoders.read(at(i * 1e-3), kTick);
  const double before = encoders.q();
  const double jump = encoders.name_mark(-2, -2.001);
  EXPECT_NEAR(encoders.q(), -2.001 + 0.05, 1e-4);
  EXPECT_NEAR(encoders.q() - before, jump, 1e-12);
  EXPECT_NEAR(encoders.joint_q(), -2 + 0.05, 2 * kPi / 2400);
}

TEST(AxisEncoders, disagreement_is_what_the_joint_says_beyond_the_motor) {
  AxisEncoders encoders(AxisEncoderSettings{});
  encoders.read(at(0), 0);
  for (int i = 1; i <= 500; ++i) {
    AxisInputs inputs = at(0);
    inputs.joint_counts = 7;
    encoders.read(inputs, kTick);
  }
  EXPECT_NEAR(encoders.disagreement(), 7 * 2 * kPi / 2400, 1e-5);
}

TEST(AxisEncoders, axis_without_a_joint_encoder_relies_on_the_motors) {
  AxisEncoderSettings settings;
  settings.joint = JointEncoder::kNone;
  AxisEncoders encoders(settings);
  for (int i = 0; i < 100; ++i) {
    AxisInputs inputs = at(0.1);
    inputs.joint_encoder_ok = false;
    inputs.joint_counts = i * 1000;
    encoders.read(inputs, kTick);
  }
  EXPECT_TRUE(encoders.good());
  EXPECT_FALSE(encoders.joint_lost());
  EXPECT_EQ(encoders.disagreement(), 0);
}

TEST(AxisEncoders, shafts_that_count_backwards_are_only_a_sign) {
  AxisEncoderSettings settings;
  settings.motor_counts_per_turn = -4096;
  settings.joint_counts_per_turn = -2400;
  AxisEncoders encoders(settings);
  encoders.read(at(0), 0);
  for (int i = 1; i <= 300; ++i) encoders.read(at(-i * 1e-3), kTick);
  EXPECT_NEAR(encoders.q(), 0.3, 2e-4);
  EXPECT_NEAR(encoders.joint_q(), 0.3, 3e-3);
}

TEST(AxisEncoders, any_walk_with_missing_and_flipped_readings_is_right_or_lost) {
  for_random_cases(300, [](Random& random) {
    AxisEncoders encoders(AxisEncoderSettings{});
    const double mounting = random.uniform(0, 2 * kPi);
    double q = 0, qd = 0;
    bool flipped = false;
    int right = 0;
    encoders.read(at(q, mounting), 0);
    for (int i = 0; i < 2'000; ++i) {
      const double dt = random.uniform(2e-4, 5e-3);
      qd = std::clamp(qd + random.uniform(-5, 5) * dt, -from_deg(60), from_deg(60));
      q += qd * dt;
      AxisInputs inputs = at(q, mounting);
      if (random.chance(0.05)) inputs.motor_encoder_ok = false;
      // A flipped bit of a high order, not twice in a row.
      const auto bit = static_cast<std::uint16_t>(1U << random.integer(9, 11));
      flipped = !flipped && random.chance(0.02);
      if (flipped) inputs.motor_counts ^= bit;
      encoders.read(inputs, dt);
      if (encoders.motor_lost()) break;
      ASSERT_NEAR(encoders.motor_good() ? encoders.q() : q, q, 2e-4);
      right += encoders.motor_good() ? 1 : 0;
    }
    ASSERT_GT(right, 0);
  });
}

/// An encoder node replies each 4 ms, and what it says is 4 ms old.
TEST(AxisEncoders, readings_that_come_late_and_seldom_are_no_disagreement) {
  AxisEncoderSettings settings;
  settings.joint_node = true;
  AxisEncoders encoders(settings);
  const auto angle = [](double t) { return from_deg(180) * std::max(0.0, t - 0.1); };
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    const double t = i * kTick;
    AxisInputs inputs = at(angle(t));
    inputs.joint_fresh = i % 4 == 0;
    inputs.joint_age = 4e-3;
    if (inputs.joint_fresh) inputs.joint_counts = at(angle(t - 4e-3)).joint_counts;
    encoders.read(inputs, kTick);
    worst = std::max(worst, std::abs(encoders.disagreement()));
  }
  EXPECT_FALSE(encoders.joint_lost());
  EXPECT_LT(worst, from_deg(0.3));
}

TEST(AxisEncoders, a_node_that_is_silent_for_60_ms_is_lost) {
  AxisEncoderSettings settings;
  settings.joint_node = true;
  AxisEncoders encoders(settings);
  AxisInputs inputs = at(0.1);
  encoders.read(inputs, kTick);
  inputs.joint_fresh = false;
  for (int i = 0; i < 58; ++i) encoders.read(inputs, kTick);
  EXPECT_FALSE(encoders.joint_lost());
  for (int i = 0; i < 5; ++i) encoders.read(inputs, kTick);
  EXPECT_TRUE(encoders.joint_lost());
  EXPECT_FALSE(encoders.motor_lost());
}

}  // namespace
}  // namespace sinew
