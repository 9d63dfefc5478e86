#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/devices/axis/axis_device_settings.h"
#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/devices/axis_registers/axis_registers_device.h"

namespace sinew {

/// All that one board must know: which axis it is, what that axis is built of, and the register
/// wire. A host makes it from the robot's file and writes it into the board, which keeps it.
struct AxisSetup {
  std::uint8_t axis_number = 0;  ///< 0..7
  AxisSettings axis;
  AxisRegisterSlaveSettings registers;
};

/// A setup as bytes, the same on every machine: version, the fields one after the other (numbers
/// little endian, IEEE 754 doubles), filled up to whole words, and the CRC-32C of all that.
using axis_link::kSetupSize;
using axis_link::kSetupWords;
using axis_link::SetupBytes;

SetupBytes encode_setup(const AxisSetup& setup);
/// Nothing where the checksum is wrong, the version another one, or a number none that an axis can
/// work with. @rt
std::optional<AxisSetup> decode_setup(std::span<const std::uint8_t, kSetupSize> bytes);

/// Two places that keep their bytes without power, as flash does: a place is erased whole (to FF),
/// then written from its beginning. Power may go at every byte.
class SetupMemory {
 public:
  virtual ~SetupMemory() = default;
  virtual std::span<const std::uint8_t> place(int which) const = 0;
  /// @return  false where the memory does not take it
  virtual bool erase(int which) = 0;
  virtual bool append(int which, std::span<const std::uint8_t> bytes) = 0;
};

/// The setup of a board, kept in two copies: the older one is replaced, so that there is a whole
/// one at every moment. A copy is the setup's bytes, a count of copies, and the CRC-32C of both.
class SetupStore {
 public:
  explicit SetupStore(SetupMemory& memory);

  /// What is kept: the board started with it, or will start again; nothing where there is none.
  const std::optional<AxisSetup>& setup() const { return setup_; }

  /// A word of the copy that counts; FF where there is none.
  std::optional<std::uint32_t> word(std::size_t index) const;
  /// The words of a new one, one after the other; those that are not written are as they were.
  bool set_word(std::size_t index, std::uint32_t value);
  /// Keeps what was written, for the next start. @return  false where that is no setup, or the
  /// memory does not take it; the old one stays then
  bool store();
  /// Both at once.
  bool keep(const AxisSetup& setup) {
    written_ = encode_setup(setup);
    return store();
  }

 private:
  static constexpr std::size_t kCopySize = kSetupSize + 8;

  std::optional<std::uint32_t> count_of(int which) const;

  SetupMemory& memory_;
  std::optional<AxisSetup> setup_;
  SetupBytes written_;
  int newest_ = 1;
  std::uint32_t count_ = 0;
};

}  // namespace sinew
