#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sinew::io {

/// One device file that a robot may hang on, and whether this user can use it.
struct FoundDevice {
  enum class Kind : std::uint8_t { kSerial, kSpi, kGpio } kind = Kind::kSerial;
  std::string path;     ///< "/dev/ttyUSB0"
  std::string name;     ///< what it calls itself: the adapter's name, the chip's label
  std::string trouble;  ///< why it cannot be used and what helps; empty where it can
};

/// What this computer offers to robots. Nothing is opened for writing, no line changes its level,
/// no byte is sent: serial ports are looked at from outside, since opening one may reset a board.
std::vector<FoundDevice> find_devices();

/// Interfaces of the kernel that a robot may need and that are missing, with the remedy each.
std::vector<std::string> missing_interfaces();

}  // namespace sinew::io
