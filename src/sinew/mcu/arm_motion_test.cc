#include "sinew/mcu/arm_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "support/property.h"

namespace sinew::mcu {
namespace {

using Targets = std::array<std::int32_t, kArmAxes>;
constexpr std::array<ArmRamp, kArmAxes> kRamps{
    {{3200, 200, 200}, {400, 100, 100}, {3200, 100, 100}, {3200, 100, 100}, {3200, 100, 100}}};

struct Bench {
  ArmMotion motion;
  std::array<double, kArmAxes> at{};     ///< steps
  std::array<double, kArmAxes> speed{};  ///< of the last ms, steps/ms
  std::array<double, kArmAxes> top{};
  std::array<double, kArmAxes> gain{};  ///< largest change of speed, steps/ms^2
  int ms = 0;

  void slice() {
    motion.slice();
    for (int i = 0; i < StepPulses::kTicks; ++i) motion.pulses().tick();
    for (std::uint8_t i = 0; i < kArmAxes; ++i) {
      const double now = motion.position(i) / 256.0;
      const double went = now - at[i];
      gain[i] = std::max(gain[i], std::abs(went - speed[i]));
      top[i] = std::max(top[i], std::abs(went));
      speed[i] = went;
      at[i] = now;
    }
    ++ms;
  }
  bool finish(int limit) {
    for (int i = 0; i < limit && motion.moving(); ++i) slice();
    return !motion.moving();
  }
};

TEST(ArmMotion, a_goto_ends_at_its_targets_inside_its_limits_and_in_time) {
  test::for_random_cases(60, [](test::Random& random) {
    Bench run;
    for (int leg = 0; leg < 3; ++leg) {
      Targets targets{};
      for (auto& target : targets) target = static_cast<std::int32_t>(random.integer(-4000, 4000));
      if (random.chance(0.2)) targets[2] = 0;
      auto ramps = kRamps;
      for (auto& ramp : ramps) {
        ramp.speed = static_cast<std::uint16_t>(random.integer(20, 300));
        ramp.acceleration = static_cast<std::uint16_t>(random.integer(20, 300));
      }
      const auto start = run.at;
      const int began = run.ms;
      run.top = run.gain = {};
      run.motion.go_to(targets.data(), ramps.data(), random.chance(0.5));
      double longest = 0;
      for (std::size_t i = 0; i < kArmAxes; ++i) {
        const double v = ramps[i].speed * ramps[i].steps_per_rev / 1e5;
        const double a = ramps[i].acceleration * ramps[i].steps_per_rev / 1e8;
        const double way = std::abs(targets[i] - start[i]);
        longest = std::max(longest, way > v * v / a ? way / v + v / a : 2 * std::sqrt(way / a));
      }
      ASSERT_TRUE(run.finish(400'000));
      EXPECT_GE(run.ms - began, longest * 0.999 - 2);
      // All with one profile may take longer: slowest ramp and slowest speed come together.
      EXPECT_LE(run.ms - began, 3.1 * longest + 5);
      for (std::size_t i = 0; i < kArmAxes; ++i) {
        EXPECT_EQ(run.at[i], targets[i]) << i;
        EXPECT_EQ(run.motion.pulses().steps(static_cast<std::uint8_t>(i)), targets[i]) << i;
        const double v = ramps[i].speed * ramps[i].steps_per_rev / 1e5;
        const double a = ramps[i].acceleration * ramps[i].steps_per_rev / 1e8;
        EXPECT_LE(run.top[i], v + 0.02) << i;
        EXPECT_LE(run.gain[i], a + 0.02) << i;  // positions are read to 1/256 step
      }
    }
  });
}

TEST(ArmMotion, the_documents_goto_takes_the_time_of_its_trapezoids) {
  Bench run;
  const Targets targets{-2400, 600, -5000, 800, -1000};
  run.motion.go_to(targets.data(), kRamps.data(), false);
  ASSERT_TRUE(run.finish(10'000));
  // The elbow: 5000 steps at 3200 steps/s and 3200 steps/s^2.
  EXPECT_NEAR(run.ms, 1000 * (5000.0 / 3200 + 1), 3);
}

ArmSegment segment(int ms, const Targets& targets_256, const std::array<std::int16_t, 5>& speeds) {
  ArmSegment segment = {};
  segment.ms = static_cast<std::uint8_t>(ms);
  segment.gripper = kGripperStays;
  for (std::size_t i = 0; i < kArmAxes; ++i) {
    segment.targets[i] = targets_256[i];
    segment.velocities[i] = speeds[i];
  }
  return segment;
}

TEST(ArmMotion, a_stream_passes_every_end_and_is_smooth_between_them) {
  test::for_random_cases(200, [](test::Random& random) {
    Bench run;
    const double way = random.uniform(-3000, 3000);
    const double seconds = random.uniform(1, 2);
    const int step = static_cast<int>(random.integer(8, kSegmentMsMax));
    const int pieces = static_cast<int>(seconds * 1000) / step;
    const double whole = pieces * step / 1000.0;
    const auto at = [&](double t) {
      return way / 2 * (1 - std::cos(t / whole * 3.14159265358979));
    };
    for (int k = 1; k <= pieces;) {
      const double t = k * step / 1000.0;
      const double speed = k == pieces ? 0 : (at(t + 1e-5) - at(t - 1e-5)) / 2e-5 / 1000 * 1024;
      Targets targets{};
      std::array<std::int16_t, 5> speeds{};
      targets.fill(static_cast<std::int32_t>(std::lround(at(t) * 256)));
      speeds.fill(static_cast<std::int16_t>(std::lround(speed)));
      const auto refusal = run.motion.push(segment(step, targets, speeds));
      ASSERT_TRUE(refusal == SegmentRefusal::kNone || refusal == SegmentRefusal::kFull);
      if (refusal == SegmentRefusal::kNone) ++k;
      if (run.motion.queued_ms() > 60 || refusal == SegmentRefusal::kFull) run.slice();
      ASSERT_FALSE(run.motion.coasting());
    }
    ASSERT_TRUE(run.finish(3000));
    EXPECT_NEAR(run.at[4], way, 1.0 / 256);
    // The plan's own largest change of speed, and what a cubic makes of it.
    const double most = std::abs(way) / 2 * std::pow(3.14159265358979 / whole, 2) / 1e6;
    EXPECT_LE(run.gain[0], 2 * most + 0.04);  // positions are read to 1/256 step
  });
}

TEST(ArmMotion, segments_that_no_axis_follows_are_refused_and_move_nothing) {
  const Targets none{};
  for (const auto& bad :
       {segment(0, none, {}), segment(51, none, {}), segment(10, {0, 0, 12 * 2560 + 1, 0, 0}, {}),
        segment(10, none, {0, 12 * 1024 + 1, 0, 0, 0}), segment(50, {INT32_MIN, 0, 0, 0, 0}, {}),
        segment(50, {INT32_MAX, 0, 0, 0, 0}, {})}) {
    Bench run;
    EXPECT_EQ(run.motion.push(bad), SegmentRefusal::kRange);
    run.slice();
    EXPECT_FALSE(run.motion.moving());
  }
  Bench run;
  for (int i = 0; i < ArmMotion::kQueue; ++i) {
    EXPECT_EQ(run.motion.push(segment(10, none, {})), SegmentRefusal::kNone);
  }
  EXPECT_EQ(run.motion.push(segment(10, none, {})), SegmentRefusal::kFull);
  EXPECT_EQ(run.motion.queued_ms(), 160);
}

TEST(ArmMotion, a_stop_brakes_all_axes_in_one_time_along_their_direction) {
  test::for_random_cases(200, [](test::Random& random) {
    Bench run;
    Targets targets{};
    for (auto& target : targets) target = static_cast<std::int32_t>(random.integer(-6000, 6000));
    run.motion.go_to(targets.data(), kRamps.data(), true);
    const auto until = random.integer(50, 1500);
    for (int i = 0; i < until; ++i) run.slice();
    const bool quick = std::ranges::any_of(run.speed, [](double v) { return std::abs(v) > 0.2; });
    if (!run.motion.moving() || !quick) return random.discard();
    const auto before = run.at;
    const auto speed = run.speed;
    run.gain = {};
    std::array<std::uint32_t, kArmAxes> brakings{};
    for (std::size_t i = 0; i < kArmAxes; ++i) {
      brakings[i] = static_cast<std::uint32_t>(kRamps[i].acceleration * kRamps[i].steps_per_rev *
                                               1.048576e6 / 1e8) +
                    1;
    }
    run.motion.stop(brakings.data());
    ASSERT_TRUE(run.finish(3000));
    for (std::size_t i = 0; i < kArmAxes; ++i) {
      EXPECT_LE(run.gain[i], brakings[i] / 1048576.0 + 0.02) << i;
    }
    const auto fastest =
        std::ranges::max_element(speed, {}, [](double v) { return std::abs(v); }) - speed.begin();
    const auto f = static_cast<std::size_t>(fastest);
    const double longest = (run.at[f] - before[f]) / speed[f];
    for (std::size_t i = 0; i < kArmAxes; ++i) {
      EXPECT_NEAR(run.at[i] - before[i], speed[i] * longest, 0.02 * longest + 1) << i;
    }
  });
}

}  // namespace
}  // namespace sinew::mcu
