#include "sinew/control/journal_record.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/wire/crc32c.h"

namespace sinew {
namespace {

constexpr std::array<std::uint8_t, 4> kMagic{0x53, 0x4E, 0x4A, 0x4C};
constexpr std::uint8_t kVersion = 3;
/// Has no count zeros; else the same.
constexpr std::uint8_t kWithoutZeros = 1;
constexpr std::size_t kJoints = 56;
constexpr std::size_t kJointSize = 24;
constexpr std::size_t kPrevious = 248;
constexpr std::size_t kChecksum = 252;
constexpr std::size_t kZeroSize = 8;
/// Of a joint's four bits.
constexpr std::uint32_t kBitsMask = 15;
constexpr std::uint32_t kQualityMask = 3;
constexpr std::uint32_t kZeroBit = 4;
constexpr std::uint32_t kCountedBit = 8;
static_assert(kJoints + kMaxJoints * kJointSize == kPrevious);

/// What is left behind the joints has room for all their count zeros.
constexpr bool has_zeros(std::size_t joints) {
  return joints * (kJointSize + kZeroSize) <= kMaxJoints * kJointSize;
}

template <class Word>
void put(JournalRecordBytes& bytes, std::size_t at, Word value) {
  for (std::size_t k = 0; k < sizeof(Word); ++k) {
    bytes[at + k] = static_cast<std::uint8_t>(value >> (8 * k));
  }
}

template <class Word>
Word get(std::span<const std::uint8_t> bytes, std::size_t at) {
  Word value = 0;
  for (std::size_t k = sizeof(Word); k-- > 0;) {
    value = static_cast<Word>(value << 8 | bytes[at + k]);
  }
  return value;
}

double get_double(std::span<const std::uint8_t> bytes, std::size_t at) {
  return std::bit_cast<double>(get<std::uint64_t>(bytes, at));
}

bool is_valid(const JointPosition& joint) {
  if (joint.quality > PositionQuality::kMeasured) return false;
  if (joint.count_zero && !std::isfinite(*joint.count_zero)) return false;
  const std::array numbers{joint.q, joint.lower, joint.upper};
  if (joint.quality == PositionQuality::kLost) {
    // Not even a sign: there is one way to write a lost joint.
    return std::ranges::all_of(
        numbers, [](double number) { return std::bit_cast<std::uint64_t>(number) == 0; });
  }
  return std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); }) &&
         joint.lower <= joint.q && joint.q <= joint.upper;
}

bool has_frame(std::span<const std::uint8_t> bytes) {
  return bytes.size() == kJournalRecordSize && std::ranges::equal(bytes.first<4>(), kMagic) &&
         get<std::uint32_t>(bytes, kChecksum) == crc32c(bytes.first(kChecksum));
}

}  // namespace

bool is_valid(const JournalRecord& record) {
  return record.kind >= JournalKind::kOpened && record.kind <= JournalKind::kLook &&
         record.cause <= JournalCause::kHeld && record.sequence > 0 && record.generation > 0 &&
         !record.positions.empty() && record.counted >> record.positions.size() == 0 &&
         std::ranges::all_of(record.positions,
                             [](const JointPosition& joint) { return is_valid(joint); });
}

JournalRecordBytes encode(const JournalRecord& record, const JournalSeal& seal) {
  SINEW_ASSERT(is_valid(record));
  JournalRecordBytes bytes{};
  std::ranges::copy(kMagic, bytes.begin());
  bytes[4] = kVersion;
  bytes[5] = static_cast<std::uint8_t>(record.kind);
  bytes[6] = static_cast<std::uint8_t>(record.positions.size());
  bytes[7] = static_cast<std::uint8_t>(record.cause);
  put(bytes, 8, record.sequence);
  put(bytes, 16, record.generation);
  put(bytes, 24, record.owner.robot);
  put(bytes, 28, record.owner.model);
  put(bytes, 32, static_cast<std::uint64_t>(record.time.run.time_since_epoch().count()));
  put(bytes, 40, static_cast<std::uint64_t>(record.time.wall_ns));
  put(bytes, 48, seal.file);
  std::uint32_t qualities = 0;
  for (std::size_t k = 0; k < record.positions.size(); ++k) {
    const JointPosition& joint = record.positions[k];
    const std::uint32_t counted = (record.counted >> k & 1U) != 0 ? kCountedBit : 0;
    qualities |= (static_cast<std::uint32_t>(joint.quality) | counted) << (4 * k);
    put(bytes, kJoints + kJointSize * k, std::bit_cast<std::uint64_t>(joint.q));
    put(bytes, kJoints + kJointSize * k + 8, std::bit_cast<std::uint64_t>(joint.lower));
    put(bytes, kJoints + kJointSize * k + 16, std::bit_cast<std::uint64_t>(joint.upper));
    if (!joint.count_zero || !has_zeros(record.positions.size())) continue;
    qualities |= kZeroBit << (4 * k);
    put(bytes, kJoints + kJointSize * record.positions.size() + kZeroSize * k,
        std::bit_cast<std::uint64_t>(*joint.count_zero));
  }
  put(bytes, 20, qualities);
  put(bytes, kPrevious, seal.previous);
  put(bytes, kChecksum, crc32c(std::span(bytes).first<kChecksum>()));
  return bytes;
}

std::uint32_t checksum_of(const JournalRecordBytes& bytes) {
  return get<std::uint32_t>(bytes, kChecksum);
}

std::optional<SealedRecord> decode_journal_record(std::span<const std::uint8_t> bytes) {
  if (!has_frame(bytes) || bytes[4] == 0 || bytes[4] > kVersion) return std::nullopt;
  const std::size_t joints = bytes[6];
  if (joints == 0 || joints > kMaxJoints) return std::nullopt;
  SealedRecord sealed;
  JournalRecord& record = sealed.record;
  record.kind = static_cast<JournalKind>(bytes[5]);
  record.cause = static_cast<JournalCause>(bytes[7]);
  record.sequence = get<std::uint64_t>(bytes, 8);
  record.generation = get<std::uint32_t>(bytes, 16);
  record.owner = {get<std::uint32_t>(bytes, 24), get<std::uint32_t>(bytes, 28)};
  record.time.run = Instant{Duration{static_cast<std::int64_t>(get<std::uint64_t>(bytes, 32))}};
  record.time.wall_ns = static_cast<std::int64_t>(get<std::uint64_t>(bytes, 40));
  const auto qualities = get<std::uint32_t>(bytes, 20);
  // What a record does not use must be zero: there is one spelling of each.
  std::array<std::uint8_t, kJournalRecordSize> unused{};
  std::ranges::copy(bytes, unused.begin());
  bool spelled = joints == kMaxJoints || qualities >> (4 * joints) == 0;
  for (std::size_t k = 0; k < joints; ++k) {
    const std::size_t at = kJoints + kJointSize * k;
    const std::uint32_t bits = qualities >> (4 * k) & kBitsMask;
    JointPosition joint{static_cast<PositionQuality>(bits & kQualityMask), get_double(bytes, at),
                        get_double(bytes, at + 8), get_double(bytes, at + 16)};
    if ((bits & kZeroBit) != 0) {
      spelled = spelled && bytes[4] != kWithoutZeros && has_zeros(joints);
      const std::size_t zero = kJoints + kJointSize * joints + kZeroSize * k;
      if (!spelled) return std::nullopt;
      joint.count_zero = get_double(bytes, zero);
      std::fill_n(unused.begin() + static_cast<std::ptrdiff_t>(zero), kZeroSize, std::uint8_t{0});
    }
    if ((bits & kCountedBit) != 0) {
      record.counted = static_cast<std::uint8_t>(record.counted | 1U << k);
    }
    record.positions.push_back(joint);
  }
  sealed.seal = {get<std::uint64_t>(bytes, 48), get<std::uint32_t>(bytes, kPrevious)};
  const auto rest =
      std::span(unused).subspan(kJoints + kJointSize * joints, kJointSize * (kMaxJoints - joints));
  spelled = spelled && std::ranges::all_of(rest, [](std::uint8_t byte) { return byte == 0; });
  if (!spelled || !is_valid(record)) return std::nullopt;
  sealed.checksum = get<std::uint32_t>(bytes, kChecksum);
  sealed.version = bytes[4];
  return sealed;
}

bool is_newer_journal_record(std::span<const std::uint8_t> bytes) {
  return has_frame(bytes) && bytes[4] > kVersion;
}

bool is_empty_journal_slot(std::span<const std::uint8_t> slot) {
  if (slot.size() != kJournalSlotSize) return false;
  int turned = 0;
  for (const std::uint8_t byte : slot) {
    turned += std::popcount(static_cast<std::uint8_t>(byte ^ kJournalEmpty));
  }
  return turned <= 1;
}

std::uint32_t journal_hash(std::string_view text) {
  // Bytes through a fixed block each: string_view's characters are not uint8_t.
  std::uint32_t hash = 0;
  while (!text.empty()) {
    std::array<std::uint8_t, 64> block{};
    const std::size_t size = std::min(text.size(), block.size() - 4);
    for (std::size_t k = 0; k < 4; ++k) block[k] = static_cast<std::uint8_t>(hash >> (8 * k));
    std::transform(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(size),
                   block.begin() + 4, [](char c) { return static_cast<std::uint8_t>(c); });
    hash = crc32c(std::span(block).first(4 + size));
    text.remove_prefix(size);
  }
  return hash;
}

}  // namespace sinew
