#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/cli/images/flash_boards.h"

namespace sinew::cli {

/// How a board's flash is written.
enum class FlashWay : std::uint8_t {
  kSerial,   ///< its ROM boot loader over a serial port: stm32flash
  kUsb,      ///< its ROM boot loader over USB (DFU): dfu-util
  kProbe,    ///< an ST-Link on its debug pins: openocd
  kArduino,  ///< the boot loader of an Arduino, on its USB port: avrdude
};

/// One run of a tool, and what it is for.
struct FlashStep {
  std::string what;  ///< for people: "reads what is on it"
  std::vector<std::string> command;
};

/// The runs that a board's flashing consists of; nothing here runs them.
class FlashTool {
 public:
  /// @param port  of kSerial
  FlashTool(const FlashBoard& board, FlashWay way, std::string port)
      : board_(board), way_(way), port_(std::move(port)) {}

  /// Its name, and the Debian package that has it.
  std::string_view program() const;

  /// Asks which chip is there.
  FlashStep ask() const;
  /// Of what that wrote.
  /// @error  a sentence: no chip answered, another chip, or several
  std::expected<void, std::string> answered(std::string_view output) const;
  /// Reads as much of the flash as an image may have.
  FlashStep read_to(const std::string& file, std::uint32_t bytes) const;
  /// Writes the image, holds what was written against it where the tool can, and starts it.
  FlashStep write(const std::string& file, std::uint32_t bytes) const;
  /// Whether write() has compared; else read_to() has to.
  bool verifies() const { return way_ != FlashWay::kUsb; }
  /// A copy ends with the last byte that is not FF.
  bool trims() const { return way_ == FlashWay::kArduino; }
  /// What to do when it is written.
  std::string_view how_to_end() const;
  /// How to bring the board into the state in which ask() is answered.
  std::string_view how_to_begin() const;

 private:
  const FlashBoard& board_;
  FlashWay way_;
  std::string port_;
};

}  // namespace sinew::cli
