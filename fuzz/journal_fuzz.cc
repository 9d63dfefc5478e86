#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/control/journal_recovery.h"
#include "sinew/core/assert.h"
#include "sinew/wire/crc32c.h"

// The position journal from any bytes. A record that is accepted, as it stands or with the checksum
// that it needs, is written as the very bytes it came from, and no flipped bit of it is accepted.
// Two files of any bytes give positions that are in order, never more than what the last whole
// record says, and a way out wherever a joint is not known.

namespace {

using namespace sinew;

void seal(JournalRecordBytes& bytes) {
  const std::uint32_t crc = crc32c(std::span(bytes).first<kJournalRecordSize - 4>());
  for (std::size_t k = 0; k < 4; ++k) {
    bytes[kJournalRecordSize - 4 + k] = static_cast<std::uint8_t>(crc >> (8 * k));
  }
}

void check_record(const JournalRecordBytes& bytes) {
  const auto sealed = decode_journal_record(bytes);
  if (!sealed) return;
  SINEW_ASSERT(is_valid(sealed->record));
  // The versions before are read, and not written any more.
  SINEW_ASSERT(bytes[4] < 3 || encode(sealed->record, sealed->seal) == bytes);
  SINEW_ASSERT(sealed->checksum == checksum_of(bytes));
  SINEW_ASSERT(!is_newer_journal_record(bytes));
  JournalRecordBytes hit = bytes;
  const std::size_t bit = (bytes[8] + std::size_t{8} * bytes[56]) % (8 * kJournalRecordSize);
  hit[bit / 8] = static_cast<std::uint8_t>(hit[bit / 8] ^ 1U << (bit % 8));
  SINEW_ASSERT(!decode_journal_record(hit));
}

void check_recovery(std::span<const std::uint8_t> first, std::span<const std::uint8_t> second) {
  std::size_t joints = 1;
  JournalOwner owner;
  for (const auto bytes : {first, second}) {
    if (bytes.size() < kJournalRecordSize) continue;
    const auto record = decode_journal_record(bytes.first(kJournalRecordSize));
    if (!record) continue;
    joints = record->record.positions.size();
    owner = record->record.owner;
  }
  const std::array files{JournalFile{first, {}}, JournalFile{second, {}}};
  const RecoverySettings settings{.owner = owner, .joints = joints, .power_up_way = {}};
  const JournalRecovery recovery = recover(files, settings);
  SINEW_ASSERT(recovery.positions.size() == joints && recovery.last_said.size() == joints);
  bool known = true;
  for (std::size_t k = 0; k < joints; ++k) {
    const JointPosition& said = recovery.positions[k];
    known = known && said.quality >= PositionQuality::kCommanded;
    SINEW_ASSERT(said.lower <= said.q && said.q <= said.upper);
    SINEW_ASSERT(said.quality <= recovery.last_said[k].quality);
  }
  SINEW_ASSERT(known == (recovery.way_out == WayOut::kNothing));
  SINEW_ASSERT(!sentence(recovery.finding).empty() && !sentence(recovery.way_out).empty());
  const std::size_t slots = (first.size() + second.size()) / kJournalSlotSize + 2;
  SINEW_ASSERT(recovery.damaged_slots <= slots);
}

/// All records sealed, so that what is behind the checksum is looked at too.
std::vector<std::uint8_t> sealed(std::span<const std::uint8_t> bytes) {
  std::vector<std::uint8_t> result(bytes.begin(), bytes.end());
  for (std::size_t at = 0; at + kJournalRecordSize <= result.size(); at += kJournalRecordSize) {
    JournalRecordBytes record{};
    std::copy_n(result.begin() + static_cast<std::ptrdiff_t>(at), kJournalRecordSize,
                record.begin());
    seal(record);
    std::ranges::copy(record, result.begin() + static_cast<std::ptrdiff_t>(at));
  }
  return result;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(data, size);
  JournalRecordBytes record{};
  std::copy_n(bytes.begin(), std::min(size, record.size()), record.begin());
  check_record(record);
  seal(record);
  check_record(record);
  // Where the first file ends is the input's to say.
  const std::size_t slots = size / kJournalSlotSize;
  const std::size_t cut = slots == 0 ? 0 : bytes[size - 1] % (slots + 1) * kJournalSlotSize;
  check_recovery(bytes.first(cut), bytes.subspan(cut));
  const std::vector<std::uint8_t> whole = sealed(bytes);
  check_recovery(std::span(whole).first(cut), std::span(whole).subspan(cut));
  return 0;
}
