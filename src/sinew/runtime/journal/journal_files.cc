#include "sinew/runtime/journal/journal_files.h"

#include <algorithm>

#include "sinew/core/assert.h"

namespace sinew::runtime {
namespace {

const std::vector<std::uint8_t>& empty_chunk() {
  static const std::vector<std::uint8_t> kChunk(kJournalChunkSize, kJournalEmpty);
  return kChunk;
}

}  // namespace

DiskResult<JournalBytes> JournalFiles::load() {
  JournalBytes journal;
  for (std::uint32_t k = 0; k < 2; ++k) {
    const std::string name = file_of(k);
    const auto stamp = disk_->stamp(name);
    if (!stamp && stamp.error().code == DiskErrorCode::kMissing) continue;
    if (!stamp) return std::unexpected(stamp.error());
    if (stamp->size > kFileMax) return std::unexpected(DiskError{DiskErrorCode::kTooLarge});
    journal.stamps[k] = *stamp;
    journal.bytes[k].resize(stamp->size);
    const auto size = disk_->read(name, journal.bytes[k]);
    if (!size) return std::unexpected(size.error());
    journal.bytes[k].resize(*size);
  }
  return journal;
}

DiskResult<void> JournalFiles::fail(const DiskError& error) {
  if (!failure_) failure_ = error;
  return std::unexpected(*failure_);
}

JournalFiles::Slot JournalFiles::seal(const JournalRecord& record) {
  const JournalRecordBytes bytes = encode(record, {identity_, end_.checksum});
  Slot slot{};
  std::ranges::copy(bytes, slot.begin());
  std::ranges::copy(bytes, slot.begin() + kJournalRecordSize);
  end_.sequence = record.sequence;
  end_.generation = record.generation;
  end_.checksum = checksum_of(bytes);
  return slot;
}

DiskResult<void> JournalFiles::write(const JournalRecord& record) {
  if (failure_) return std::unexpected(*failure_);
  SINEW_ASSERT(record.sequence == end_.sequence + 1);
  if (!file_ || record.generation != end_.generation) return begin_generation(record);
  // Recovery takes no more than that for what a crash may have spoiled.
  if (unsynced_ >= PositionJournal::kUnsyncedMax) {
    if (auto synced = sync(); !synced) return synced;
  }
  // So early that a sync comes before the last of the slots that there are is written.
  if (end_.next + (PositionJournal::kUnsyncedMax + 1) * kJournalSlotSize >= end_.length) {
    if (auto grown = disk_->write(*file_, end_.length, empty_chunk()); !grown) {
      return fail(grown.error());
    }
    end_.length += kJournalChunkSize;
  }
  if (auto added = disk_->write(*file_, end_.next, seal(record)); !added) {
    return fail(added.error());
  }
  end_.next += kJournalSlotSize;
  ++unsynced_;
  return {};
}

DiskResult<void> JournalFiles::sync() {
  if (failure_) return std::unexpected(*failure_);
  if (unsynced_ == 0) return {};
  if (auto synced = disk_->sync(*file_); !synced) return fail(synced.error());
  unsynced_ = 0;
  durable_ = end_.sequence;
  return {};
}

DiskResult<void> JournalFiles::begin_generation(const JournalRecord& record) {
  // The old one ends whole, so that its last word stands where it belongs.
  if (auto synced = sync(); !synced) return synced;
  const JournalEnd before = end_;
  SINEW_ASSERT(record.generation == before.generation + 1);
  if (file_) disk_->close(*file_);
  file_.reset();
  const std::string beside = name_ + ".new";
  const auto created = disk_->create(beside);
  if (!created) return fail(created.error());
  file_ = *created;
  const auto stamp = disk_->stamp(beside);
  if (!stamp) return fail(stamp.error());
  identity_ = stamp->identity;
  const Slot slot = seal(record);
  std::vector<std::uint8_t> chunk = empty_chunk();
  std::ranges::copy(slot, chunk.begin());
  if (auto added = disk_->write(*file_, 0, chunk); !added) return fail(added.error());
  end_.next = kJournalSlotSize;
  end_.length = kJournalChunkSize;
  if (auto synced = disk_->sync(*file_); !synced) return fail(synced.error());
  if (auto moved = disk_->rename(beside, file_of(record.generation)); !moved) {
    return fail(moved.error());
  }
  if (auto synced = disk_->sync_folder(); !synced) return fail(synced.error());
  if (auto ended = end_generation(before, slot); !ended) return ended;
  durable_ = record.sequence;
  return {};
}

DiskResult<void> JournalFiles::end_generation(const JournalEnd& end, const Slot& slot) {
  if (end.generation == 0) return {};
  const auto old = disk_->open(file_of(end.generation));
  // Somebody removed it; the new one stands by itself.
  if (!old && old.error().code == DiskErrorCode::kMissing) return {};
  if (!old) return fail(old.error());
  DiskResult<void> done;
  // A crash may have left anything of the chunk behind.
  if (end.length != 0 && end.next + kJournalSlotSize >= end.length) {
    done = disk_->write(*old, end.length, empty_chunk());
    if (done) done = disk_->sync(*old);
  }
  if (done) done = disk_->write(*old, end.next, slot);
  if (done) done = disk_->sync(*old);
  disk_->close(*old);
  if (!done) return fail(done.error());
  return {};
}

}  // namespace sinew::runtime
