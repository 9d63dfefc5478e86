#include "sinew/devices/ideal/ideal_device.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sinew/devices/ideal/ideal_test_cell.h"
#include "support/property.h"

namespace sinew::ideal {
namespace {

using namespace std::chrono_literals;
using test::ideal_robot;

struct Bench {
  RobotModel robot = ideal_robot();
  IdealDevice device{robot.joints, std::get<SerialGeometry>(robot.geometry).gripper, Instant{}};
  Instant now{};

  Bench() { ask(Clear{}); }

  Reply ask(const Request& request, Duration later = 1ms) {
    now += later;
    return device.answer(request, now);
  }
  State state(const Reply& reply) const {
    const auto* state = std::get_if<State>(&reply);
    EXPECT_NE(state, nullptr);
    return state != nullptr ? *state : State{};
  }
  static Move to(std::uint16_t number, std::int32_t q, std::int32_t qd, std::uint32_t us = 20000) {
    Move move;
    move.number = number;
    move.duration_us = us;
    move.q = {q, 0, 0};
    move.qd = {qd, 0, 0};
    return move;
  }
};

std::optional<Why> why(const Reply& reply) {
  const auto* refusal = std::get_if<Refusal>(&reply);
  return refusal != nullptr ? std::optional(refusal->why) : std::nullopt;
}

TEST(IdealDevice, goes_along_the_cubic_and_ends_where_it_was_sent) {
  Bench bench;
  bench.ask(Bench::to(1, 500'000, 0, 1'000'000));
  for (int i = 1; i < 50; ++i) {
    bench.ask(Ask{}, 20ms);
    const double u = i * 0.02;
    EXPECT_NEAR(bench.device.q()[0], 0.5 * u * u * (3 - 2 * u), 1e-9);
    EXPECT_NEAR(bench.device.qd()[0], 3 * u * (1 - u), 1e-9);
  }
  const State end = bench.state(bench.ask(Ask{}, 30ms));
  EXPECT_EQ(end.phase, Phase::kRest);
  EXPECT_EQ(end.done, 1);
  EXPECT_EQ(end.q, (Numbers{500'000, 0, 0}));
  EXPECT_EQ(end.qd, (Numbers{0, 0, 0}));
}

TEST(IdealDevice, the_same_line_twice_is_one_move) {
  Bench bench;
  bench.ask(Bench::to(1, 20'000, 0));
  bench.ask(Bench::to(1, 40'000, 0));
  EXPECT_EQ(bench.state(bench.ask(Ask{}, 50ms)).q[0], 20'000);
  EXPECT_EQ(why(bench.ask(Bench::to(3, 40'000, 0))), Why::kNumber);
  EXPECT_EQ(bench.state(bench.ask(Bench::to(2, 40'000, 0))).taken, 2);
}

TEST(IdealDevice, refuses_what_the_robots_file_does_not_allow_and_stays) {
  Bench bench;
  EXPECT_EQ(why(bench.ask(Bench::to(1, 2'001'000, 0, 9'000'000))), Why::kLimit);
  EXPECT_EQ(why(bench.ask(Bench::to(1, 100'000, 0, 20'000))), Why::kLimit) << "5 rad/s";
  EXPECT_EQ(why(bench.ask(Bench::to(1, 10'000, 2'200'000, 20'000))), Why::kLimit);
  EXPECT_EQ(why(bench.ask(Bench::to(1, 0, 0, 0))), Why::kForm);
  Move short_one = Bench::to(1, 0, 0);
  short_one.q = short_one.qd = {0};
  EXPECT_EQ(why(bench.ask(short_one)), Why::kForm);
  EXPECT_EQ(why(bench.ask(Jaws{40'002})), Why::kTool);
  EXPECT_EQ(why(bench.ask(Jaws{-1})), Why::kTool);
  const State state = bench.state(bench.ask(Ask{}, 1s));
  EXPECT_EQ(state.taken, 0);
  EXPECT_EQ(state.q, (Numbers{0, 0, 0}));
}

TEST(IdealDevice, a_stop_brakes_on_the_path_as_hard_as_the_joint_allows) {
  Bench bench;
  Move both = Bench::to(1, 1'000'000, 0, 1'000'000);
  both.q = {1'000'000, -500'000, 250'000};
  bench.ask(both);
  for (int i = 0; i < 10; ++i) bench.ask(Ask{}, 50ms);
  const double speed = bench.device.qd()[0];
  EXPECT_NEAR(speed, 1.5, 1e-3);
  bench.ask(Stop{}, 0ms);
  const Instant began = bench.now;
  while (bench.device.moving()) {
    bench.ask(Ask{}, 1ms);
    // On the straight line of joint space.
    EXPECT_NEAR(bench.device.q()[1], -0.5 * bench.device.q()[0], 1e-9);
    EXPECT_NEAR(bench.device.q()[2], 0.25 * bench.device.q()[0], 1e-9);
  }
  EXPECT_NEAR(to_seconds(bench.now - began), speed / 8, 2e-3);
  const State state = bench.state(bench.ask(Ask{}));
  EXPECT_EQ(state.phase, Phase::kRest);
  EXPECT_EQ(state.done, 0);
  EXPECT_EQ(bench.state(bench.ask(Bench::to(2, 0, 0, 2'000'000))).phase, Phase::kMoving);
}

TEST(IdealDevice, moves_that_end_in_motion_without_a_next_one_are_braked_and_held) {
  Bench bench;
  bench.ask(Bench::to(1, 10'000, 1'000'000));
  State state = bench.state(bench.ask(Ask{}, 19ms));
  EXPECT_EQ(state.phase, Phase::kMoving);
  for (int i = 0; i < 20; ++i) state = bench.state(bench.ask(Ask{}, 10ms));
  EXPECT_EQ(state.phase, Phase::kHeld);
  EXPECT_EQ(state.held, Held::kStarved);
  // v^2 / 2a beyond its end.
  EXPECT_NEAR(bench.device.q()[0], 0.01 + 1.0 / 16, 1e-3);
  EXPECT_EQ(why(bench.ask(Bench::to(2, 0, 0, 1'000'000))), Why::kBusy);
  EXPECT_EQ(bench.state(bench.ask(Clear{})).phase, Phase::kRest);
}

TEST(IdealDevice, a_silent_host_stops_it_within_its_deadline_and_braking) {
  Bench bench;
  bench.ask(Bench::to(1, 2'000'000, 0, 4'000'000));
  const State state = bench.state(bench.ask(Ask{}, 1s));
  EXPECT_EQ(state.phase, Phase::kHeld);
  EXPECT_EQ(state.held, Held::kSilent);
  EXPECT_LT(state.q[0], 30'000);
}

TEST(IdealDevice, something_in_the_way_is_met_and_said) {
  Bench bench;
  bench.device.block(0, 0.3);
  bench.ask(Bench::to(1, 1'000'000, 0, 1'000'000));
  State state;
  for (int i = 0; i < 20; ++i) state = bench.state(bench.ask(Ask{}, 50ms));
  EXPECT_EQ(state.phase, Phase::kHeld);
  EXPECT_EQ(state.held, Held::kBlocked);
  EXPECT_EQ(state.joint, 0);
  EXPECT_EQ(state.q[0], 300'000);
  bench.device.unblock(0);
  bench.ask(Clear{});
  bench.ask(Bench::to(2, 1'000'000, 0, 1'000'000));
  for (int i = 0; i < 21; ++i) state = bench.state(bench.ask(Ask{}, 50ms));
  EXPECT_EQ(state.q[0], 1'000'000);
}

TEST(IdealDevice, jaws_take_their_time) {
  Bench bench;
  bench.ask(Jaws{20'000});
  EXPECT_NEAR(bench.state(bench.ask(Ask{}, 200ms)).jaws_um, 30'000, 100);
  EXPECT_EQ(bench.state(bench.ask(Ask{}, 300ms)).jaws_um, 20'000);
}

TEST(IdealDevice, holds_after_its_power_was_away_until_it_is_cleared) {
  Bench bench;
  bench.ask(Bench::to(1, 10'000, 0));
  bench.ask(Ask{}, 50ms);
  bench.device.lose_power();
  const State state = bench.state(bench.ask(Ask{}));
  EXPECT_EQ(state.phase, Phase::kHeld);
  EXPECT_EQ(state.held, Held::kStarted);
  EXPECT_EQ(state.taken, 0);
  EXPECT_EQ(state.q[0], 10'000);
  EXPECT_EQ(why(bench.ask(Bench::to(1, 0, 0))), Why::kBusy);
}

TEST(IdealDevice, jaws_close_no_further_than_on_what_is_between_them) {
  Bench bench;
  bench.device.block_jaws(0.025);
  bench.ask(Jaws{20'000});
  EXPECT_EQ(bench.state(bench.ask(Ask{}, 2s)).jaws_um, 25'000);
  bench.ask(Jaws{40'000});
  EXPECT_EQ(bench.state(bench.ask(Ask{}, 2s)).jaws_um, 40'000);
  bench.device.unblock_jaws();
  bench.ask(Jaws{20'000});
  EXPECT_EQ(bench.state(bench.ask(Ask{}, 2s)).jaws_um, 20'000);
}

TEST(IdealDevice, a_stop_stops_the_jaws) {
  Bench bench;
  bench.ask(Jaws{0});
  const std::int32_t there = bench.state(bench.ask(Stop{}, 100ms)).jaws_um;
  EXPECT_NEAR(there, 35'000, 100);
  EXPECT_EQ(bench.state(bench.ask(Ask{}, 1s)).jaws_um, there);
}

TEST(IdealDevice, a_cubic_that_swings_out_between_its_ends_is_refused) {
  Bench bench;
  // From 1.9 to 1.9 with 2 rad/s at both ends it would come to 2.4; the limit is 2.
  bench.ask(Bench::to(1, 1'900'000, 0, 3'000'000));
  for (int i = 0; i < 60; ++i) bench.ask(Ask{}, 50ms);
  bench.ask(Bench::to(2, 1'950'000, 1'900'000, 50'000));
  EXPECT_EQ(why(bench.ask(Bench::to(3, 1'950'000, -1'900'000, 500'000))), Why::kLimit);
}

/// However it is asked, in whatever pieces time comes: no joint beyond its range, none faster than
/// its speed.
TEST(IdealDevice, whatever_is_asked_no_joint_leaves_its_limits) {
  std::uint64_t taken = 0;
  test::for_random_cases(300, [&](test::Random& random) {
    Bench bench;
    std::uint16_t number = 0;
    for (int i = 0; i < 60; ++i) {
      const auto later = from_seconds(random.uniform(0, 0.02));
      Move move;
      move.number = static_cast<std::uint16_t>(number + 1);
      move.duration_us = static_cast<std::uint32_t>(random.integer(1000, 200'000));
      for (std::size_t j = 0; j < 3; ++j) {
        const double here = bench.device.q()[j];
        const double reach = move.duration_us * 1e-6 * 2.2;
        move.q.push_back(static_cast<std::int32_t>(1e6 * (here + random.uniform(-reach, reach))));
        const bool rest = random.chance(0.5);
        move.qd.push_back(rest ? 0
                               : static_cast<std::int32_t>(random.integer(-2'200'000, 2'200'000)));
      }
      if (std::holds_alternative<State>(bench.ask(move, later))) ++number, ++taken;
      if (random.chance(0.1)) bench.ask(Stop{}, 0ms);
      if (random.chance(0.2)) bench.ask(Clear{}, 0ms);
      for (std::size_t j = 0; j < 3; ++j) {
        EXPECT_GE(bench.device.q()[j], bench.robot.joints[j].lower - 3e-4);
        EXPECT_LE(bench.device.q()[j], bench.robot.joints[j].upper + 3e-4);
        EXPECT_LE(std::abs(bench.device.qd()[j]), 2 * 1.02 + 2e-3);
      }
    }
    bench.ask(Ask{}, 5s);
    EXPECT_FALSE(bench.device.moving());
  });
  EXPECT_GT(taken, 1000U) << "it moves at all";
}

}  // namespace
}  // namespace sinew::ideal
