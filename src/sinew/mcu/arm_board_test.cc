#include "sinew/mcu/arm_board.h"

#include <gtest/gtest.h>

#include "support/board_promises.h"

// The board's program on this machine.

namespace sinew::mcu {
namespace {

class ArmBoardPromise : public testing::TestWithParam<BoardPromise> {};

TEST_P(ArmBoardPromise, is_kept_by_the_program_on_this_machine) {
  HostBoard board;
  board.run_ms(10);
  GetParam().check(board);
}

INSTANTIATE_TEST_SUITE_P(All, ArmBoardPromise, testing::ValuesIn(board_promises()),
                         [](const auto& promise) { return promise.param.name; });

/// Its stop line is sampled each ms, and the main loop may come later.
TEST(ArmBoard, a_stop_line_that_was_low_for_one_slice_latches) {
  KeptPositions kept = {};
  const ArmBoardFacts facts = big_robot_arm_facts();
  ArmBoard board(facts, kept);
  const auto send = [&](const arm_link::Request& request) {
    std::uint8_t plain[arm_link::kRequestMax];
    std::uint8_t stuffed[kStuffedMax];
    const std::uint8_t size = stuff(plain, arm_link::encode(request, plain), stuffed);
    for (std::uint8_t i = 0; i < size; ++i) board.receive(stuffed[i], 1);
    while (!board.replies().empty()) board.replies().take();
  };
  arm_link::Request hello = {};
  hello.kind = arm_link::Kind::kHello;
  hello.deadline_ms = 500;
  for (std::uint16_t& braking : hello.brakings) braking = 1000;
  send(hello);
  board.poll(1);
  ASSERT_EQ(board.fault(), arm_link::Fault::kNone);
  board.slice(true);
  board.slice(false);
  board.poll(2);
  EXPECT_EQ(board.fault(), arm_link::Fault::kStopLine);
}

}  // namespace
}  // namespace sinew::mcu
