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

/// Where the kernel shows its devices; other folders in tests.
struct DeviceFolders {
  std::string files = "/dev";
  std::string terminals = "/sys/class/tty";
  std::string hid = "/sys/bus/hid/devices";
};

/// What this computer offers to robots. Nothing is opened for writing, no line changes its level,
/// no byte is sent: serial ports are looked at from outside, since opening one may reset a board.
/// Of the ttyS that the kernel keeps ready for UARTs that nobody fitted only those are listed that
/// have one: their driver says its type, and 0 is none.
std::vector<FoundDevice> find_devices(const DeviceFolders& folders = {});

/// Interfaces of the kernel that a robot may need and that are missing, with the remedy each. A
/// classic LeArm board on USB is named, too: it is a HID device there and no serial port.
std::vector<std::string> missing_interfaces(const DeviceFolders& folders = {});

}  // namespace sinew::io
