#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sinew/control/journal_record.h"
#include "sinew/control/journal_recovery.h"
#include "sinew/control/position_journal.h"
#include "sinew/core/disk.h"

namespace sinew::runtime {

/// Both generations as they stand on disk.
struct JournalBytes {
  std::array<std::vector<std::uint8_t>, 2> bytes;
  std::array<DiskStamp, 2> stamps;

  std::array<JournalFile, 2> files() const {
    return {JournalFile{bytes[0], stamps[0]}, JournalFile{bytes[1], stamps[1]}};
  }
};

/// The two files of one robot's journal, NAME.0 and NAME.1: generation g stands in NAME.(g mod 2).
///
/// A new generation is written to NAME.new and synced; that takes the place of the generation
/// before the last one; the folder is synced. Only then its first record is also added to the last
/// one, whose final word it is. So there is a whole journal under the two names at every moment,
/// and a file that goes missing, or comes back as it once was, contradicts the other one. Each file
/// is longer than its records (kJournalChunkSize), so that one that was cut is too short.
///
/// The first error stays: nothing is written any more, what stands there can still be read.
class JournalFiles {
 public:
  /// A file is not read beyond so many bytes; the journal's own stay far below.
  static constexpr std::size_t kFileMax = std::size_t{16} << 20;

  JournalFiles(Disk& disk, std::string name) : disk_(&disk), name_(std::move(name)) {}

  /// For this process alone, before anything else. @error kLocked
  DiskResult<void> lock() { return disk_->lock(name_ + ".lock"); }
  /// A file that is not there has no bytes.
  DiskResult<JournalBytes> load();
  /// The next records follow this one.
  void continue_after(const JournalEnd& end) { end_ = end; }

  /// Adds the record. Where it opens a generation all of the above is done, and it is safe.
  DiskResult<void> write(const JournalRecord& record);
  /// All records are safe.
  DiskResult<void> sync();
  /// Up to where they are.
  std::uint64_t durable_sequence() const { return durable_; }
  const std::optional<DiskError>& failure() const { return failure_; }

 private:
  using Slot = std::array<std::uint8_t, kJournalSlotSize>;

  Slot seal(const JournalRecord& record);
  DiskResult<void> begin_generation(const JournalRecord& record);
  DiskResult<void> end_generation(const JournalEnd& end, const Slot& slot);
  DiskResult<void> fail(const DiskError& error);
  std::string file_of(std::uint32_t generation) const {
    return name_ + (generation % 2 == 0 ? ".0" : ".1");
  }

  Disk* disk_;
  std::string name_;
  JournalEnd end_;
  std::optional<DiskFile> file_;
  std::uint64_t identity_ = 0;
  std::uint64_t durable_ = 0;
  std::size_t unsynced_ = 0;
  std::optional<DiskError> failure_;
};

}  // namespace sinew::runtime
