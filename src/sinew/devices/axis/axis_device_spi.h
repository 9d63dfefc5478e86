#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sinew/core/instant.h"
#include "sinew/devices/axis/axis_device.h"
#include "sinew/devices/axis_link/axis_link_device.h"
#include "sinew/devices/axis_registers/axis_registers_device.h"

namespace sinew {

/// The wire's end of a board that speaks both protocols on one SPI bus, a whole transfer (from chip
/// select to chip select) at a time, as boards have them whose bytes go by DMA. The first good
/// frame decides, until power is lost: a frame of the axis link for this axis, or a header that the
/// register protocol takes. Until then both listen; neither moves anything before its first good
/// frame. @rt
class AxisSpiSlave {
 public:
  enum class Wire : std::uint8_t { kUndecided, kLink, kRegisters };

  /// @param axis  outlives this
  /// @param setup  likewise, where the axis link may read and write it
  AxisSpiSlave(Axis& axis, const AxisLinkNodeSettings& link,
               const AxisRegisterSlaveSettings& registers, SetupStore* setup = nullptr);

  /// A transfer that came, and was answered with what next_answer() said before.
  void transfer(std::span<const std::uint8_t> mosi);
  /// What the next one is answered with, from its first byte on.
  void next_answer(std::span<std::uint8_t> miso) const;
  /// Time passes: the deadline of the axis link is watched.
  void advance(Instant now);

  Wire wire() const { return wire_; }
  bool restart_due() const { return node_.restart_due(); }

 private:
  AxisLinkNode node_;
  AxisRegisterSlave slave_;
  Wire wire_ = Wire::kUndecided;
};

}  // namespace sinew
