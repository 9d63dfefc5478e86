#include "sinew/sim/memory_disk.h"

#include <algorithm>
#include <cerrno>
#include <utility>

namespace sinew::sim {
namespace {

std::unexpected<DiskError> refuse(DiskErrorCode code, int number = 0) {
  return std::unexpected(DiskError{code, number});
}

}  // namespace

DiskResult<void> MemoryDisk::begin_call() {
  if (power_is_cut()) return refuse(DiskErrorCode::kFailed, EIO);
  ++calls_;
  if (fail_from_ != 0 && calls_ >= fail_from_) return std::unexpected(failure_);
  return {};
}

MemoryDisk::Inode* MemoryDisk::inode_of(DiskFile file) {
  const auto found = open_.find(file.id);
  return found == open_.end() ? nullptr : &inodes_.at(found->second);
}

std::uint64_t MemoryDisk::add_inode(const std::vector<std::uint8_t>& bytes) {
  const std::size_t size = bytes.size();
  inodes_[next_identity_] = {bytes, bytes, {}, {next_identity_, wall_ns_, size}};
  return next_identity_++;
}

DiskResult<DiskFile> MemoryDisk::create(std::string_view name) {
  if (auto begun = begin_call(); !begun) return std::unexpected(begun.error());
  const std::uint64_t identity = add_inode({});
  folder_[std::string(name)] = identity;
  folder_changed();
  open_[next_file_] = identity;
  return DiskFile{next_file_++};
}

DiskResult<DiskFile> MemoryDisk::open(std::string_view name) {
  const auto found = folder_.find(name);
  if (found == folder_.end()) return refuse(DiskErrorCode::kMissing);
  open_[next_file_] = found->second;
  return DiskFile{next_file_++};
}

void MemoryDisk::close(DiskFile file) {
  open_.erase(file.id);
}

std::size_t MemoryDisk::used() const {
  std::size_t sum = 0;
  for (const auto& [name, identity] : folder_) sum += inodes_.at(identity).bytes.size();
  return sum;
}

DiskResult<void> MemoryDisk::append(DiskFile file, std::span<const std::uint8_t> bytes) {
  const Inode* inode = inode_of(file);
  return write(file, inode == nullptr ? 0 : inode->bytes.size(), bytes);
}

DiskResult<void> MemoryDisk::write(DiskFile file, std::uint64_t at,
                                   std::span<const std::uint8_t> bytes) {
  if (auto begun = begin_call(); !begun) return begun;
  Inode* inode = inode_of(file);
  if (inode == nullptr) return refuse(DiskErrorCode::kFailed, EBADF);
  // What stands there already needs no room.
  std::size_t end = at + bytes.size();
  if (capacity_) {
    const std::size_t room = *capacity_ - std::min(*capacity_, used());
    end = std::min(end, inode->bytes.size() + room);
  }
  const auto fitting = bytes.first(end > at ? end - at : 0);
  if (!fitting.empty()) {
    if (inode->bytes.size() < end) inode->bytes.resize(end);
    std::ranges::copy(fitting, inode->bytes.begin() + static_cast<std::ptrdiff_t>(at));
    inode->writes.push_back({at, end});
  }
  inode->stamp.changed_ns = wall_ns_;
  if (fitting.size() < bytes.size()) return refuse(DiskErrorCode::kFull);
  if (power_is_cut()) return refuse(DiskErrorCode::kFailed, EIO);
  return {};
}

DiskResult<void> MemoryDisk::sync(DiskFile file) {
  if (auto begun = begin_call(); !begun) return begun;
  Inode* inode = inode_of(file);
  if (inode == nullptr) return refuse(DiskErrorCode::kFailed, EBADF);
  if (power_is_cut()) return refuse(DiskErrorCode::kFailed, EIO);
  inode->safe = inode->bytes;
  inode->writes.clear();
  ++syncs_;
  const auto spread = static_cast<double>((sync_upper_ - sync_lower_).count());
  time_ += sync_lower_ + Duration{static_cast<std::int64_t>(sync_random_.uniform(0, spread))};
  return {};
}

DiskResult<std::size_t> MemoryDisk::read(std::string_view name, std::span<std::uint8_t> out) {
  const auto found = folder_.find(name);
  if (found == folder_.end()) return refuse(DiskErrorCode::kMissing);
  const Inode& inode = inodes_.at(found->second);
  if (inode.bytes.size() > out.size()) return refuse(DiskErrorCode::kTooLarge);
  std::ranges::copy(inode.bytes, out.begin());
  return inode.bytes.size();
}

DiskResult<DiskStamp> MemoryDisk::stamp(std::string_view name) {
  const auto found = folder_.find(name);
  if (found == folder_.end()) return refuse(DiskErrorCode::kMissing);
  const Inode& inode = inodes_.at(found->second);
  DiskStamp stamp = inode.stamp;
  stamp.size = inode.bytes.size();
  return stamp;
}

DiskResult<void> MemoryDisk::rename(std::string_view from, std::string_view to) {
  if (auto begun = begin_call(); !begun) return begun;
  const auto found = folder_.find(from);
  if (found == folder_.end()) return refuse(DiskErrorCode::kMissing);
  const std::uint64_t identity = found->second;
  folder_.erase(found);
  folder_[std::string(to)] = identity;
  inodes_.at(identity).stamp.changed_ns = wall_ns_;
  folder_changed();
  if (power_is_cut()) return refuse(DiskErrorCode::kFailed, EIO);
  return {};
}

DiskResult<void> MemoryDisk::remove(std::string_view name) {
  if (auto begun = begin_call(); !begun) return begun;
  const auto found = folder_.find(name);
  if (found == folder_.end()) return refuse(DiskErrorCode::kMissing);
  folder_.erase(found);
  folder_changed();
  return {};
}

DiskResult<std::vector<std::string>> MemoryDisk::list() {
  std::vector<std::string> names;
  for (const auto& [name, identity] : folder_) names.push_back(name);
  return names;
}

DiskResult<void> MemoryDisk::sync_folder() {
  if (auto begun = begin_call(); !begun) return begun;
  if (power_is_cut()) return refuse(DiskErrorCode::kFailed, EIO);
  safe_folder_ = folder_;
  unsafe_folders_.clear();
  const auto spread = static_cast<double>((sync_upper_ - sync_lower_).count());
  time_ += sync_lower_ + Duration{static_cast<std::int64_t>(sync_random_.uniform(0, spread))};
  return {};
}

DiskResult<void> MemoryDisk::lock(std::string_view) {
  if (locked_) return refuse(DiskErrorCode::kLocked, 1);
  locked_ = true;
  return {};
}

void MemoryDisk::kill_process() {
  open_.clear();
  locked_ = false;
  cut_at_ = 0;
  fail_from_ = 0;
  time_ = {};
}

/// Every write since the last sync meets its own fate, in whole bytes.
void MemoryDisk::spoil(Inode& inode, SplitMix64& random) {
  const std::vector<std::uint8_t> wanted = std::move(inode.bytes);
  std::vector<std::uint8_t>& bytes = inode.bytes;
  bytes = inode.safe;
  bytes.resize(wanted.size());
  const auto comes = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) bytes[i] = wanted[i];
  };
  for (const auto& [begin, end] : inode.writes) {
    if (begin == end) continue;
    const std::size_t cut = begin + random.bits() % (end - begin);
    switch (random.bits() % 8) {
      case 0:
        comes(begin, end);
        break;
      case 1:
        for (std::size_t i = begin; i < end; ++i) bytes[i] = 0;
        break;
      case 2:
        comes(begin, cut);
        for (std::size_t i = cut; i < end; ++i) bytes[i] = 0;
        break;
      case 3:
        comes(begin, cut);
        for (std::size_t i = cut; i < end; ++i) bytes[i] = static_cast<std::uint8_t>(random.bits());
        break;
      case 4:
        comes(begin, end);
        bytes[cut] = static_cast<std::uint8_t>(bytes[cut] ^ 1U << random.bits() % 8);
        break;
      case 5:
        break;  // what stood there before
      case 6:
        comes(begin, cut);
        break;
      default:
        comes(cut, end);
        break;
    }
  }
  // How far the file's length came is another write.
  const std::size_t unsafe = bytes.size() - inode.safe.size();
  switch (random.bits() % 3) {
    case 0:
      break;
    case 1:
      bytes.resize(inode.safe.size() + random.bits() % (unsafe + 1));
      break;
    default:
      bytes.resize(inode.safe.size());
      break;
  }
  inode.safe = bytes;
  inode.writes.clear();
}

void MemoryDisk::lose_power(std::uint64_t seed) {
  SplitMix64 random(seed);
  const std::size_t kept = random.bits() % (unsafe_folders_.size() + 1);
  folder_ = kept == 0 ? safe_folder_ : unsafe_folders_[kept - 1];
  safe_folder_ = folder_;
  unsafe_folders_.clear();
  for (auto& [identity, inode] : inodes_) spoil(inode, random);
  kill_process();
}

void MemoryDisk::set_sync_time(Duration lower, Duration upper, std::uint64_t seed) {
  sync_lower_ = lower;
  sync_upper_ = upper;
  sync_random_ = SplitMix64(seed);
}

Duration MemoryDisk::take_time() {
  return std::exchange(time_, {});
}

std::optional<std::vector<std::uint8_t>> MemoryDisk::bytes(const std::string& name) const {
  const auto found = folder_.find(name);
  if (found == folder_.end()) return std::nullopt;
  return inodes_.at(found->second).bytes;
}

void MemoryDisk::rot(const std::string& name, std::vector<std::uint8_t> bytes) {
  Inode& inode = inodes_.at(folder_.at(name));
  inode.bytes = std::move(bytes);
  inode.safe = inode.bytes;
  inode.writes.clear();
}

void MemoryDisk::overwrite(const std::string& name, std::vector<std::uint8_t> bytes) {
  rot(name, std::move(bytes));
  inodes_.at(folder_.at(name)).stamp.changed_ns = wall_ns_;
}

void MemoryDisk::replace(const std::string& name, std::vector<std::uint8_t> bytes) {
  folder_[name] = add_inode(bytes);
  safe_folder_ = folder_;
  unsafe_folders_.clear();
}

}  // namespace sinew::sim
