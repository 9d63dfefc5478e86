#include "sinew/devices/arm_link/arm_link_driver.h"

#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/devices/arm_link/arm_link_test_cell.h"
#include "support/property.h"

namespace sinew {
namespace {

using namespace std::chrono_literals;
using test::ArmLinkCell;
using Kind = DriverEvent::Kind;
constexpr std::array<double, 5> kThere{0.3, -0.1, 0.2, 0.4, -0.3};

TEST(ArmLinkDriver, opens_and_wants_a_declaration) {
  ArmLinkCell cell;
  cell.driver.open(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kReady));
  EXPECT_TRUE(cell.driver.wants_declaration());
  EXPECT_EQ(cell.count(Kind::kReady), 1);
  JointMove move;
  move.q.resize(5);
  move.qd.resize(5);
  move.duration = 20ms;
  EXPECT_EQ(cell.driver.move(move, cell.now).error().code, ErrorCode::kPositionUnknown);
}

TEST(ArmLinkDriver, streams_a_motion_and_every_segment_ends) {
  ArmLinkCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.move_to(kThere, 2))
      << int(cell.driver.state()) << (cell.refused ? describe(*cell.refused) : "");
  EXPECT_EQ(cell.count(Kind::kDone), 100);
  EXPECT_EQ(cell.count(Kind::kFailed), 0);
  for (std::size_t i = 0; i < 5; ++i) {
    const double step = 1 / std::abs(cell.device().arm.joints[i].steps_per_rad);
    EXPECT_NEAR(cell.actual(i), kThere[i], 0.51 * step) << i;
    EXPECT_NEAR(cell.driver.positions()[i].q, kThere[i], 0.51 * step) << i;
  }
  ASSERT_TRUE(cell.move_to({}, 2));
  for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(cell.actual(i), 0, 1e-3) << i;
}

TEST(ArmLinkDriver, shows_where_the_arm_is_all_along) {
  ArmLinkCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.move_to(kThere, 2, [&] {
    for (std::size_t i = 0; i < 5; ++i) {
      const JointPosition& joint = cell.driver.positions()[i];
      EXPECT_GE(cell.actual(i), joint.lower) << i;
      EXPECT_LE(cell.actual(i), joint.upper) << i;
    }
    return testing::Test::HasFailure();
  }));
}

TEST(ArmLinkDriver, stops_on_its_way_and_goes_on_from_there) {
  for (const int after : {1, 30, 200, 700, 1500}) {
    ArmLinkCell cell;
    cell.make_ready();
    const Instant stop = cell.now + std::chrono::milliseconds(after);
    bool stopped = false;
    cell.move_to(kThere, 2, [&] {
      if (cell.now < stop || stopped) return false;
      stopped = true;
      cell.driver.stop(cell.now);
      return true;
    });
    ASSERT_TRUE(cell.run_until(DriverState::kReady, 3s)) << after;
    cell.run(5ms);
    EXPECT_GE(cell.count(Kind::kStopped), 1) << after;
    EXPECT_EQ(cell.count(Kind::kFailed), 0) << after;
    for (std::size_t i = 0; i < 5; ++i) {
      const JointPosition& joint = cell.driver.positions()[i];
      EXPECT_GE(cell.actual(i), joint.lower) << after << ", " << i;
      EXPECT_LE(cell.actual(i), joint.upper) << after << ", " << i;
    }
    ASSERT_TRUE(cell.move_to(kThere, 2)) << after;
    EXPECT_NEAR(cell.actual(0), kThere[0], 1e-3);
  }
}

TEST(ArmLinkDriver, lost_and_damaged_bytes_cost_time_and_nothing_else) {
  test::for_random_cases(30, [](test::Random& random) {
    ArmLinkCell cell;
    cell.make_ready();
    const double share = random.uniform(0, 0.002);
    cell.line = [&](std::uint8_t byte) -> std::optional<std::uint8_t> {
      if (random.chance(share)) return std::nullopt;
      if (random.chance(share))
        return static_cast<std::uint8_t>(byte ^ (1U << random.integer(0, 7)));
      return byte;
    };
    const bool there = cell.move_to(kThere, 2);
    cell.line = [](std::uint8_t byte) { return std::optional(byte); };
    ASSERT_TRUE(cell.run_until(DriverState::kReady, 20s));
    for (std::size_t i = 0; i < 5; ++i) {
      const JointPosition& joint = cell.driver.positions()[i];
      if (there) {
        EXPECT_NEAR(cell.actual(i), kThere[i], 3e-3) << i;
      }
      EXPECT_GE(cell.actual(i), joint.lower - 1e-9) << i;
      EXPECT_LE(cell.actual(i), joint.upper + 1e-9) << i;
    }
  });
}

TEST(ArmLinkDriver, a_cable_that_is_cut_stops_the_arm_and_is_found_again) {
  ArmLinkCell cell;
  cell.make_ready();
  int rounds = 0;
  cell.move_to(kThere, 2, [&] {
    cell.cut = ++rounds > 20'000;
    return cell.cut;
  });
  cell.run(2s);
  EXPECT_GE(cell.count(Kind::kFailed), 1);
  EXPECT_FALSE(cell.board.moving());
  cell.cut = false;
  ASSERT_TRUE(cell.run_until(DriverState::kReady));
  cell.run(10ms);
  for (std::size_t i = 0; i < 5; ++i) {
    const JointPosition& joint = cell.driver.positions()[i];
    EXPECT_GE(cell.actual(i), joint.lower) << i;
    EXPECT_LE(cell.actual(i), joint.upper) << i;
  }
  ASSERT_TRUE(cell.move_to({}, 2));
  EXPECT_NEAR(cell.actual(0), 0, 1e-3);
}

TEST(ArmLinkDriver, nudges_also_without_a_position) {
  ArmLinkCell cell;
  cell.driver.open(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kReady));
  ASSERT_TRUE(cell.driver.nudge(0, 0.02, 500ms, cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady));
  cell.run(1ms);
  EXPECT_EQ(cell.count(Kind::kDone), 1);
  EXPECT_NEAR(cell.actual(0), 0.02, 3e-4);
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
}

TEST(ArmLinkDriver, gripper_and_zero) {
  ArmLinkCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.driver.tool(GripperTo{.enabled = true, .angle = from_deg(40)}, cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady));
  EXPECT_EQ(cell.board.gripper().position, 40);
  ASSERT_TRUE(cell.move_to(kThere, 2));
  ASSERT_TRUE(cell.driver.zero_counters(cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady));
  cell.run(100ms);
  EXPECT_EQ(cell.board.counted_steps(cell.now)[0], 0);
  EXPECT_NEAR(cell.driver.positions()[0].q, kThere[0], 1e-3);
  ASSERT_TRUE(cell.move_to({}, 2));
  EXPECT_NEAR(cell.actual(0), 0, 1e-3);
}

TEST(ArmLinkDriver, a_board_that_restarts_in_a_motion_loses_the_position) {
  ArmLinkCell cell;
  cell.make_ready();
  int rounds = 0;
  cell.move_to(kThere, 2, [&] { return ++rounds > 20'000; });
  cell.board.restart(cell.now, 1s, false);
  cell.run(400ms);
  EXPECT_GE(cell.count(Kind::kFailed), 1);
  ASSERT_TRUE(cell.run_until(DriverState::kReady));
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
}

TEST(ArmLinkDriver, a_stop_line_that_goes_low_is_a_fault_until_it_is_released) {
  ArmLinkCell cell;
  cell.make_ready();
  int rounds = 0;
  cell.move_to(kThere, 2, [&] { return ++rounds > 20'000; });
  cell.board.set_stop_line(true);
  ASSERT_TRUE(cell.run_until(DriverState::kFault, 1s));
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kEmergencyStop);
  EXPECT_EQ(cell.driver.move({}, cell.now).error().code, ErrorCode::kEmergencyStop);
  cell.events.clear();
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.run(200ms);
  EXPECT_EQ(cell.count(Kind::kFailed), 1) << "it is still low";
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  cell.board.set_stop_line(false);
  cell.run(100ms);
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 1s));
  for (std::size_t i = 0; i < 5; ++i) {
    const JointPosition& joint = cell.driver.positions()[i];
    EXPECT_GE(cell.actual(i), joint.lower) << i;
    EXPECT_LE(cell.actual(i), joint.upper) << i;
  }
  ASSERT_TRUE(cell.move_to({}, 2));
  EXPECT_NEAR(cell.actual(0), 0, 1e-3);
}

TEST(ArmLinkDriver, a_stop_line_that_is_low_at_rest_is_told_too) {
  ArmLinkCell cell;
  cell.make_ready();
  cell.board.set_stop_line(true);
  ASSERT_TRUE(cell.run_until(DriverState::kFault, 1s));
  EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kEmergencyStop);
  ArmLinkDriver next(cell.device(), cell.robot.joints);
  std::swap(cell.driver, next);
  cell.driver.open(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kFault, 2s)) << "the next host finds it so";
}

TEST(ArmLinkDriver, refuses_what_would_make_a_motor_lose_steps) {
  ArmLinkCell cell;
  cell.make_ready();
  JointMove move;
  move.duration = 20ms;
  for (std::size_t i = 0; i < 5; ++i) {
    move.q.push_back(i == 0 ? 0.02 : 0);
    move.qd.push_back(0);
  }
  const auto jump = cell.driver.move(move, cell.now);
  ASSERT_FALSE(jump);
  EXPECT_EQ(jump.error().code, ErrorCode::kAccelerationLimit);
  EXPECT_EQ(jump.error().index, 0);
  move.q[0] = 0;
  move.duration = 500us;
  EXPECT_EQ(cell.driver.move(move, cell.now).error().code, ErrorCode::kSegmentTime);
  move.duration = 20ms;
  move.q.resize(4);
  EXPECT_EQ(cell.driver.move(move, cell.now).error().code, ErrorCode::kUnsendable);
  move.q.push_back(std::nan(""));
  EXPECT_FALSE(cell.driver.move(move, cell.now));
  EXPECT_EQ(cell.driver.state(), DriverState::kReady);
  ASSERT_TRUE(cell.move_to(kThere, 2));
}

TEST(ArmLinkDriver, segments_of_any_length_make_the_same_motion) {
  test::for_random_cases(40, [](test::Random& random) {
    ArmLinkCell cell;
    cell.make_ready();
    // A ramp up to a speed and down again, in pieces as they come.
    constexpr double kSpeed = 0.2, kRise = 0.5, kAll = 2;  // rad/s, s, s
    const auto at = [](double t, double& q, double& qd) {
      const double s = std::clamp(t / kRise, 0.0, 1.0),
                   e = std::clamp((kAll - t) / kRise, 0.0, 1.0);
      const auto way = [](double x) { return x * x * x - x * x * x * x / 2; };
      const double up = kSpeed * kRise * way(s), down = kSpeed * kRise * way(e);
      const double level = std::clamp(t - kRise, 0.0, kAll - 2 * kRise) * kSpeed;
      q = t <= kAll - kRise ? up + level : kSpeed * (kAll - kRise) - down;
      const double x = std::min(s, e);
      qd = kSpeed * (3 * x * x - 2 * x * x * x);
    };
    for (double t = 0; t < kAll;) {
      if (!cell.driver.wants_move(cell.now)) {
        cell.run(1ms);
        ASSERT_TRUE(cell.driver.state() == DriverState::kMoving || t == 0);
        continue;
      }
      const double piece = random.uniform(0.002, random.chance(0.3) ? 0.09 : 0.03);
      const double next = kAll - t < piece + 0.005 ? kAll : t + piece;
      JointMove move;
      move.duration = from_seconds(next - t);
      double q = 0, qd = 0;
      at(next, q, qd);
      for (std::size_t i = 0; i < 5; ++i) {
        move.q.push_back(i == 3 ? -q : i == 0 ? q : 0);
        move.qd.push_back(i == 3 ? -qd : i == 0 ? qd : 0);
      }
      const auto taken = cell.driver.move(move, cell.now);
      ASSERT_TRUE(taken) << describe(taken.error());
      t = next;
    }
    ASSERT_TRUE(cell.run_until(DriverState::kReady, 5s));
    EXPECT_EQ(cell.count(Kind::kFailed), 0);
    EXPECT_NEAR(cell.actual(0), kSpeed * (kAll - kRise), 2e-4);
    EXPECT_NEAR(cell.actual(3), -kSpeed * (kAll - kRise), 4e-4);
  });
}

TEST(ArmLinkDriver, two_hosts_never_move_it_both) {
  ArmLinkCell cell;
  cell.make_ready();
  ArmLinkDriver other(cell.device(), cell.robot.joints);
  int rounds = 0;
  cell.move_to(kThere, 2, [&] { return ++rounds > 20'000; });
  // Another program opens the same port: its hello ends the session, and the arm brakes.
  std::swap(cell.driver, other);
  cell.driver.open(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kReady, 5s));
  EXPECT_FALSE(cell.board.moving());
  std::swap(cell.driver, other);
  cell.events.clear();
  cell.run(1s);
  EXPECT_GE(cell.count(Kind::kFailed), 1) << "the first one finds out, and opens it again";
}

TEST(ArmLinkDriver, keeps_what_the_board_says_of_itself) {
  ArmLinkCell cell;
  cell.make_ready();
  cell.run(3s);
  const DeviceFacts all = cell.driver.facts();
  const auto& facts = all.get<ArmLinkFacts>();
  ASSERT_TRUE(facts.statistics);
  EXPECT_EQ(facts.statistics->what.starts, 1);
  EXPECT_LE(cell.now - facts.statistics->at, 1200ms);
  EXPECT_LE(cell.now - facts.state->at, 100ms);
  EXPECT_FALSE(facts.image) << "a simulated board runs none";
}

void expect_true_claims(const ArmLinkCell& cell, const std::string& what) {
  for (std::size_t i = 0; i < 5; ++i) {
    const JointPosition& joint = cell.driver.positions()[i];
    if (joint.quality == PositionQuality::kLost) continue;
    ASSERT_GE(cell.actual(i), joint.lower - 1e-9) << what << ", joint " << i;
    ASSERT_LE(cell.actual(i), joint.upper + 1e-9) << what << ", joint " << i;
  }
}

TEST(ArmLinkDriver, a_late_reply_is_never_taken_for_another) {
  ArmLinkCell cell;
  cell.make_ready();
  cell.run(30ms);
  cell.late = 45ms;
  for (const int degrees : {40, 50, 60}) {
    ASSERT_TRUE(cell.driver.tool(GripperTo{.enabled = true, .angle = from_deg(degrees)}, cell.now));
    ASSERT_TRUE(cell.run_until(DriverState::kReady));
    EXPECT_EQ(cell.board.gripper().position, degrees);
  }
  cell.late = 0ms;
  ASSERT_TRUE(cell.move_to({0.02, 0, 0, 0, 0}, 2));
  cell.late = 45ms;
  ASSERT_TRUE(cell.driver.zero_counters(cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady));
  EXPECT_EQ(cell.board.counted_steps(cell.now)[0], 0);
  cell.late = 0ms;
  cell.run(1s);
  ASSERT_TRUE(cell.move_to({0.07, 0, 0, 0, 0}, 2));
  EXPECT_NEAR(cell.actual(0), 0.07, 3e-4);
}

TEST(ArmLinkDriver, claims_hold_the_truth_however_late_replies_are) {
  for (const Duration hiccup : {30ms, 50ms, 70ms, 100ms, 200ms}) {
    ArmLinkCell cell;
    cell.make_ready();
    cell.move_to({1.2, 0, 0, 1.2, 0}, 1.8, [&] {
      const Duration at = cell.now.time_since_epoch() % 500ms;
      cell.late = at < 100ms ? hiccup : 0ms;
      cell.driver.poll(cell.now);
      expect_true_claims(cell, "late");
      return testing::Test::HasFailure();
    });
    cell.late = 0ms;
    cell.run(3s);
    expect_true_claims(cell, "at rest");
  }
}

TEST(ArmLinkDriver, a_motion_that_is_lost_sight_of_stays_inside_what_is_claimed) {
  for (const bool closes : {false, true}) {
    for (const int after : {300, 700, 900, 1200, 1600}) {
      ArmLinkCell cell;
      cell.make_ready();
      const Instant cut = cell.now + std::chrono::milliseconds(after);
      cell.move_to({1.2, 0.2, -0.3, 1.2, 0.5}, 1.8, [&] { return cell.now >= cut; });
      cell.cut = true;
      if (closes) cell.driver.close(cell.now);
      // Once the driver has lost it, its claim is for good.
      for (int k = 0; k < 4000 && cell.driver.state() == DriverState::kMoving; ++k) cell.run(1ms);
      for (int k = 0; k < 300; ++k) {
        expect_true_claims(cell, closes ? "closed" : "cut");
        if (testing::Test::HasFailure()) return;
        cell.run(10ms);
        cell.driver.poll(cell.now);
      }
      EXPECT_FALSE(cell.board.moving());
      EXPECT_FALSE(cell.driver.goes_on_until());
    }
  }
}

TEST(ArmLinkDriver, takes_any_duration) {
  ArmLinkCell cell;
  cell.make_ready();
  JointMove move;
  move.q.resize(5);
  move.qd.resize(5);
  for (const auto duration : {1'000'000'001ns, 999'999'999ns, 20'000'001ns, 1'000'000ns}) {
    move.duration = duration;
    ASSERT_TRUE(cell.driver.move(move, cell.now)) << duration.count();
    ASSERT_TRUE(cell.run_until(DriverState::kReady)) << duration.count();
  }
  EXPECT_EQ(cell.count(Kind::kDone), 4);
}

TEST(ArmLinkDriver, a_nudge_is_as_gentle_as_a_motion) {
  for (const double degrees : {0.3, 0.6, 1.0, 2.0}) {
    ArmLinkCell cell;
    cell.make_ready();
    ASSERT_TRUE(cell.driver.nudge(0, from_deg(degrees), 0ms, cell.now));
    double before = cell.actual(0), speed = 0, hardest = 0;
    while (cell.driver.state() == DriverState::kMoving) {
      cell.run(20ms);
      const double now = (cell.actual(0) - before) / 0.02;
      hardest = std::max(hardest, std::abs(now - speed) / 0.02);
      before = cell.actual(0);
      speed = now;
    }
    EXPECT_NEAR(before, from_deg(degrees), 3e-4);
    const double step = 1 / std::abs(cell.device().arm.joints[0].steps_per_rad);
    EXPECT_LE(hardest, 1.1 * cell.robot.joints[0].acceleration_max + 2 * step / 4e-4) << degrees;
  }
}

TEST(ArmLinkDriver, opens_however_late_the_replies_are) {
  for (const Duration late : {30ms, 40ms, 60ms, 100ms, 150ms}) {
    ArmLinkCell cell;
    cell.late = late;
    cell.driver.open(cell.now);
    ASSERT_TRUE(cell.run_until(DriverState::kReady, 8s)) << late / 1ms;
  }
  ArmLinkCell cell;
  cell.late = 1s;
  cell.driver.open(cell.now);
  cell.run(9s);
  EXPECT_EQ(cell.count(Kind::kFailed), 1) << "and says so where they are too late";
}

TEST(ArmLinkDriver, a_stop_is_told_whatever_it_meets) {
  ArmLinkCell cell;
  cell.make_ready();
  cell.board.set_stop_line(true);
  ASSERT_TRUE(cell.run_until(DriverState::kFault, 1s));
  cell.events.clear();
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.driver.stop(cell.now);
  cell.run(500ms);
  EXPECT_EQ(cell.count(Kind::kFailed), 1);
  EXPECT_EQ(cell.count(Kind::kStopped), 1);
  cell.cut = true;
  cell.run(12s);
  cell.events.clear();
  cell.driver.stop(cell.now);
  cell.run(100ms);
  EXPECT_EQ(cell.count(Kind::kStopped), 1) << "of a board that is silent";
}

TEST(ArmLinkDriver, another_hosts_count_is_not_believed) {
  ArmLinkCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.move_to({0.5, 0, 0, 0, 0}, 2));
  ArmLinkDriver other(cell.device(), cell.robot.joints);
  std::swap(cell.driver, other);
  cell.driver.open(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kReady));
  cell.declare({0.5, 0, 0, 0, 0});
  ASSERT_TRUE(cell.driver.zero_counters(cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady));
  ASSERT_TRUE(cell.move_to({0.8, 0, 0, 0, 0}, 2));
  std::swap(cell.driver, other);
  cell.run(2s);
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kLost);
}

TEST(ArmLinkDriver, a_stop_line_that_was_low_for_a_moment_waits_for_a_person) {
  for (const Duration low : {1ms, 2ms, 5ms}) {
    ArmLinkCell cell;
    cell.make_ready();
    int rounds = 0;
    cell.move_to(kThere, 2, [&] { return ++rounds > 20'000; });
    cell.board.set_stop_line(true);
    cell.run(low);
    cell.board.set_stop_line(false);
    ASSERT_TRUE(cell.run_until(DriverState::kFault, 1s)) << low / 1ms;
    cell.run(1s);
    EXPECT_EQ(cell.driver.fault()->code, ErrorCode::kEmergencyStop);
    ASSERT_TRUE(cell.driver.clear_fault(cell.now));
    ASSERT_TRUE(cell.run_until(DriverState::kReady, 1s));
    ASSERT_TRUE(cell.move_to({}, 2));
  }
}

TEST(ArmLinkDriver, a_board_without_power_behind_a_host_that_died_is_found_out) {
  ArmLinkCell cell;
  cell.make_ready();
  cell.run(2s);
  const std::vector<JointPosition> recorded(cell.driver.positions().begin(),
                                            cell.driver.positions().end());
  cell.board.restart(cell.now, 0s, true);
  // The second host dies before it has recorded anything; the third has the record of the first.
  for (int host = 0; host < 2; ++host) {
    ArmLinkDriver next(cell.device(), cell.robot.joints);
    std::swap(cell.driver, next);
    cell.driver.declare_positions(recorded);
    cell.driver.open(cell.now);
    ASSERT_TRUE(cell.run_until(DriverState::kReady));
    cell.run(50ms);
  }
  EXPECT_EQ(cell.driver.positions()[0].quality, PositionQuality::kUncertain);
}

TEST(ArmLinkDriver, the_gripper_is_switched_off_wherever_it_is) {
  ArmLinkCell cell;
  ArmLinkDevice device = cell.device();
  device.arm.gripper_max = 60;
  ArmLinkDriver narrow(device, cell.robot.joints);
  std::swap(cell.driver, narrow);
  cell.make_ready();
  ASSERT_TRUE(cell.driver.tool(GripperTo{.enabled = false, .angle = {}}, cell.now));
  ASSERT_TRUE(cell.run_until(DriverState::kReady));
  EXPECT_FALSE(cell.board.gripper().enabled);
}

TEST(ArmLinkDriver, the_next_host_believes_the_count) {
  ArmLinkCell cell;
  cell.make_ready();
  ASSERT_TRUE(cell.move_to(kThere, 2));
  const std::vector<JointPosition> recorded(cell.driver.positions().begin(),
                                            cell.driver.positions().end());
  ArmLinkDriver next(cell.device(), cell.robot.joints);
  std::swap(cell.driver, next);
  cell.driver.declare_positions(recorded);
  cell.driver.open(cell.now);
  ASSERT_TRUE(cell.run_until(DriverState::kReady));
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(cell.driver.positions()[i].quality, PositionQuality::kCommanded) << i;
    EXPECT_NEAR(cell.driver.positions()[i].q, kThere[i], 2e-3) << i;
  }
  ASSERT_TRUE(cell.move_to({}, 2));
  EXPECT_NEAR(cell.actual(0), 0, 1e-3);
}

}  // namespace
}  // namespace sinew
