#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sinew/core/instant.h"
#include "sinew/io/io_error.h"

namespace sinew::io {

/// Boards on SPI, mode 0, most significant bit first, each with a chip select of its own. Used by
/// one thread.
class SpiBus {
 public:
  virtual ~SpiBus() = default;

  /// Selects go low, `setup` passes, the bytes are exchanged, selects go high.
  ///
  /// @param select  bit i: board i. Boards on one bus are served in one exchange; where several are
  ///                selected that sit on different buses, each bus gets its own right after the
  ///                other, and a bit of `miso` is 1 only where all of them sent a 1.
  /// @param miso    as long as `mosi`
  /// @error  the system refused
  virtual IoResult<void> exchange(std::uint8_t select, std::span<const std::uint8_t> mosi,
                                  std::span<std::uint8_t> miso, Duration setup,
                                  std::uint32_t clock_hz) = 0;
  /// Level of a board's READY line.
  virtual IoResult<bool> ready(std::size_t board) = 0;
};

/// Where a board is wired to; numbers of the kernel (/dev/spidevBUS.DEVICE) and BCM numbers.
struct SpiBoard {
  std::uint8_t bus = 0;
  std::uint8_t device = 0;
  std::uint8_t select_gpio = 0;
  std::uint8_t ready_gpio = 0;
};

/// The kernel's spidev and its GPIO character device, by ioctl. Selects are high from the first
/// moment on, and stay as they are when this ends.
///
/// @param gpio_chip  "/dev/gpiochip0" on all Raspberry Pis up to 4
/// @error  a device is not there, no permission, used by another program: each says what to do
IoResult<std::unique_ptr<SpiBus>> open_spidev(std::span<const SpiBoard> boards,
                                              const std::string& gpio_chip = "/dev/gpiochip0");

}  // namespace sinew::io
