#pragma once

#include <array>
#include <cstdint>

#include "sinew/core/fixed_vector.h"
#include "sinew/model/device.h"

namespace sinew::sim {

/// A board as its SPI pins see it.
class SpiSlave {
 public:
  virtual ~SpiSlave() = default;
  /// The level of its chip select changes; true is low.
  virtual void select(bool selected) = 0;
  /// Eight clocks, full duplex.
  virtual std::uint8_t shift(std::uint8_t mosi) = 0;
};

/// What a board does with its chip select.
enum class SelectKind : std::uint8_t {
  kHard,  ///< the pin gates clock and MISO: who is not selected is not there
  kSoft,  ///< only an interrupt: it shifts on every clock and drives MISO push-pull, always
};

/// One or several SPI buses with a board per axis, as one thing: chip selects by axis, contention
/// on MISO, broadcast, and the faults of a wiring loom.
///
/// Where several boards drive MISO, equal bits are fine and of different ones the low one wins: two
/// push-pull stages against each other end near the stronger one, which in 3.3 V CMOS is the lower.
/// Such bytes are counted, since on a real board they are current and heat, not data. @rt
class AxisBus {
 public:
  static constexpr std::uint8_t kIdle = 0xFF;  ///< nobody drives MISO: the host's pull-up

  /// The next axis. @param slave  outlives the bus. @param bus  boards of one number share wires
  void attach(SpiSlave& slave, SelectKind kind, std::uint8_t bus);

  /// A chip select that hangs on another board, or on several: bit i of `slaves` is board i.
  void wire_select(std::size_t axis, std::uint8_t slaves);
  /// Without supply a board takes no clock and drives nothing.
  void set_powered(std::size_t axis, bool powered);

  /// Levels of the chip selects from now on. @param select  bit i: axis i, 1 is low
  void select(std::uint8_t select);
  /// Eight clocks on every bus of which an axis is selected; on all of them where none is.
  std::uint8_t shift(std::uint8_t mosi);

  std::uint64_t contended_bytes() const { return contended_; }

 private:
  struct Port {
    SpiSlave* slave = nullptr;
    SelectKind kind = SelectKind::kHard;
    std::uint8_t bus = 0;
    std::uint8_t reaches = 0;  ///< boards that this axis's chip select pulls
    bool powered = true;
    bool selected = false;
  };

  FixedVector<Port, kMaxJoints> ports_;
  std::uint8_t clocked_ = 0xFF;  ///< boards whose bus is clocked
  std::uint64_t contended_ = 0;
};

}  // namespace sinew::sim
