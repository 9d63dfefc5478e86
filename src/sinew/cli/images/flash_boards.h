#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace sinew::cli {

/// A board that there are images for.
struct FlashBoard {
  std::string_view image;  ///< "axis-stm32f103"
  std::string_view what;   ///< for people
  /// What its chip says of itself: device ID (ST AN2606), last bytes of the signature (AVR).
  std::span<const std::uint16_t> chips;
  std::span<const std::string_view> protocols;  ///< of robots that have it
  std::string_view probe_target;                ///< openocd's file
  std::string_view usb_flash;  ///< how its DFU describes its sectors; empty: it has no DFU
  std::uint32_t size = 0;      ///< of its flash in front of the setup's place, bytes
  std::string_view part = {};  ///< avrdude's name of an AVR; empty: an STM32
  /// In front of the file: a command for people, since Debian has no tool that writes it.
  std::string_view by_hand = {};
};

std::span<const FlashBoard> flash_boards();
/// nullptr: there is no such board.
const FlashBoard* flash_board(std::string_view image);

}  // namespace sinew::cli
