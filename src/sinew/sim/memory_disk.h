#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sinew/core/disk.h"
#include "sinew/core/instant.h"
#include "sinew/core/split_mix.h"

namespace sinew::sim {

/// A folder in memory with a page cache that a power loss goes through: what was synced stays; of
/// the rest each write is kept, lost, torn at any byte, turned into zeros or garbled, whatever
/// becomes of the others; the file ends anywhere behind what is safe; and the names since the last
/// sync_folder() are as before from some call on. All of it by a seed. Copies share nothing: a run
/// can be crashed in as many ways as there are copies.
class MemoryDisk final : public Disk {
 public:
  DiskResult<DiskFile> create(std::string_view name) override;
  DiskResult<DiskFile> open(std::string_view name) override;
  void close(DiskFile file) override;
  DiskResult<void> write(DiskFile file, std::uint64_t at,
                         std::span<const std::uint8_t> bytes) override;
  DiskResult<void> append(DiskFile file, std::span<const std::uint8_t> bytes) override;
  DiskResult<void> sync(DiskFile file) override;
  DiskResult<std::size_t> read(std::string_view name, std::span<std::uint8_t> out) override;
  DiskResult<DiskStamp> stamp(std::string_view name) override;
  DiskResult<void> rename(std::string_view from, std::string_view to) override;
  DiskResult<void> remove(std::string_view name) override;
  DiskResult<std::vector<std::string>> list() override;
  DiskResult<void> sync_folder() override;
  DiskResult<void> lock(std::string_view name) override;

  /// The process dies: files and lock are let go of, the page cache stays.
  void kill_process();
  /// The power goes: as above, and the page cache is lost.
  void lose_power(std::uint64_t seed);

  /// All files together hold no more than so many bytes; of a write that goes beyond stays what
  /// still has room.
  void set_capacity(std::size_t bytes) { capacity_ = bytes; }
  /// From the n-th call that writes (from 1, of all since the disk was made) on each fails so.
  void fail_from_call(std::uint64_t n, DiskError error) { fail_from_ = n, failure_ = error; }
  /// From then on nothing changes any more: the power goes while the n-th writing call runs. What
  /// it was to do stands in the page cache, and nothing of it is safe.
  void cut_power_at_call(std::uint64_t n) { cut_at_ = n; }
  bool power_is_cut() const { return cut_at_ != 0 && calls_ >= cut_at_; }
  /// How many calls that write there were: create, write, sync, rename, remove, sync_folder.
  std::uint64_t calls() const { return calls_; }
  /// A sync takes a time between these.
  void set_sync_time(Duration lower, Duration upper, std::uint64_t seed);
  /// What all calls since the last time took; no clock moves by itself.
  Duration take_time();
  /// The wall clock that stamps take their time from.
  void set_wall(std::int64_t nanoseconds) { wall_ns_ = nanoseconds; }
  std::uint64_t syncs() const { return syncs_; }

  /// Past the interface, for what a person or bad flash does. Nothing where there is no such file.
  std::optional<std::vector<std::uint8_t>> bytes(const std::string& name) const;
  /// As an editor does that writes into the same file: it keeps its identity.
  void overwrite(const std::string& name, std::vector<std::uint8_t> bytes);
  /// As an editor or a copy does that makes a file anew.
  void replace(const std::string& name, std::vector<std::uint8_t> bytes);
  /// Bits that turn over by themselves: no stamp tells.
  void rot(const std::string& name, std::vector<std::uint8_t> bytes);

 private:
  struct Write {
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  struct Inode {
    std::vector<std::uint8_t> bytes;  ///< as the page cache has them
    std::vector<std::uint8_t> safe;   ///< as the medium has them
    std::vector<Write> writes;        ///< since then
    DiskStamp stamp;
  };
  using Folder = std::map<std::string, std::uint64_t, std::less<>>;

  DiskResult<void> begin_call();
  Inode* inode_of(DiskFile file);
  void folder_changed() { unsafe_folders_.push_back(folder_); }
  std::size_t used() const;
  static void spoil(Inode& inode, SplitMix64& random);
  std::uint64_t add_inode(const std::vector<std::uint8_t>& bytes);

  std::map<std::uint64_t, Inode> inodes_;  ///< by identity
  Folder folder_;                          ///< as the page cache has it
  std::vector<Folder> unsafe_folders_;     ///< after each call since the last sync_folder()
  Folder safe_folder_;
  std::map<std::int32_t, std::uint64_t> open_;
  std::int32_t next_file_ = 1;
  std::uint64_t next_identity_ = 1;
  bool locked_ = false;

  std::optional<std::size_t> capacity_;
  std::uint64_t calls_ = 0;
  std::uint64_t syncs_ = 0;
  std::uint64_t fail_from_ = 0;
  DiskError failure_;
  std::uint64_t cut_at_ = 0;
  std::int64_t wall_ns_ = 0;
  Duration sync_lower_{};
  Duration sync_upper_{};
  SplitMix64 sync_random_{0};
  Duration time_{};
};

}  // namespace sinew::sim
