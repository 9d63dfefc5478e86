#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/driver/driver.h"

namespace sinew {

/// What a record of the position journal says.
enum class JournalKind : std::uint8_t {
  kOpened = 1,    ///< a run begins; what it took over from the one before
  kDeclared = 2,  ///< somebody said where the machine stands
  kHomed = 3,     ///< its zeros were found
  kMeasured = 4,  ///< its sensors were read
  kIntent = 5,    ///< from now on, until the next record, it may be anywhere in there
  kRest = 6,      ///< it stands; nothing that was sent is still to be carried out
  kLost = 7,      ///< it is no longer known where some joints are; cause says why
  kClosed = 8,    ///< a run ended in order
  kLook = 9,      ///< the device is asked what it forgets by telling; the answer is in the next one
};

/// Why a kLost record was written; of the others kNone or kHeld.
enum class JournalCause : std::uint8_t {
  kNone = 0,
  kDevice = 1,    ///< the device told of lost steps, or restarted
  kSilence = 2,   ///< nobody knows what it carried out
  kUser = 3,      ///< somebody said so
  kRecovery = 4,  ///< the journal of the run before did not say
  kImported = 5,  ///< only what another program once wrote down is known
  kHeld = 6,      ///< an emergency stop that this host set is latched in the device
};

/// Times of a record: the run's own line, and the wall clock's nanoseconds since 1970.
struct JournalTime {
  Instant run{};
  std::int64_t wall_ns = 0;
};

using JournalPositions = FixedVector<JointPosition, kMaxJoints>;

/// Which machine a journal is about.
struct JournalOwner {
  std::uint32_t robot = 0;  ///< journal_hash() of its id
  std::uint32_t model = 0;  ///< of what its positions depend on: zeros, gears, geometry
  friend bool operator==(const JournalOwner&, const JournalOwner&) = default;
};

struct JournalRecord {
  JournalKind kind = JournalKind::kOpened;
  JournalCause cause = JournalCause::kNone;
  std::uint64_t sequence = 1;    ///< counts on through all generations; from 1
  std::uint32_t generation = 1;  ///< from 1; a file holds one of them
  JournalOwner owner;
  JournalTime time;
  JournalPositions positions;  ///< one a joint; q in [lower, upper], all finite; zeros where lost
  std::uint8_t counted = 0;    ///< joints, a bit each: DriverMemory::counted
};

/// What the file adds to a record.
struct JournalSeal {
  std::uint64_t file = 0;      ///< DiskStamp::identity of the file that it was written for
  std::uint32_t previous = 0;  ///< checksum of the record before, also across generations; or 0
};

/// A record on disk, 256 bytes, little endian:
///
///   at  | size | what
///   ----+------+--------------------------------------------------------------
///     0 |  4   | 53 4E 4A 4C, "SNJL"
///     4 |  1   | version, 3; 2 is read too, whose file only grew, and 1, which has no count zeros
///     5 |  1   | kind
///     6 |  1   | joints, 1..8
///     7 |  1   | cause
///     8 |  8   | sequence
///    16 |  4   | generation
///    20 |  4   | joint k in bits 4k..4k+3: quality (0 lost, 1 uncertain, 2 commanded, 3 measured),
///       |      | plus 4 where its count zero is known, plus 8 where its counter in the device
///       |      | shows whether the power was away
///    24 |  4   | robot
///    28 |  4   | model
///    32 |  8   | run time, ns, signed
///    40 |  8   | wall time, ns since 1970, signed
///    48 |  8   | identity of the file
///    56 | 192  | joint k at 56 + 24k: q, lower, upper, IEEE 754 binary64; zeros where unused or
///    lost
///       |      | behind the last joint, of up to six: count zero of joint k, binary64; zeros where
///       |      | not known
///   248 |  4   | checksum of the record before
///   252 |  4   | CRC-32C of bytes 0..251
///
/// It stands twice, one behind the other, in a slot of 512 bytes: a damaged bit spoils one of them,
/// and no sector of a disk holds half a slot.
inline constexpr std::size_t kJournalRecordSize = 256;
inline constexpr std::size_t kJournalSlotSize = 2 * kJournalRecordSize;
using JournalRecordBytes = std::array<std::uint8_t, kJournalRecordSize>;

/// A file of version 3 grows by so many empty slots at once, and records are written over them. The
/// next ones are safe before the last of the old ones is written: so a file's length is known from
/// its last record, and behind that an empty slot stands always.
inline constexpr std::size_t kJournalChunkSize = 16 * kJournalSlotSize;
/// Each byte of an empty slot. No file system and no medium leaves it where something is lost.
inline constexpr std::uint8_t kJournalEmpty = 0xE5;
/// An empty slot, of which one bit may have turned over.
bool is_empty_journal_slot(std::span<const std::uint8_t> slot);

/// @rt; the record must be valid (is_valid).
JournalRecordBytes encode(const JournalRecord& record, const JournalSeal& seal);
/// The CRC-32C that stands in the record's last four bytes. @rt
std::uint32_t checksum_of(const JournalRecordBytes& bytes);
/// Joints 1..8, numbers finite and in order, zeros where they must be. @rt
bool is_valid(const JournalRecord& record);

struct SealedRecord {
  JournalRecord record;
  JournalSeal seal;
  std::uint32_t checksum = 0;
  std::uint8_t version = 0;
};

/// Nothing where one bit is not as encode() would have written it. @rt
std::optional<SealedRecord> decode_journal_record(std::span<const std::uint8_t> bytes);
/// True where the bytes are a whole record of a later version than this program's. @rt
bool is_newer_journal_record(std::span<const std::uint8_t> bytes);

/// A name or a description as the 32 bits of a JournalOwner. @rt
std::uint32_t journal_hash(std::string_view text);

}  // namespace sinew
