#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace sinew::stm32 {

/// The board's end of the SPI bus, mode 0, by DMA: whole transfers, from chip select to chip
/// select. NSS is the chip's own, so that MISO is driven only while it is low.
///
/// At each rising edge the interrupt puts aside what came and gets ready for the next transfer at
/// once, with the answer that there was; a new one is laid in between two transfers. So a host that
/// is quicker than the program finds the last answer again, and never half of two.
class SpiSlave {
 public:
  static constexpr std::size_t kTransferMax = 24;  ///< bytes; what is beyond them is not kept

  void start();

  /// A transfer that came, oldest first; empty for none. Stands until taken().
  std::span<const std::uint8_t> received() const;
  void taken();
  /// What goes out next time, from its first byte on.
  void offer(std::span<const std::uint8_t, kTransferMax> answer);

  /// From the interrupt of the select line.
  void on_deselect();

 private:
  struct Transfer {
    std::array<std::uint8_t, kTransferMax> bytes;
    std::uint8_t size;
  };
  static constexpr std::uint32_t kQueue = 4;

  void arm();

  std::array<Transfer, kQueue> queue_{};
  std::uint32_t head_ = 0;  ///< of the transfers that came
  std::uint32_t tail_ = 0;  ///< of those that were taken
  std::array<std::uint8_t, kTransferMax> in_{};
  std::array<std::uint8_t, kTransferMax> out_{};
};

}  // namespace sinew::stm32
