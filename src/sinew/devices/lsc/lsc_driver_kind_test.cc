#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/lsc/lsc_test_cell.h"

// What a LeArm's driver finds out about its board, and what it admits of one that it cannot stop.

namespace sinew {
namespace {

using namespace std::chrono_literals;
using test::kLscHere;
using test::kLscSag;
using test::LscCell;
using test::LscLine;
using test::LscPose;
using test::refusal;
using Kind = DriverEvent::Kind;

constexpr std::uint8_t kMove = 3;
constexpr std::uint8_t kReadPositions = 21;

std::size_t asked(const LscCell& cell, std::uint8_t command) {
  lsc::FrameDecoder decoder;
  std::size_t count = 0;
  for (const std::uint8_t byte : cell.to_board.history) {
    const auto frame = decoder.push(byte);
    count += frame && frame->command == command ? 1 : 0;
  }
  return count;
}

TEST(LscKind, a_bus_board_that_is_taken_for_a_classic_one_is_refused_before_it_moves) {
  LscCell cell(LscProfile::kLsc6, LscProfile::kBus);
  cell.driver.open(cell.now);
  cell.run_for(2s);
  EXPECT_EQ(cell.driver.state(), DriverState::kFault);
  EXPECT_EQ(cell.failure(), ErrorCode::kOtherBoard);
  EXPECT_EQ(cell.count(Kind::kReady), 0U);
  const auto refused = cell.driver.move(cell.to({}, 2500ms), cell.now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kOtherBoard);
  EXPECT_EQ(asked(cell, kMove), 0U);
}

TEST(LscKind, one_lost_question_or_answer_does_not_make_a_bus_board_a_classic_one) {
  // The StopGroup has 4 bytes, the battery question 4, this one 6; the battery's answer has 6.
  for (std::uint64_t byte = 8; byte < 14; ++byte) {
    constexpr std::uint64_t kLength = 10;  // without it the board waits for three questions more
    for (const auto fault : {LscLine::Fault::kDrop, LscLine::Fault::kDouble}) {
      const bool swallows = byte == kLength && fault == LscLine::Fault::kDrop;
      LscCell question(LscProfile::kLsc6, LscProfile::kBus);
      if (!swallows) question.to_board.hit(byte, fault);
      question.driver.open(question.now);
      question.run_for(2s);
      EXPECT_EQ(question.failure(), ErrorCode::kOtherBoard) << byte;
      LscCell answer(LscProfile::kLsc6, LscProfile::kBus);
      answer.to_host.hit(byte - 2, fault);
      answer.driver.open(answer.now);
      answer.run_for(2s);
      EXPECT_EQ(answer.failure(), ErrorCode::kOtherBoard) << byte;
    }
  }
}

TEST(LscKind, an_exchanged_board_is_asked_again_where_its_fault_is_cleared) {
  LscCell cell(LscProfile::kLsc6, LscProfile::kBus);
  cell.driver.open(cell.now);
  cell.run_for(2s);
  ASSERT_TRUE(cell.driver.fault());
  cell.events.clear();
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.run_for(2s);
  EXPECT_EQ(cell.failure(), ErrorCode::kOtherBoard);
  // From now on it is a board that is silent where a classic one is.
  cell.to_host.cut = true;
  ASSERT_TRUE(cell.driver.clear_fault(cell.now));
  cell.run_for(1s);
  EXPECT_NE(cell.driver.state(), DriverState::kReady) << "silence alone is no board";
}

TEST(LscKind, a_classic_board_is_asked_once_an_opening_and_not_after_a_doubt) {
  LscCell cell(LscProfile::kLsc6);
  cell.driver.open(cell.now);
  cell.run_for(1s);
  ASSERT_EQ(cell.driver.state(), DriverState::kReady);
  EXPECT_EQ(asked(cell, kReadPositions), 3U);
  EXPECT_EQ(cell.driver.health().timeouts, 0U) << "its silence is the right answer";
  cell.to_host.cut = true;
  cell.run_for(5s);
  cell.to_host.cut = false;
  cell.run_for(3s);
  ASSERT_EQ(cell.count(Kind::kReady), 2U);
  EXPECT_EQ(asked(cell, kReadPositions), 3U);
  cell.driver.open(cell.now);
  cell.run_for(1s);
  EXPECT_EQ(asked(cell, kReadPositions), 6U);
}

TEST(LscKind, a_classic_board_that_is_taken_for_a_bus_board_tells_its_supply_and_never_gets_ready) {
  LscCell cell(LscProfile::kBus, LscProfile::kLsc6);
  cell.driver.open(cell.now);
  cell.run_for(5s);
  EXPECT_EQ(cell.count(Kind::kReady), 0U);
  EXPECT_EQ(cell.failure(), ErrorCode::kDeviceSilent);
  EXPECT_TRUE(cell.driver.health().supply_volts);
}

TEST(LscGoesOn,
     a_stopped_first_move_says_how_long_the_arm_goes_on_and_that_is_no_less_than_it_does) {
  LscCell cell(LscProfile::kLsc6);
  cell.driver.open(cell.now);
  cell.run_for(1s);
  ASSERT_TRUE(cell.driver.move(cell.to({1.5, 0.3, 0.2, 0.1, 0}, 2s), cell.now));
  cell.run_for(700ms);
  EXPECT_FALSE(cell.driver.goes_on_until()) << "a move that is under way is no secret";
  cell.driver.stop(cell.now);
  cell.run_for(200ms);
  ASSERT_EQ(cell.count(Kind::kStopped), 1U);
  const auto until = cell.driver.goes_on_until();
  ASSERT_TRUE(until);
  EXPECT_NEAR(to_seconds(*until - cell.now), 65.4, 0.3);
  EXPECT_TRUE(cell.machine.truth().moving);
  cell.run_for(*until - cell.now);
  EXPECT_FALSE(cell.machine.board().moving());
}

TEST(LscGoesOn, a_first_move_that_is_left_alone_says_so_and_the_next_move_ends_it) {
  LscCell cell(LscProfile::kLsc6);
  cell.driver.open(cell.now);
  cell.run_for(1s);
  const Instant asked_at = cell.now;
  ASSERT_TRUE(cell.driver.move(cell.to({1.5, 0.3, 0.2, 0.1, 0}, 20s), cell.now));
  cell.run_for(3s);
  cell.driver.close(cell.now);
  ASSERT_TRUE(cell.driver.goes_on_until());
  EXPECT_NEAR(to_seconds(*cell.driver.goes_on_until() - asked_at), 20, 0.1);
  cell.driver.open(cell.now);
  cell.run_for(1s);
  ASSERT_TRUE(cell.driver.move(cell.to({}, 2s), cell.now));
  EXPECT_FALSE(cell.driver.goes_on_until());
}

TEST(LscGoesOn, a_stop_that_stands_has_nothing_to_say) {
  LscCell cell(LscProfile::kLsc6);
  cell.start();
  ASSERT_TRUE(cell.driver.move(cell.to({0.01, 0, 0, 0, 0}, 80ms, 1), cell.now));
  cell.run_for(20ms);
  cell.driver.stop(cell.now);
  cell.run_for(1s);
  EXPECT_FALSE(cell.driver.goes_on_until());
}

TEST(LscStart, a_bus_arm_that_stands_elsewhere_than_was_planned_refuses_with_numbers) {
  LscCell cell(LscProfile::kBus);
  cell.start({0.2, 0.3, 0.2, 0.1, 0});
  const std::size_t moves = asked(cell, kMove);
  JointMove move = cell.to({0.21, 0.3, 0.2, 0.1, 0}, 80ms);
  for (const double q : {0.2, 0.5, 0.2, 0.1, 0.0}) move.q_start.push_back(q);
  const auto refused = cell.driver.move(move, cell.now);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kMovedUnasked);
  EXPECT_EQ(refused.error().index, 1);
  EXPECT_NEAR(refused.error().measured, 0.3, 0.03);
  EXPECT_EQ(refused.error().limit, 0.5);
  cell.run_for(100ms);
  EXPECT_EQ(asked(cell, kMove), moves);
  move.q_start[1] = 0.3;
  EXPECT_TRUE(cell.driver.move(move, cell.now));
}

/// Pulled down, or pushed by a hand: it comes back as any arm moves, in the pieces of a jog.
TEST(LscDriver, from_beyond_its_limits_an_arm_comes_in_at_speed_and_goes_no_farther_out) {
  LscCell cell(LscProfile::kBus);
  cell.machine.disturb({sim::Disturbance::Kind::kPayload, -1, 0.5});
  cell.run_for(3s);
  cell.driver.open(cell.now);
  cell.run_for(1s);
  const double beyond = cell.driver.positions()[1].q;
  ASSERT_GT(std::abs(beyond), kPi / 2 + 0.05);
  cell.machine.disturb({sim::Disturbance::Kind::kPayload, -1, 0});
  LscPose farther;
  for (std::size_t i = 0; i < 5; ++i) farther[i] = cell.driver.positions()[i].q;
  farther[1] += std::copysign(0.1, beyond);
  EXPECT_EQ(refusal(cell.driver.move(cell.to(farther, 80ms), cell.now)), ErrorCode::kJointLimit);
  double farthest = 0;
  cell.stream(kLscHere, 4s, [&](int) {
    farthest = std::max(farthest, std::abs(cell.machine.truth().joints[1].q));
    return true;
  });
  EXPECT_EQ(cell.failure(), std::nullopt);
  EXPECT_LT(cell.worst(kLscHere), kLscSag);
  EXPECT_LT(farthest, std::abs(beyond) + 0.1);
}

}  // namespace
}  // namespace sinew
