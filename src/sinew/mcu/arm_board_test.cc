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

}  // namespace
}  // namespace sinew::mcu
