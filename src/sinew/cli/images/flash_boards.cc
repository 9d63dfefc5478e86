#include "sinew/cli/images/flash_boards.h"

#include <algorithm>
#include <array>

namespace sinew::cli {
namespace {

constexpr std::uint16_t kMediumF103[] = {0x410};
constexpr std::uint16_t kF401[] = {0x423, 0x433};
constexpr std::uint16_t kMega2560[] = {0x9801};
constexpr std::string_view kAxisBoards[] = {"axis_registers", "axis_link"};
constexpr std::string_view kArmBoard[] = {"bigrobotarm", "arm_link"};
constexpr std::array kBoards = std::to_array<FlashBoard>({
    {"axis-stm32f103", "Blue Pill (STM32F103C8)", kMediumF103, kAxisBoards, "target/stm32f1x.cfg",
     "", 63488},
    {"axis-stm32f401", "Black Pill (STM32F401CC)", kF401, kAxisBoards, "target/stm32f4x.cfg",
     "/0x08000000/04*016Kg,01*064Kg", 65536},
    // Its boot loader is in the last 8 kB.
    {"bigrobotarm-atmega2560", "BigRobotArm's board (ATmega2560)", kMega2560, kArmBoard, "", "",
     253952, "m2560"},
    {"encoder-stm8s103",
     "encoder node (STM8S103F3)",
     {},
     {},
     "",
     "",
     8192,
     "",
     "stm8flash -c stlinkv2 -p stm8s103f3 -w"},
});

}  // namespace

std::span<const FlashBoard> flash_boards() {
  return kBoards;
}

const FlashBoard* flash_board(std::string_view image) {
  const auto* const found = std::ranges::find(kBoards, image, &FlashBoard::image);
  return found == kBoards.end() ? nullptr : found;
}

}  // namespace sinew::cli
