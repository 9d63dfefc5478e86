#include "sinew/devices/axis/axis_device_controller.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sinew/devices/axis/axis_device_test_cell.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

using test::AxisCell;
using test::for_random_cases;
using test::homed_cell;
using test::kTruth;
using test::LimitWatch;
using test::Random;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// --- homing ------------------------------------------------------------------------------------

TEST(AxisController, knows_nothing_before_it_is_homed_and_refuses_to_move) {
  AxisCell cell(0.3);
  cell.run(0.2);
  EXPECT_FALSE(cell.status().position_ok);
  EXPECT_EQ(cell.controller.move_to(0), AxisVerdict::kNotHomed);
  EXPECT_EQ(cell.controller.track(0, 0), AxisVerdict::kNotHomed);
  const double before = cell.plant.q();
  cell.run(1);
  EXPECT_NEAR(cell.plant.q(), before, 1e-4);
}

TEST(AxisController, homing_finds_zero_and_ends_inside_the_limits) {
  const AxisCell& cell = homed_cell();
  EXPECT_TRUE(cell.status().homed);
  EXPECT_TRUE(cell.status().position_ok);
  EXPECT_FALSE(cell.status().end_stop);
  EXPECT_LT(cell.error(), kTruth);
  EXPECT_NEAR(cell.status().q, cell.controller.settings().homing.clear_angle, from_deg(0.1));
}

TEST(AxisController, homing_again_and_again_finds_the_same_zero) {
  double least = 1, most = -1;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    AxisCell cell(from_deg(-170 + 0.37 * static_cast<double>(seed)), test::test_settings(), seed);
    ASSERT_TRUE(cell.home()) << seed;
    const double offset = cell.status().q - cell.plant.q();
    least = std::min(least, offset);
    most = std::max(most, offset);
  }
  // Two counts of the motor's encoder (0.005 deg each) and the bounces of the switch.
  RecordProperty("repeatability_microrad", std::to_string((most - least) * 1e6));
  std::cout << "  repeatability " << to_deg(most - least) << " deg\n";
  EXPECT_LT(to_deg(most - least), 0.04);
}

TEST(AxisController, homing_from_a_closed_switch_first_leaves_it) {
  AxisCell cell(from_deg(-172.5));
  cell.run(0.2);
  EXPECT_TRUE(cell.status().end_stop);
  const double start = cell.plant.q();
  double lowest = start;
  ASSERT_EQ(cell.controller.home(), AxisVerdict::kAccepted);
  cell.run_until(
      [&] {
        lowest = std::min(lowest, cell.plant.q());
        return !cell.status().homing;
      },
      60);
  EXPECT_TRUE(cell.status().homed);
  EXPECT_LT(cell.error(), kTruth);
  EXPECT_GT(lowest, start - from_deg(0.5));
}

TEST(AxisController, switch_that_stays_closed_is_stuck_and_the_search_is_bounded) {
  AxisCell cell(from_deg(-100));
  cell.spoil = [](AxisInputs& inputs) { inputs.end_stop = true; };
  cell.run(0.2);
  const double start = cell.plant.q();
  ASSERT_EQ(cell.controller.home(), AxisVerdict::kAccepted);
  cell.tick();
  ASSERT_TRUE(cell.run_until([&] { return !cell.status().homing; }, 30));
  EXPECT_EQ(cell.status().fault, AxisFault::kEndStopStuck);
  EXPECT_FALSE(cell.status().homed);
  EXPECT_NEAR(to_deg(cell.plant.q() - start), 8, 1);
}

TEST(AxisController, dead_switch_ends_on_the_mechanical_end_as_a_stall) {
  AxisCell cell(from_deg(-165));
  cell.spoil = [](AxisInputs& inputs) { inputs.end_stop = false; };
  cell.run(0.2);
  ASSERT_EQ(cell.controller.home(), AxisVerdict::kAccepted);
  cell.tick();
  ASSERT_TRUE(cell.run_until([&] { return !cell.status().homing; }, 30));
  EXPECT_EQ(cell.status().fault, AxisFault::kStalled);
  EXPECT_FALSE(cell.status().homed);
  const auto frozen = cell.outputs.steps;
  cell.run(1);
  EXPECT_EQ(cell.outputs.steps, frozen);
}

TEST(AxisController, search_that_finds_nothing_ends_after_the_whole_way) {
  AxisSettings settings = test::test_settings();
  settings.homing.travel_max = from_deg(20);
  AxisCell cell(from_deg(100), settings);
  cell.run(0.2);
  const double start = cell.plant.q();
  ASSERT_EQ(cell.controller.home(), AxisVerdict::kAccepted);
  cell.tick();
  ASSERT_TRUE(cell.run_until([&] { return !cell.status().homing; }, 60));
  EXPECT_EQ(cell.status().fault, AxisFault::kHomingTimeout);
  EXPECT_NEAR(to_deg(start - cell.plant.q()), 20, 0.5);
}

TEST(AxisController, cancelled_homing_comes_to_rest_from_any_phase) {
  for (int i = 0; i < 23; ++i) {
    const double after = 0.3 + 0.7 * i;
    AxisCell cell(from_deg(-165));
    cell.run(0.2);
    ASSERT_EQ(cell.controller.home(), AxisVerdict::kAccepted);
    cell.run(after);
    if (!cell.status().homing) break;
    LimitWatch watch(cell, cell.controller.settings().tracking_jerk);
    watch.lower = -10, watch.upper = 10;
    cell.controller.cancel_homing();
    EXPECT_FALSE(cell.status().homing);
    cell.run_until(
        [&] {
          watch.look(cell);
          return !cell.status().moving;
        },
        5);
    EXPECT_FALSE(cell.status().moving) << after;
    EXPECT_LT(watch.worst, 1e-6) << after;
    const double rest = cell.plant.q();
    cell.run(1);
    EXPECT_NEAR(cell.plant.q(), rest, from_deg(0.02));
    EXPECT_LT(cell.status().homed ? cell.error() : 0, kTruth);
  }
}

// --- motion ------------------------------------------------------------------------------------

TEST(AxisController, move_arrives_where_it_was_sent) {
  AxisCell cell = homed_cell();
  for (const double target_deg : {-120.0, -119.9, -150.0, -135.5}) {
    const double target = from_deg(target_deg);
    ASSERT_EQ(cell.controller.move_to(target), AxisVerdict::kAccepted);
    EXPECT_EQ(cell.status().q_target, target);
    ASSERT_TRUE(cell.run_to_rest());
    cell.run(1);
    EXPECT_NEAR(cell.status().q, target, from_deg(0.02)) << target_deg;
    EXPECT_LT(cell.error(), kTruth) << target_deg;
    EXPECT_EQ(cell.controller.reference().q, target);
    EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  }
}

TEST(AxisController, ninety_degrees_take_the_time_of_the_documented_profile) {
  AxisCell cell = homed_cell();
  const double from = cell.controller.reference().q;
  ASSERT_EQ(cell.controller.move_to(from + from_deg(90)), AxisVerdict::kAccepted);
  const Instant start = cell.now;
  ASSERT_TRUE(cell.run_to_rest());
  // 7.083 s, and the loop's settling to 0.1 deg.
  EXPECT_NEAR(to_seconds(cell.now - start), 7.083, 0.15);
}

TEST(AxisController, targets_that_are_no_place_in_the_limits_are_refused) {
  AxisCell cell = homed_cell();
  const double before = cell.controller.reference().q;
  for (const double q : {kNan, std::numeric_limits<double>::infinity(), from_deg(170.001),
                         from_deg(-170.001), -1e300}) {
    EXPECT_EQ(cell.controller.move_to(q), AxisVerdict::kOutOfLimits) << q;
    EXPECT_EQ(cell.controller.track(q, 0), AxisVerdict::kOutOfLimits) << q;
  }
  EXPECT_EQ(cell.controller.track(before, kNan), AxisVerdict::kOutOfLimits);
  cell.run(0.5);
  EXPECT_EQ(cell.controller.reference().q, before);
  EXPECT_EQ(cell.controller.move_to(from_deg(170)), AxisVerdict::kAccepted);
}

TEST(AxisController, axis_that_was_pushed_beyond_its_limit_goes_inward_only) {
  AxisSettings settings = test::test_settings();
  settings.emergency_stop = EmergencyStopAction::kPowerOff;
  settings.lower = from_deg(-140);
  settings.upper = from_deg(-130);
  for (const double push : {-3.0, 3.0}) {
    AxisCell cell(from_deg(-165), settings);
    ASSERT_TRUE(cell.home());
    cell.controller.emergency_stop();
    cell.tick();
    cell.plant.set_load(push, 20);  // slowly
    const double far = from_deg(push < 0 ? -143 : -127);
    ASSERT_TRUE(cell.run_until([&] { return (cell.plant.q() - far) * push > 0; }, 60));
    cell.controller.release_emergency_stop();
    cell.plant.set_load(0, 0.1);
    cell.run(1);
    ASSERT_TRUE(cell.status().position_ok);
    const double here = cell.controller.reference().q;
    const double inward = push < 0 ? 1 : -1;
    EXPECT_TRUE(here < settings.lower || here > settings.upper) << to_deg(here);
    EXPECT_EQ(cell.controller.move_to(here - inward * from_deg(1)), AxisVerdict::kOutOfLimits);
    EXPECT_EQ(cell.controller.track(here - inward * from_deg(1), 0), AxisVerdict::kOutOfLimits);
    // To a place that is still outside, by a stream through the limit, and inside as ever.
    ASSERT_EQ(cell.controller.move_to(here + inward * from_deg(1)), AxisVerdict::kAccepted);
    ASSERT_TRUE(cell.run_to_rest());
    EXPECT_NEAR(cell.plant.q(), here + inward * from_deg(1), kTruth);
    const double begin = cell.controller.reference().q;
    for (int i = 0; i <= 5000; ++i) {
      const double share = i / 5000.0;
      const double q = begin + inward * from_deg(4) * share * share * (3 - 2 * share);
      const double qd = inward * from_deg(4) * 6 * share * (1 - share) / 5;
      if (i % 5 == 0) {
        ASSERT_EQ(cell.controller.track(q, qd), AxisVerdict::kAccepted) << i;
      }
      cell.tick();
    }
    ASSERT_TRUE(cell.run_to_rest());
    EXPECT_NEAR(cell.plant.q(), begin + inward * from_deg(4), kTruth);
    EXPECT_EQ(cell.status().fault, AxisFault::kNone);
    const double across = push < 0 ? settings.upper + 0.01 : settings.lower - 0.01;
    EXPECT_EQ(cell.controller.move_to(across), AxisVerdict::kOutOfLimits);
  }
}

TEST(AxisController, stop_brakes_inside_the_limits_and_holds) {
  AxisCell cell = homed_cell();
  ASSERT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
  cell.run(3);
  LimitWatch watch(cell, cell.controller.settings().limits.jerk);
  const double qd = cell.controller.reference().qd;
  EXPECT_GT(to_deg(qd), 10);
  cell.controller.stop();
  cell.run_until(
      [&] {
        watch.look(cell);
        return !cell.status().moving;
      },
      5);
  EXPECT_LT(watch.worst, 1e-6);
  EXPECT_FALSE(cell.status().moving);
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  cell.run(1);
  const double rest = cell.status().q;
  cell.run(2);
  EXPECT_NEAR(cell.status().q, rest, from_deg(0.02));
  EXPECT_LT(cell.error(), kTruth);
}

TEST(AxisController, streamed_motion_is_followed_and_ends_on_its_last_setpoint) {
  AxisCell cell = homed_cell();
  const auto plan = motion::OnlineProfile::to(
      cell.controller.reference(), from_deg(-100),
      motion::ProfileBounds(motion::AxisLimits{from_deg(25), from_deg(9), from_deg(9)}));
  LimitWatch watch(cell, cell.controller.settings().tracking_jerk);
  double worst = 0;
  for (int i = 0; i < 9'000; ++i) {
    if (i % 4 == 0) {
      const motion::AxisState setpoint = plan.at((i + 4) * 1e-3);
      ASSERT_EQ(cell.controller.track(setpoint.q, setpoint.qd), AxisVerdict::kAccepted);
    }
    cell.tick();
    watch.look(cell);
    const double told = plan.at(std::max(0.0, i * 1e-3 - motion::SetpointFollower::kDelay)).q;
    worst = std::max(worst, std::abs(cell.status().q - told));
  }
  EXPECT_LT(watch.worst, 1e-6);
  EXPECT_LT(to_deg(worst), 0.15);
  EXPECT_NEAR(cell.status().q, from_deg(-100), from_deg(0.02));
  EXPECT_LT(cell.error(), kTruth);
  EXPECT_FALSE(cell.status().moving);
}

TEST(AxisController, joint_does_not_run_ahead_of_a_stream_with_jitter) {
  for_random_cases(8, [](Random& random) {
    AxisCell cell = homed_cell();
    const double from = cell.controller.reference().q;
    const double to = from + from_deg(random.uniform(5, 30));
    const auto plan = motion::OnlineProfile::to(
        cell.controller.reference(), to, motion::ProfileBounds(cell.controller.settings().limits));
    const auto told = [&](double t) { return plan.at(std::clamp(t, 0.0, plan.duration())); };
    double sends = 0, round = 1e-3, beyond = 0, apart = 0;
    for (int i = 1; i * 1e-3 < plan.duration() + 1; ++i) {
      const double t = i * 1e-3;
      while (sends < t) {
        const motion::AxisState setpoint = told(sends + round);
        ASSERT_EQ(cell.controller.track(setpoint.q, setpoint.qd), AxisVerdict::kAccepted);
        round = random.uniform(0.5e-3, 3e-3);
        sends += round;
      }
      cell.tick();
      beyond = std::max(beyond, cell.plant.q() - to);
      const double late = told(t - motion::SetpointFollower::kDelay).q;
      apart = std::max(apart, std::abs(cell.plant.q() - late));
    }
    // Half the play and the counts, as without jitter.
    EXPECT_LT(beyond, kTruth);
    EXPECT_LT(to_deg(apart), 0.22);
    EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  });
}

TEST(AxisController, stream_that_it_cannot_follow_is_a_following_error) {
  AxisCell cell = homed_cell();
  const double from = cell.controller.reference().q;
  for (int i = 0; i < 100; ++i) {
    (void)cell.controller.track(from + from_deg(1), 0);
    cell.tick();
  }
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  for (int i = 0; i < 100; ++i) {
    (void)cell.controller.track(from + from_deg(8), 0);
    cell.tick();
  }
  EXPECT_EQ(cell.status().fault, AxisFault::kFollowingError);
  ASSERT_TRUE(cell.run_to_rest(5));
  EXPECT_LT(to_deg(std::abs(cell.status().q - from)), 2);
  EXPECT_TRUE(cell.status().position_ok);
}

TEST(AxisController, stream_that_falls_silent_in_motion_is_a_stop) {
  AxisCell cell = homed_cell();
  const double from = cell.controller.reference().q;
  for (int i = 0; i < 3'000; ++i) {
    const double t = i * 1e-3;
    if (i % 5 == 0) (void)cell.controller.track(from + from_deg(2) * t * t, from_deg(4) * t);
    cell.tick();
  }
  EXPECT_GT(to_deg(cell.controller.reference().qd), 8);
  ASSERT_TRUE(cell.run_until([&] { return !cell.status().moving; }, 3));
  EXPECT_EQ(cell.controller.reference().qd, 0);
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
}

/// Streams a ramp up to `speed` and some time of it, then nothing for so many ticks.
void break_off_a_stream(AxisCell& cell, double speed, int silent_ticks) {
  const double ramp = 2 * std::sqrt(speed / cell.controller.settings().limits.jerk);
  double q = cell.controller.reference().q;
  for (double t = 0; t < ramp + 0.3; t += 1e-3) {
    const double share = std::min(t / ramp, 1.0);
    const double qd = speed * share * share * (3 - 2 * share);
    q += qd * 1e-3;
    ASSERT_EQ(cell.controller.track(q, qd), AxisVerdict::kAccepted);
    cell.tick();
  }
  for (int i = 0; i < silent_ticks; ++i) cell.tick();
}

// A million faults, seed 20261121, case 0: a slow stream broke off, the axis braked, its deadline
// came 0.1 s after the last setpoint, and the stop ran 3 deg back the way that it had come.
TEST(AxisController, stop_or_move_after_a_stream_that_broke_off_does_not_turn_round) {
  const AxisCell homed = homed_cell();
  enum class Then : std::uint8_t { kDeadline, kManyStops, kMoveOn };
  const auto run = [&](double speed, int silent_ticks, Then then) {
    AxisCell cell = homed;
    break_off_a_stream(cell, speed, silent_ticks);
    LimitWatch watch(cell, cell.controller.settings().tracking_jerk);
    double farthest = cell.controller.reference().q;
    double back = 0;
    if (then == Then::kDeadline) cell.controller.stop(AxisFault::kLinkSilent);
    if (then == Then::kMoveOn) (void)cell.controller.move_to(farthest + from_deg(10));
    for (int i = 0; i < 5'000; ++i) {
      if (then == Then::kManyStops) cell.controller.stop();
      cell.tick();
      watch.look(cell);
      farthest = std::max(farthest, cell.controller.reference().q);
      back = std::max(back, farthest - cell.controller.reference().q);
    }
    EXPECT_LE(watch.worst, 1e-6);
    EXPECT_LE(to_deg(back), 0.015);
    EXPECT_FALSE(cell.status().moving);
  };
  for (const double speed : {0.3, 0.7, 1.5, 3.0, 6.0}) {
    for (const int silent_ticks : {0, 25, 40, 60, 80, 100, 120}) {
      for (const Then then : {Then::kDeadline, Then::kManyStops, Then::kMoveOn}) {
        SCOPED_TRACE(::testing::Message() << speed << " deg/s, silent for " << silent_ticks
                                          << " ms, then " << static_cast<int>(then));
        run(from_deg(speed), silent_ticks, then);
        if (HasFailure()) return;
      }
    }
  }
}

/// Position limits at every tick, whatever is asked and whenever; the plant is left out, so that a
/// hundred thousand requests can be made: the encoders show where the steps are.
class Echo {
 public:
  explicit Echo(const AxisSettings& settings) : controller(settings) {
    for (int i = 0; i < 100; ++i) tick(1e-3);
    EXPECT_EQ(controller.home(), AxisVerdict::kAccepted);
    for (int i = 0; i < 60'000 && !(controller.status().homed && !controller.status().moving);
         ++i) {
      tick(1e-3);
    }
    EXPECT_TRUE(controller.status().homed);
  }
  void tick(double dt) {
    AxisInputs inputs;
    inputs.steps = steps_;
    const double turns = static_cast<double>(steps_) / 3200;
    const auto motor = static_cast<std::int64_t>(std::floor(turns * 4096));
    inputs.motor_counts = static_cast<std::uint16_t>(((motor % 4096) + 4096) % 4096);
    inputs.joint_counts = static_cast<std::int32_t>(std::floor(turns / 17 * 2400));
    // The switch closes 5 deg below where it was switched on.
    inputs.end_stop = turns / 17 < -5.0 / 360;
    steps_ = controller.tick(inputs, now_).steps;
    now_ += from_seconds(dt);
  }
  AxisController controller;

 private:
  Instant now_;
  std::int64_t steps_ = 0;
};

TEST(AxisController, any_requests_at_any_time_keep_every_limit_at_every_tick) {
  AxisSettings settings = test::test_settings();
  settings.lower = from_deg(-20);
  settings.upper = from_deg(25);
  settings.homing.end_stop_angle = from_deg(-22);
  settings.homing.clear_angle = from_deg(-19);
  settings.limits.acceleration = from_deg(200);
  settings.limits.jerk = from_deg(2000);
  settings.supervision.following_error = 10;  // setpoints that jump are meant to be run after here
  settings.tracking_jerk = from_deg(20'000);
  const Echo homed(settings);
  // 100 cases of 1000 requests: a hundred thousand retargets and stops.
  for_random_cases(100, [&](Random& random) {
    Echo echo = homed;
    const double dt = random.uniform(2e-4, 4e-3);
    motion::AxisState last = echo.controller.reference();
    for (int i = 0; i < 1000; ++i) {
      if (random.chance(0.1)) {
        echo.controller.stop();
      } else {
        // Three in ten on a limit itself.
        const double q = std::clamp(random.uniform(settings.lower - 0.17, settings.upper + 0.17),
                                    settings.lower, settings.upper);
        const bool tracked = random.chance(0.2);
        const AxisVerdict verdict =
            tracked ? echo.controller.track(q, random.uniform(-9, 9)) : echo.controller.move_to(q);
        ASSERT_EQ(verdict, AxisVerdict::kAccepted);
      }
      for (std::int64_t ticks = random.integer(1, 200); ticks > 0; --ticks) {
        echo.tick(dt);
        const motion::AxisState now = echo.controller.reference();
        ASSERT_LE(std::abs(now.qd), settings.limits.velocity + 1e-6);
        ASSERT_LE(std::abs(now.qdd), settings.limits.acceleration + 1e-6);
        ASSERT_LE(std::abs(now.qdd - last.qdd) / dt, settings.tracking_jerk + 1e-3);
        ASSERT_GE(now.q, settings.lower - 1e-8);
        ASSERT_LE(now.q, settings.upper + 1e-8);
        last = now;
      }
    }
    ASSERT_EQ(echo.controller.status().fault, AxisFault::kNone);
  });
}

TEST(AxisController, moves_and_stops_alone_keep_the_joints_own_jerk) {
  AxisSettings settings = test::test_settings();
  settings.homing.end_stop_angle = from_deg(-172);
  const Echo homed(settings);
  for_random_cases(50, [&](Random& random) {
    Echo echo = homed;
    motion::AxisState last = echo.controller.reference();
    for (int i = 0; i < 100; ++i) {
      const double q = random.uniform(settings.lower, settings.upper);
      ASSERT_EQ(echo.controller.move_to(q), AxisVerdict::kAccepted);
      const std::int64_t stop_at = random.chance(0.3) ? random.integer(0, 500) : -1;
      for (std::int64_t ticks = random.integer(1, 1000); ticks > 0; --ticks) {
        if (ticks == stop_at) echo.controller.stop();
        echo.tick(1e-3);
        const motion::AxisState now = echo.controller.reference();
        ASSERT_LE(std::abs(now.qd), settings.limits.velocity + 1e-6);
        ASSERT_LE(std::abs(now.qdd), settings.limits.acceleration + 1e-6);
        ASSERT_LE(std::abs(now.qdd - last.qdd) / 1e-3, settings.limits.jerk + 1e-6);
        last = now;
      }
    }
  });
}

TEST(AxisController, slow_fast_and_jittering_cycles_all_arrive) {
  for (const double dt : {0.01, 2e-4}) {
    AxisCell cell = homed_cell();
    ASSERT_EQ(cell.controller.move_to(from_deg(-150)), AxisVerdict::kAccepted);
    cell.run(8, dt);
    EXPECT_EQ(cell.status().fault, AxisFault::kNone) << dt;
    EXPECT_NEAR(cell.status().q, from_deg(-150), from_deg(0.03)) << dt;
    EXPECT_LT(cell.error(), kTruth) << dt;
  }
  AxisCell cell = homed_cell();
  Random random(7);
  ASSERT_EQ(cell.controller.move_to(from_deg(-150)), AxisVerdict::kAccepted);
  const Instant end = cell.now + std::chrono::seconds(8);
  while (cell.now < end) cell.tick(random.uniform(2e-4, 4e-3));
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  EXPECT_NEAR(cell.status().q, from_deg(-150), from_deg(0.03));
}

// --- emergency stop ----------------------------------------------------------------------------

TEST(AxisController, emergency_stop_freezes_the_steps_in_the_same_tick_whatever_runs) {
  enum class What : std::uint8_t { kRest, kMove, kTrack, kHome, kTest, kFaultBrake };
  for (const What what :
       {What::kRest, What::kMove, What::kTrack, What::kHome, What::kTest, What::kFaultBrake}) {
    AxisCell cell = homed_cell();
    const double q = cell.controller.reference().q;
    if (what == What::kMove || what == What::kFaultBrake) (void)cell.controller.move_to(0);
    if (what == What::kHome) (void)cell.controller.home();
    if (what == What::kTest) cell.controller.self_test();
    for (int i = 0; i < (what == What::kTest ? 10 : 2000); ++i) {
      const double t = i * 1e-3;
      if (what == What::kTrack && i % 5 == 0) (void)cell.controller.track(q + t * t / 15, t / 7.5);
      cell.tick();
    }
    if (what == What::kFaultBrake) cell.controller.stop(AxisFault::kLinkSilent);
    cell.tick();
    const auto steps = cell.outputs.steps;
    cell.controller.emergency_stop();
    for (int i = 0; i < 1000; ++i) {
      cell.tick();
      ASSERT_EQ(cell.outputs.steps, steps);
      ASSERT_TRUE(cell.outputs.enabled);
    }
    EXPECT_TRUE(cell.status().emergency_stopped);
    EXPECT_FALSE(cell.status().moving);
    EXPECT_EQ(cell.controller.move_to(0), AxisVerdict::kEmergencyStopped);
    EXPECT_EQ(cell.controller.track(0, 0), AxisVerdict::kEmergencyStopped);
    EXPECT_EQ(cell.controller.home(), AxisVerdict::kEmergencyStopped);
    // Releasing resumes nothing, and the position is still the right one.
    const double rest = cell.plant.q();
    cell.controller.release_emergency_stop();
    cell.run(1);
    EXPECT_NEAR(cell.plant.q(), rest, from_deg(0.1));
    if (what != What::kHome) {
      EXPECT_TRUE(cell.status().position_ok);
      EXPECT_LT(cell.error(), kTruth);
    }
    if (what == What::kMove) {
      EXPECT_EQ(cell.controller.move_to(from_deg(-160)), AxisVerdict::kAccepted);
      EXPECT_TRUE(cell.run_to_rest());
      EXPECT_EQ(cell.status().fault, AxisFault::kNone);
    }
  }
}

TEST(AxisController, emergency_stop_can_cut_the_current) {
  AxisSettings settings = test::test_settings();
  settings.emergency_stop = EmergencyStopAction::kPowerOff;
  AxisCell cell(from_deg(-165), settings);
  ASSERT_TRUE(cell.home());
  cell.controller.emergency_stop();
  cell.tick();
  EXPECT_FALSE(cell.outputs.enabled);
  cell.run(1);
  EXPECT_FALSE(cell.outputs.enabled);
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  cell.controller.release_emergency_stop();
  cell.run(0.2);
  EXPECT_TRUE(cell.outputs.enabled);
  EXPECT_TRUE(cell.status().position_ok);
  EXPECT_LT(cell.error(), kTruth);
}

// --- self-test, power-up, bounds ---------------------------------------------------------------

TEST(AxisController, self_test_moves_by_a_full_step_and_back_and_passes) {
  AxisCell cell = homed_cell();
  const double before = cell.plant.q();
  double farthest = 0;
  cell.controller.self_test();
  EXPECT_EQ(cell.controller.move_to(0), AxisVerdict::kBusy);
  const auto steps = cell.outputs.steps;
  std::int64_t most = 0;
  for (int i = 0; i < 600; ++i) {
    cell.tick();
    farthest = std::max(farthest, std::abs(cell.plant.q() - before));
    most = std::max(most, cell.outputs.steps - steps);
  }
  EXPECT_EQ(most, 16);
  EXPECT_LT(to_deg(farthest), 0.2);
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  EXPECT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
}

TEST(AxisController, self_test_finds_a_motor_that_does_not_turn) {
  AxisCell cell = homed_cell();
  static std::uint16_t stuck = 0;
  stuck = cell.inputs.motor_counts;
  cell.spoil = [](AxisInputs& inputs) { inputs.motor_counts = stuck; };
  cell.controller.self_test();
  cell.run(0.5);
  EXPECT_EQ(cell.status().fault, AxisFault::kSelfTest);
}

TEST(AxisController, self_test_finds_a_low_supply_at_once) {
  AxisCell cell = homed_cell();
  cell.spoil = [](AxisInputs& inputs) { inputs.supply_volts = 15; };
  cell.tick();
  cell.controller.self_test();
  EXPECT_EQ(cell.status().fault, AxisFault::kSelfTest);
}

TEST(AxisController, a_stop_line_is_an_emergency_stop_while_it_lasts_and_loses_no_step) {
  AxisCell cell = homed_cell();
  ASSERT_EQ(cell.controller.move_to(from_deg(-100)), AxisVerdict::kAccepted);
  cell.run(3);
  // The pins were cut off in the middle of a tick: some steps were not made.
  static std::int64_t made = 0;
  made = cell.outputs.steps - 40;
  cell.spoil = [](AxisInputs& inputs) { inputs.stop_line = true, inputs.steps = made; };
  cell.tick();
  EXPECT_TRUE(cell.status().emergency_stopped);
  EXPECT_TRUE(cell.outputs.frozen);
  EXPECT_EQ(cell.outputs.steps, made);
  cell.run(0.5);
  EXPECT_EQ(cell.outputs.steps, made);
  cell.controller.release_emergency_stop();
  cell.tick();
  EXPECT_TRUE(cell.status().emergency_stopped);
  cell.spoil = nullptr;
  cell.controller.release_emergency_stop();
  cell.run(0.5);
  EXPECT_FALSE(cell.status().emergency_stopped);
  EXPECT_FALSE(cell.outputs.frozen);
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  EXPECT_TRUE(cell.status().position_ok);
  ASSERT_EQ(cell.controller.move_to(from_deg(-150)), AxisVerdict::kAccepted);
  EXPECT_TRUE(cell.run_to_rest());
  EXPECT_LT(cell.error(), kTruth);
}

TEST(AxisController, a_board_without_meters_tells_no_supply_and_no_temperature) {
  AxisCell cell = homed_cell();
  cell.spoil = [](AxisInputs& inputs) { inputs.has_meters = false; };
  cell.tick();
  EXPECT_FALSE(cell.status().supply_volts);
  EXPECT_FALSE(cell.status().temperature_c);
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
}

TEST(AxisController, self_test_waits_until_the_current_has_settled) {
  for (const bool supply_goes : {false, true}) {
    AxisCell cell(from_deg(-165));
    for (int i = 0; i < 1000 && !cell.outputs.enabled; ++i) cell.tick();
    ASSERT_TRUE(cell.outputs.enabled);
    cell.controller.self_test();
    EXPECT_EQ(cell.controller.move_to(0), AxisVerdict::kBusy);
    if (supply_goes) cell.plant.set_supply(5);
    cell.run(0.2);
    EXPECT_EQ(cell.status().fault, supply_goes ? AxisFault::kSupplyLow : AxisFault::kNone);
    EXPECT_FALSE(cell.status().moving);
  }
}

TEST(AxisController, homing_does_not_wait_for_a_supply_that_is_not_there) {
  AxisCell cell(from_deg(-165));
  cell.plant.set_supply(5);
  cell.run(0.2);
  EXPECT_FALSE(cell.outputs.enabled);
  EXPECT_EQ(cell.status().fault, AxisFault::kNone);
  EXPECT_EQ(cell.controller.home(), AxisVerdict::kBusy);
  cell.plant.set_supply(24);
  cell.run(0.2);
  EXPECT_TRUE(cell.outputs.enabled);
  EXPECT_EQ(cell.controller.home(), AxisVerdict::kAccepted);
}

TEST(AxisController, pause_of_the_processor_is_no_jump) {
  AxisCell cell = homed_cell();
  ASSERT_EQ(cell.controller.move_to(0), AxisVerdict::kAccepted);
  cell.run(3);
  const auto before = cell.outputs.steps;
  cell.now += from_seconds(0.5);
  cell.tick();
  const double rate_max = cell.controller.settings().step_rate_max;
  EXPECT_LE(std::abs(static_cast<double>(cell.outputs.steps - before)),
            rate_max * AxisController::kTickMax + 1);
  // Half a second without an encoder reading: nobody knows how often it turned.
  EXPECT_EQ(cell.status().fault, AxisFault::kMotorEncoder);
  EXPECT_FALSE(cell.status().position_ok);
}

TEST(AxisController, any_inputs_and_requests_are_survived_without_an_allocation) {
  for_random_cases(200, [](Random& random) {
    AxisController controller(test::test_settings());
    Instant now{};
    std::int64_t last = 0;
    const test::AllocationCounter counter;
    for (int i = 0; i < 500; ++i) {
      AxisInputs inputs;
      inputs.steps = last;
      const bool wild = random.chance(0.5);
      inputs.joint_counts = static_cast<std::int32_t>(wild ? random.bits() : random.bits() % 3);
      inputs.motor_counts = static_cast<std::uint16_t>(wild ? random.bits() : random.bits() % 9);
      inputs.motor_encoder_ok = random.chance(0.95);
      inputs.end_stop = random.chance(0.3);
      inputs.supply_volts = random.chance(0.02) ? kNan : random.uniform(15, 30);
      inputs.temperature_c = random.chance(0.02) ? kNan : 25;
      switch (random.integer(0, 20)) {
        case 0:
          (void)controller.home();
          break;
        case 1:
          (void)controller.move_to(random.uniform(-4, 4));
          break;
        case 2:
          (void)controller.track(random.uniform(-4, 4), random.uniform(-4, 4));
          break;
        case 3:
          controller.clear_faults();
          break;
        case 4:
          controller.emergency_stop();
          break;
        case 5:
          controller.release_emergency_stop();
          break;
        case 6:
          controller.self_test();
          break;
        case 7:
          controller.cancel_homing();
          break;
        default:
          break;
      }
      const double dt = random.uniform(0, 0.03);
      const AxisOutputs outputs = controller.tick(inputs, now);
      const double most = controller.settings().step_rate_max * AxisController::kTickMax + 17;
      ASSERT_LE(std::abs(static_cast<double>(outputs.steps - last)), most);
      last = outputs.steps;
      now += from_seconds(dt);
    }
    ASSERT_EQ(counter.count(), 0U);
  });
}

TEST(AxisSettings, come_from_the_model_or_are_the_documents) {
  const AxisSettings settings = axis_settings(test::test_model(), 0);
  EXPECT_NEAR(settings.steps_per_rad() * 2 * kPi, 54'400, 1e-6);
  EXPECT_NEAR(to_deg(settings.limits.velocity), 0.9 * 33.088, 1e-3);
  EXPECT_NEAR(to_deg(settings.limits.acceleration), 10, 1e-9);
  EXPECT_NEAR(to_deg(settings.supervision.stall_angle), 3.6, 1e-9);
  RobotModel bare = test::test_model();
  bare.dynamics = {};
  EXPECT_NEAR(axis_settings(bare, 0).steps_per_rad() * 2 * kPi, 54'400, 1e-6);
  bare.dynamics.drives.push_back({.holding_torque = 1, .gear_ratio = 5, .microsteps = 8});
  EXPECT_NEAR(axis_settings(bare, 0).steps_per_rad() * 2 * kPi, 8'000, 1e-6);
  const auto counts_with = [&](JointEncoder encoder) {
    bare.dynamics.drives[0].joint_encoder = encoder;
    const AxisEncoderSettings encoders = axis_settings(bare, 0).encoders;
    EXPECT_EQ(encoders.joint, encoder);
    return encoders.joint_counts_per_turn;
  };
  EXPECT_EQ(counts_with(JointEncoder::kQuadrature), 2400);
  EXPECT_EQ(counts_with(JointEncoder::kAs5600), 4096);
}

}  // namespace
}  // namespace sinew
