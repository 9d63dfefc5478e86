#include "sinew/devices/axis/axis_device_homing.h"

#include <gtest/gtest.h>

#include <vector>

namespace sinew {
namespace {

using Kind = Homing::Wish::Kind;
using Phase = Homing::Phase;

constexpr double kTick = 1e-3;

HomingSettings settings(double direction = -1) {
  HomingSettings homing;
  homing.direction = direction;
  homing.end_stop_angle = direction * from_deg(172);
  homing.clear_angle = direction * from_deg(169);
  homing.travel_max = from_deg(354);
  return homing;
}

/// A joint that goes exactly where it is wished, at the wished speed, and its switch.
struct Rail {
  explicit Rail(double start, double direction = -1)
      : homing(settings(direction), {from_deg(30), from_deg(10), from_deg(10)}),
        end_stop(0.01),
        q(start),
        way(direction) {}

  /// One tick; what was wished.
  Homing::Wish tick() {
    const double step = std::clamp(goal - q, -speed * kTick, speed * kTick);
    q += step;
    const bool closed = switch_works && (q - switch_at) * way >= 0;
    end_stop.read(closed || switch_stuck, kTick);
    const Homing::Wish wish = homing.tick(end_stop, q, q == goal, kTick);
    if (wish.kind == Kind::kMoveTo) goal = wish.q, speed = wish.speed;
    if (wish.kind == Kind::kStop) goal = q;
    if (wish.kind == Kind::kMark) mark = q;
    if (wish.kind == Kind::kNameMark) {
      const double jump = wish.q - mark;
      q += jump, switch_at += jump;
      goal = q;
    }
    if (homing.running() && (phases.empty() || phases.back() != homing.phase())) {
      phases.push_back(homing.phase());
    }
    return wish;
  }
  /// The wish that ends it.
  Homing::Wish run() {
    homing.start();
    goal = q;
    for (int i = 0; i < 400'000; ++i) {
      const Homing::Wish wish = tick();
      if (!homing.running()) return wish;
    }
    return {};
  }

  Homing homing;
  Debouncer end_stop;
  double q;
  double way;
  double goal = 0;
  double speed = 0;
  double switch_at = 0;
  double mark = 99;
  bool switch_works = true;
  bool switch_stuck = false;
  std::vector<Phase> phases;
};

TEST(Debouncer, believes_a_level_that_lasts) {
  Debouncer debouncer(0.01);
  for (int i = 0; i < 9; ++i) debouncer.read(true, kTick);
  EXPECT_FALSE(debouncer.closed());
  EXPECT_TRUE(debouncer.closing());
  debouncer.read(true, kTick);
  debouncer.read(true, kTick);
  EXPECT_TRUE(debouncer.closed());
  for (int i = 0; i < 50; ++i) debouncer.read(i % 2 == 0, kTick);
  EXPECT_TRUE(debouncer.closed());
  for (int i = 0; i < 12; ++i) debouncer.read(false, kTick);
  EXPECT_FALSE(debouncer.closed());
}

TEST(Homing, goes_through_its_phases_and_names_the_edge) {
  for (const double direction : {-1.0, 1.0}) {
    Rail rail(-direction * 0.5, direction);
    EXPECT_EQ(rail.run().kind, Kind::kDone);
    EXPECT_EQ(rail.phases, (std::vector{Phase::kApproach, Phase::kContact, Phase::kBackOff,
                                        Phase::kEdge, Phase::kZero, Phase::kClear}));
    EXPECT_NEAR(rail.switch_at, direction * from_deg(172), from_deg(0.001));
    EXPECT_NEAR(rail.q, direction * from_deg(169), 1e-9);
  }
}

TEST(Homing, closed_switch_is_left_before_the_edge_is_looked_for) {
  Rail rail(-from_deg(1));
  for (int i = 0; i < 20; ++i) rail.end_stop.read(true, kTick);
  EXPECT_EQ(rail.run().kind, Kind::kDone);
  EXPECT_EQ(rail.phases.front(), Phase::kLeaveSwitch);
  EXPECT_EQ(rail.phases[1], Phase::kEdge);
  EXPECT_NEAR(rail.switch_at, -from_deg(172), from_deg(0.001));
}

TEST(Homing, switch_that_never_closes_ends_after_the_whole_way) {
  Rail rail(0);
  rail.switch_works = false;
  EXPECT_EQ(rail.run().fault, AxisFault::kHomingTimeout);
  EXPECT_NEAR(to_deg(rail.q), -354, 1e-6);
}

TEST(Homing, switch_that_never_opens_ends_after_the_way_back) {
  Rail rail(0.1);
  rail.switch_stuck = true;
  for (int i = 0; i < 20; ++i) rail.end_stop.read(true, kTick);
  EXPECT_EQ(rail.run().fault, AxisFault::kEndStopStuck);
  EXPECT_NEAR(to_deg(rail.q - 0.1), 8, 1e-6);
}

TEST(Homing, joint_that_does_not_move_runs_out_of_time) {
  Homing homing(settings(), {from_deg(30), from_deg(10), from_deg(10)});
  const Debouncer open(0.01);
  homing.start();
  Homing::Wish wish;
  int ticks = 0;
  while (homing.running() && ticks < 1'000'000) {
    wish = homing.tick(open, 0.3, false, kTick);
    ++ticks;
  }
  EXPECT_EQ(wish.fault, AxisFault::kHomingTimeout);
  // 354 deg at 3 deg/s, half as long again and two seconds.
  EXPECT_NEAR(ticks * kTick, 1.5 * 118.5 + 2, 3);
}

TEST(Homing, cancelled_search_wishes_nothing_more) {
  Rail rail(0.5);
  rail.homing.start();
  rail.goal = rail.q;
  for (int i = 0; i < 100; ++i) rail.tick();
  rail.homing.cancel();
  for (int i = 0; i < 100; ++i) EXPECT_EQ(rail.tick().kind, Kind::kNone);
  EXPECT_FALSE(rail.homing.running());
}

}  // namespace
}  // namespace sinew
