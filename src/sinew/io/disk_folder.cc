#include "sinew/io/disk_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

namespace sinew::io {
namespace {

constexpr mode_t kMode = S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH;

std::unexpected<DiskError> refuse(int error) {
  DiskError result{DiskErrorCode::kFailed, error};
  if (error == ENOSPC || error == EDQUOT) result = {DiskErrorCode::kFull, 0};
  if (error == EACCES || error == EPERM || error == EROFS) result = {DiskErrorCode::kDenied, 0};
  if (error == ENOENT || error == ENOTDIR) result = {DiskErrorCode::kMissing, 0};
  if (error == ENAMETOOLONG || error == EFBIG) result = {DiskErrorCode::kTooLarge, 0};
  return std::unexpected(result);
}

bool is_name(std::string_view name) {
  return !name.empty() && name.size() <= Disk::kNameMax && name != "." && name != ".." &&
         !name.contains('/') && !name.contains('\0');
}

/// Only our own names come in here: a bad one is a bug of the caller that must not reach the disk.
std::unexpected<DiskError> refuse_name() {
  return refuse(EINVAL);
}

/// The number that stands in a lock file; 0 where none does.
std::int32_t holder_of(int file) {
  std::array<char, 16> text{};
  const ssize_t size = ::pread(file, text.data(), text.size(), 0);
  std::int32_t pid = 0;
  if (size > 0) std::from_chars(text.data(), text.data() + size, pid);
  return pid;
}

}  // namespace

IoResult<DiskFolder> DiskFolder::open_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) return std::unexpected(system_error(path, error.value()));
  const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return std::unexpected(system_error(path, errno));
  DiskFolder result(path, folder);
  // The folder's own name has to be safe too, before anything in it is.
  const int above = ::openat(folder, "..", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (above >= 0) {
    ::fsync(above);
    ::close(above);
  }
  return result;
}

DiskFolder::DiskFolder(DiskFolder&& other) noexcept
    : path_(std::move(other.path_)),
      folder_(std::exchange(other.folder_, -1)),
      lock_(std::exchange(other.lock_, -1)) {}

DiskFolder::~DiskFolder() {
  if (lock_ >= 0) ::close(lock_);
  if (folder_ >= 0) ::close(folder_);
}

DiskResult<DiskFile> DiskFolder::open_with(std::string_view name, int flags) const {
  if (!is_name(name)) return refuse_name();
  const int file = ::openat(folder_, std::string(name).c_str(),
                            flags | O_WRONLY | O_NOFOLLOW | O_CLOEXEC, kMode);
  if (file < 0) return refuse(errno);
  return DiskFile{file};
}

DiskResult<DiskFile> DiskFolder::create(std::string_view name) {
  return open_with(name, O_CREAT | O_TRUNC);
}

DiskResult<DiskFile> DiskFolder::open(std::string_view name) {
  return open_with(name, 0);
}

void DiskFolder::close(DiskFile file) {
  if (file.id >= 0) ::close(file.id);
}

DiskResult<void> DiskFolder::write(DiskFile file, std::uint64_t at,
                                   std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(file.id, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return refuse(errno);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    at += static_cast<std::uint64_t>(count);
  }
  return {};
}

DiskResult<void> DiskFolder::append(DiskFile file, std::span<const std::uint8_t> bytes) {
  const off_t end = ::lseek(file.id, 0, SEEK_END);
  if (end < 0) return refuse(errno);
  return write(file, static_cast<std::uint64_t>(end), bytes);
}

DiskResult<void> DiskFolder::sync(DiskFile file) {
  // Not again after an error: the system may have forgotten by then what it did not write.
  if (::fdatasync(file.id) != 0) return refuse(errno);
  return {};
}

DiskResult<std::size_t> DiskFolder::read(std::string_view name, std::span<std::uint8_t> out) {
  if (!is_name(name)) return refuse_name();
  const int file =
      ::openat(folder_, std::string(name).c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return refuse(errno);
  std::size_t size = 0;
  int error = 0;
  while (error == 0) {
    std::uint8_t beyond = 0;
    const bool full = size == out.size();
    const ssize_t count =
        full ? ::read(file, &beyond, 1) : ::read(file, out.data() + size, out.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) break;
    if (count < 0) {
      error = errno;
    } else if (full) {
      error = EFBIG;
    } else {
      size += static_cast<std::size_t>(count);
    }
  }
  ::close(file);
  if (error != 0) return refuse(error);
  return size;
}

DiskResult<DiskStamp> DiskFolder::stamp(std::string_view name) {
  if (!is_name(name)) return refuse_name();
  struct stat status{};
  if (::fstatat(folder_, std::string(name).c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) {
    return refuse(errno);
  }
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  return DiskStamp{status.st_ino, status.st_ctim.tv_sec * kNanoseconds + status.st_ctim.tv_nsec,
                   static_cast<std::uint64_t>(status.st_size)};
}

DiskResult<void> DiskFolder::rename(std::string_view from, std::string_view to) {
  if (!is_name(from) || !is_name(to)) return refuse_name();
  if (::renameat(folder_, std::string(from).c_str(), folder_, std::string(to).c_str()) != 0) {
    return refuse(errno);
  }
  return {};
}

DiskResult<void> DiskFolder::remove(std::string_view name) {
  if (!is_name(name)) return refuse_name();
  if (::unlinkat(folder_, std::string(name).c_str(), 0) != 0) return refuse(errno);
  return {};
}

DiskResult<std::vector<std::string>> DiskFolder::list() {
  const int again = ::openat(folder_, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (again < 0) return refuse(errno);
  const auto closer = [](DIR* folder) { ::closedir(folder); };
  const std::unique_ptr<DIR, decltype(closer)> folder(::fdopendir(again), closer);
  if (!folder) {
    const int error = errno;
    ::close(again);
    return refuse(error);
  }
  std::vector<std::string> names;
  while (const dirent* entry = ::readdir(folder.get())) {
    const std::string_view name = entry->d_name;
    if (name == "." || name == "..") continue;
    if (names.size() == kFilesMax) return refuse(EFBIG);
    names.emplace_back(name);
  }
  std::ranges::sort(names);
  return names;
}

DiskResult<void> DiskFolder::sync_folder() {
  if (::fsync(folder_) != 0) return refuse(errno);
  return {};
}

DiskResult<void> DiskFolder::lock(std::string_view name) {
  if (!is_name(name)) return refuse_name();
  if (lock_ >= 0) return std::unexpected(DiskError{DiskErrorCode::kLocked, ::getpid()});
  const int file = ::openat(folder_, std::string(name).c_str(),
                            O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, kMode);
  if (file < 0) return refuse(errno);
  if (::flock(file, LOCK_EX | LOCK_NB) != 0) {
    const int error = errno;
    const std::int32_t holder = holder_of(file);
    ::close(file);
    if (error == EWOULDBLOCK) return std::unexpected(DiskError{DiskErrorCode::kLocked, holder});
    return refuse(error);
  }
  lock_ = file;
  const std::string text = std::to_string(::getpid()) + "\n";
  // For people only: a full disk does not make the lock any weaker.
  static_cast<void>(::ftruncate(file, 0) == 0 && ::write(file, text.data(), text.size()) > 0);
  return {};
}

IoError disk_error(const std::string& subject, const DiskError& error) {
  switch (error.code) {
    case DiskErrorCode::kFull:
      return system_error(subject, ENOSPC);
    case DiskErrorCode::kDenied:
      return system_error(subject, EACCES);
    case DiskErrorCode::kMissing:
      return system_error(subject, ENOENT);
    case DiskErrorCode::kTooLarge:
      return system_error(subject, EFBIG);
    case DiskErrorCode::kLocked:
      return {subject + ": in use by " +
              (error.number > 0 ? "process " + std::to_string(error.number) : "another process")};
    case DiskErrorCode::kFailed:
      break;
  }
  return system_error(subject, error.number);
}

}  // namespace sinew::io
