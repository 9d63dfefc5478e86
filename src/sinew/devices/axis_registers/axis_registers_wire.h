#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>

#include "sinew/core/angle_encoding.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"

/// The register protocol of robot-arm-2's axis boards: SPI mode 0, seven transfers a transaction,
/// each framed by its chip select. Integers are big endian; everything here is @rt.
///
///   transfer     | host                | board on a WRITE   | board on a READ
///   -------------+---------------------+--------------------+------------------------
///   1 SYN        | 97                  |                    |
///   2 SYN_ACK    | FF                  | 98                 | 98
///   3 ACK        | 99                  |                    |
///   4 header     | 14 bytes            |                    |
///   5 validation | FF                  | 00, or why not     | 00, or why not
///   6 data       | N bytes + CRC, or 0 | (repeats)          | N bytes + CRC
///   7 commit     | 00 x 4, or COMMIT   | COMMIT             | (ignored)
///
/// Source: the board's protocol document; docs/wires/axis_registers.md says where boards differ.
namespace sinew::axis_registers {

inline constexpr std::uint8_t kStart = 0x55;
inline constexpr std::uint8_t kEnd = 0xAA;
inline constexpr std::uint8_t kSyn = 0x97;
inline constexpr std::uint8_t kSynAck = 0x98;
inline constexpr std::uint8_t kAck = 0x99;
inline constexpr std::uint8_t kCommit = 0x9A;
inline constexpr std::uint8_t kDummy = 0xFF;  ///< sent where one byte is read
inline constexpr std::uint8_t kFill = 0x00;   ///< sent where several are
/// What a resynchronising host sends: no board waits for it, and it is no CRC of itself.
inline constexpr std::uint8_t kResyncByte = kAck;

inline constexpr std::size_t kHeaderSize = 14;
inline constexpr std::size_t kCommitSize = 4;
inline constexpr std::size_t kCrcSize = 4;
inline constexpr std::size_t kDataMax = 16;
inline constexpr std::size_t kResyncSize = 32;  ///< more than any transfer has
/// Transfers that bring a board from any state to where it waits for SYN: SEND_SYN_ACK, WAIT_ACK,
/// WAIT_HEADER, SEND_VALIDATION is the longest way.
inline constexpr int kResyncBursts = 4;

inline constexpr std::uint16_t kFrameIdFirst = 1;
inline constexpr std::uint16_t kFrameIdLast = 0xFFFE;
/// 1..FFFE, then 1 again.
constexpr std::uint16_t next_frame_id(std::uint16_t id) {
  return id < kFrameIdFirst || id >= kFrameIdLast ? kFrameIdFirst
                                                  : static_cast<std::uint16_t>(id + 1);
}

// Pauses of the document; a host may be slower. The boards re-arm their DMA in software.
inline constexpr Duration kSelectSetup = std::chrono::microseconds(200);  ///< select to first clock
inline constexpr Duration kStepPause = std::chrono::milliseconds(10);     ///< after a transfer
inline constexpr Duration kValidationPause = std::chrono::milliseconds(20);  ///< after transfer 5
inline constexpr Duration kErrorPause = std::chrono::milliseconds(50);
/// On top of the step's pause before SYN is sent once more: the author's host.
inline constexpr Duration kSynRetryPause = std::chrono::milliseconds(100);
/// Between bursts; as long as the longest pause that a step is given. Simulated, not measured.
inline constexpr Duration kResyncPause = std::chrono::milliseconds(20);

/// Byte 5 of the exchange, and the third of COMMIT; numbers of the document.
enum class Verdict : std::uint8_t {
  kOk = 0,
  kStartByte = 1,
  kFrameId = 2,  ///< the one that was accepted last
  kSlaveId = 3,
  kRegister = 4,
  kSize = 5,
  kEndByte = 6,
  kCrc = 7,
  kOperation = 8,
};
/// The verdict with that number. Nothing: the board never says so.
std::optional<Verdict> verdict_of(std::uint8_t byte);

enum class Operation : std::uint8_t { kRead = 1, kWrite = 2 };

enum class Register : std::uint8_t {
  kHoming,          ///< 1 starts, 0 cancels; 1 while it runs
  kMoveAngle,       ///< target, as AngleEncoding
  kDiagControl,     ///< 1 clears faults, 2 runs the self-test
  kDiagStatus,      ///< Status
  kEmergencyStop,   ///< 1 stops and latches, 0 unlatches and resumes nothing
  kEnableMotor,     ///< later boards; the host never writes it
  kFirmwareUpdate,  ///< later boards: 1 leaves for the boot loader; the host never writes it
};

struct RegisterRow {
  Register name{};
  std::uint16_t address = 0;
  std::uint8_t size = 0;
  bool readable = false;
  bool writable = false;
};

/// The document's registers.
inline constexpr std::array kDocumentRegisters = std::to_array<RegisterRow>({
    {Register::kHoming, 0, 1, true, true},
    {Register::kMoveAngle, 1, 4, true, true},
    {Register::kDiagControl, 2, 1, false, true},
    {Register::kDiagStatus, 3, 4, true, false},
    {Register::kEmergencyStop, 4, 1, true, true},
});
/// The author's later boards, two registers shifted by one and two more.
inline constexpr std::array kLaterRegisters = std::to_array<RegisterRow>({
    {Register::kHoming, 0, 1, true, true},
    {Register::kMoveAngle, 1, 4, true, true},
    {Register::kEnableMotor, 2, 1, true, true},
    {Register::kDiagControl, 3, 1, false, true},
    {Register::kDiagStatus, 4, 4, true, false},
    {Register::kEmergencyStop, 5, 1, true, true},
    {Register::kFirmwareUpdate, 6, 1, false, true},
});

inline constexpr std::uint8_t kOff = 0;  ///< of HOMING and EMERGENCY_STOP
inline constexpr std::uint8_t kOn = 1;
inline constexpr std::uint8_t kClearFaults = 1;  ///< of DIAG_CONTROL
inline constexpr std::uint8_t kRunSelfTest = 2;

/// Polynomial 04C11DB7, initial value FFFFFFFF, nothing reflected, no final xor, over little-endian
/// 32-bit words, zero padded to a whole one. So it does not protect the length: 00 and 00 00 00 00
/// have the same.
std::uint32_t crc32(std::span<const std::uint8_t> bytes);

using Data = FixedVector<std::uint8_t, kDataMax>;
using SealedData = FixedVector<std::uint8_t, kDataMax + kCrcSize>;

/// Data with its CRC behind it.
SealedData seal(std::span<const std::uint8_t> data);
/// The data, where its CRC is right. Nothing: damaged, or shorter than a CRC, or longer than fits.
std::optional<Data> unseal(std::span<const std::uint8_t> sealed);

using HeaderBytes = std::array<std::uint8_t, kHeaderSize>;
using CommitBytes = std::array<std::uint8_t, kCommitSize>;

/// What a header says. `operation` is a plain byte because a board answers wrong ones.
struct Header {
  std::uint8_t slave_id = 1;
  std::uint16_t frame_id = 0;
  std::uint8_t operation = 0;
  std::uint16_t address = 0;
  std::uint16_t size = 0;
  friend bool operator==(const Header&, const Header&) = default;
};

/// 55, slave id, frame id (2), operation, address (2), size (2), CRC of the eight (4), AA.
HeaderBytes encode_header(const Header& header);
/// The fields as they stand, right or not.
Header read_header(const HeaderBytes& bytes);

/// In which order a board looks at a header, and how strictly at the size.
enum class Checks : std::uint8_t {
  kDocument,  ///< 01 to 08 in their order; the size must be the register's
  kAsBuilt,   ///< 01 06 03 02 04 05 08 07; sizes from 1 to the register's pass
};

/// What a board holds a header against.
struct HeaderRules {
  Checks checks = Checks::kDocument;
  std::uint8_t slave_id = 1;
  std::uint16_t last_frame_id = 0xFFFF;  ///< of the last header that passed; FFFF after power-on
  std::span<const RegisterRow> registers = kDocumentRegisters;
};

/// The first check that fails.
Verdict check_header(const HeaderBytes& bytes, const HeaderRules& rules);
/// The header, where it passes what holds for every board: 55, AA, CRC.
std::expected<Header, Verdict> decode_header(const HeaderBytes& bytes);

/// 55 9A verdict AA; the verdict is kOk or kCrc.
CommitBytes encode_commit(Verdict verdict);
/// Nothing: these four bytes are no COMMIT.
std::optional<Verdict> decode_commit(std::span<const std::uint8_t> bytes);

/// DIAG_STATUS. Bits 0..7 in the order of the members, bits 8..15 the fault's number. The document
/// names bits 0..3 only; the rest is what our boards say.
struct Status {
  bool motor_ok = false;
  bool sensor_ok = false;
  bool communication_ok = false;
  bool position_ok = false;
  bool homed = false;
  bool moving = false;  ///< homing counts
  bool end_stop = false;
  bool emergency_stop = false;  ///< latched
  std::uint8_t fault = 0;
  friend bool operator==(const Status&, const Status&) = default;
};

Data encode_status(const Status& status);
/// Nothing: not four bytes, or a bit above 15 is set, so that it is some other status.
std::optional<Status> decode_status(std::span<const std::uint8_t> data);

/// The four bytes of MOVE_ANGLE.
using AngleBytes = std::array<std::uint8_t, 4>;

/// The angle that the encoding can say nearest to `angle_deg`. Nothing: not finite, or outside what
/// four bytes of this encoding hold; an angle never wraps round.
std::optional<AngleBytes> encode_angle(AngleEncoding encoding, double angle_deg);
/// Degrees. Nothing: a float that is not finite.
std::optional<double> decode_angle(AngleEncoding encoding, const AngleBytes& bytes);
/// Distance in degrees from `angle_deg` to the next angle that the encoding can say.
double angle_unit_deg(AngleEncoding encoding, double angle_deg);

}  // namespace sinew::axis_registers
