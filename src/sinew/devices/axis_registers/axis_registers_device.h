#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "sinew/core/fixed_vector.h"
#include "sinew/devices/axis/axis_device.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/axis_registers/axis_registers_wire.h"
#include "sinew/model/device.h"

namespace sinew {

/// Which board answers.
enum class AxisRegisterProfile : std::uint8_t {
  kDocument,  ///< what the document promises, with an axis behind it
  kAsBuilt,   ///< what the first firmware does: it stores registers and moves nothing
};

/// What a board of the register protocol must know of itself.
struct AxisRegisterSlaveSettings {
  AxisRegisterMap registers;
  AngleEncoding encoding = AngleEncoding::kDegU32;
  std::uint8_t slave_id = 1;
  double zero = 0;  ///< rad: the angle that degrees count from
};

/// Board `joint` of such an arm.
AxisRegisterSlaveSettings axis_register_slave_settings(const AxisRegistersDevice& device,
                                                       std::size_t joint);

/// One axis board behind the register protocol, byte for byte.
///
///   state           | takes or sends             | next
///   ----------------+----------------------------+--------------------------------------
///   kWaitSyn        | 97                         | kSendSynAck; any other byte: stays
///   kSendSynAck     | sends 98                   | kWaitAck
///   kWaitAck        | 99                         | kWaitHeader; any other byte: stays
///   kWaitHeader     | 14 bytes                   | kSendValidation
///   kSendValidation | sends the verdict          | kWaitData, kSendData, or kWaitSyn if refused
///   kWaitData       | N + 4 bytes, then it acts  | kSendCommit
///   kSendCommit     | sends 4 bytes              | kWaitSyn
///   kSendData       | sends N + 4 bytes          | kWaitCommit
///   kWaitCommit     | any 4 bytes                | kWaitSyn
///
/// There is no time-out in any of them. A falling select arms the state's transfer from its first
/// byte; a transfer that breaks off is begun again by the next one, and bytes beyond its end are
/// ignored. While it receives, MISO repeats the last byte that was sent.
///
/// As built: READ of a 4-byte register gives its lowest byte four times, a short WRITE sets the
/// high bytes, headers are checked in another order, DIAG_STATUS is 0, HOMING reads 0, READY is
/// low for ever, and the axis is never touched. @rt
class AxisRegisterSlave {
 public:
  enum class State : std::uint8_t {
    kWaitSyn,
    kSendSynAck,
    kWaitAck,
    kWaitHeader,
    kSendValidation,
    kWaitData,
    kSendCommit,
    kSendData,
    kWaitCommit,
  };

  /// Just powered up.
  /// @param axis  what it moves; outlives the board.
  AxisRegisterSlave(const AxisRegisterSlaveSettings& settings, AxisRegisterProfile profile,
                    Axis& axis);

  /// The level of the chip select changes; true is low.
  void select(bool selected);
  /// Eight clocks. A board that is not selected must not get them, unless it listens always, as
  /// boards with a software chip select do.
  std::uint8_t shift(std::uint8_t mosi);
  /// A whole frame. @param miso  at least as long as `mosi`.
  void exchange(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso);

  /// It is its turn to speak.
  bool sends() const;
  /// What the next frame will be answered with, from its first byte on; for boards whose transfers
  /// run without the processor.
  void next_answer(std::span<std::uint8_t> miso) const;

  /// Level of READY; low (false) is ready.
  bool ready_pin() const { return ready_pin_; }
  State state() const { return state_; }
  /// As the protocol's document spells it, as "WAIT_SYN".
  static std::string_view name_of(State state);
  /// What a register holds, as its bytes stand on the wire.
  axis_registers::Data register_value(axis_registers::Register name) const;
  /// Whole registers that were written, which is when the firmware looks at them.
  std::uint32_t changes() const { return changes_; }
  /// What a host did wrong, since power-up.
  struct Violations {
    std::uint64_t broken_transfers = 0;  ///< begun, and begun again before their end
    std::uint64_t surplus_bytes = 0;     ///< beyond the end of a transfer
    std::uint64_t stray_bytes = 0;       ///< no SYN where one was due, or no ACK
    std::uint64_t refused_headers = 0;
    std::uint64_t bad_data = 0;  ///< CRC
    std::uint64_t sum() const {
      return broken_transfers + surplus_bytes + stray_bytes + refused_headers + bad_data;
    }
  };
  const Violations& violations() const { return violations_; }
  /// Its registers, in the order of their table.
  std::span<const axis_registers::RegisterRow> registers() const {
    return {rows_.data(), rows_.size()};
  }
  /// It left for its boot loader (later boards only) and answers nothing until powered up again.
  bool in_boot_loader() const { return in_boot_loader_; }

  /// The board's supply came back; the axis is somebody else's.
  void power_up();

 private:
  static constexpr std::size_t kRegisters = axis_registers::kLaterRegisters.size();
  static constexpr std::size_t kFrameMax = axis_registers::kDataMax + axis_registers::kCrcSize;

  std::size_t length() const;
  void enter(State state);
  void complete();
  void take_header();
  void take_data();
  void send(std::span<const std::uint8_t> bytes);
  const axis_registers::RegisterRow* row_of(std::uint16_t address) const;
  axis_registers::Data read(const axis_registers::RegisterRow& row, std::size_t size) const;
  axis_registers::Data live_value(axis_registers::Register name) const;
  axis_registers::Data stored(const axis_registers::RegisterRow& row) const;
  void store(const axis_registers::RegisterRow& row, std::span<const std::uint8_t> data);
  void act(axis_registers::Register name);
  void move();

  AxisRegisterProfile profile_;
  AngleEncoding encoding_;
  double zero_;  ///< rad
  std::uint8_t slave_id_;
  Axis& axis_;
  FixedVector<axis_registers::RegisterRow, kRegisters> rows_;

  State state_ = State::kWaitSyn;
  Violations violations_;
  bool selected_ = false;
  bool armed_ = false;
  std::size_t place_ = 0;
  std::array<std::uint8_t, kFrameMax> received_{};
  FixedVector<std::uint8_t, kFrameMax> to_send_;
  std::uint8_t miso_ = 0;  ///< sent last
  axis_registers::Header header_;
  axis_registers::Verdict verdict_ = axis_registers::Verdict::kOk;
  std::uint16_t last_frame_id_ = 0xFFFF;
  std::array<std::uint32_t, kRegisters> values_{};  ///< by Register
  std::uint32_t changes_ = 0;
  bool ready_pin_ = true;
  bool in_boot_loader_ = false;
};

}  // namespace sinew
