#include "sinew/io/file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "sinew/io/clock.h"

namespace sinew::io {
namespace {

constexpr Duration kTurnLook = std::chrono::milliseconds(5);

struct Descriptor {
  int value = -1;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

/// A pipe may have nothing yet, or no room.
void wait_for(int descriptor, short event) {
  pollfd wait{descriptor, event, 0};
  ::poll(&wait, 1, -1);
}

/// 0 or an errno.
int write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(descriptor, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) {
      wait_for(descriptor, POLLOUT);
    } else if (count < 0) {
      return errno;
    } else {
      text.remove_prefix(static_cast<std::size_t>(count));
    }
  }
  return 0;
}

IoResult<void> write_in_place(const std::string& path, std::string_view text) {
  const Descriptor file{::open(path.c_str(), O_WRONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
  if (file.value < 0) return std::unexpected(system_error(path, errno));
  if (const int error = write_all(file.value, text)) {
    return std::unexpected(system_error(path, error));
  }
  return {};
}

/// "." for a name alone.
std::string folder_of(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  return slash == std::string::npos ? "." : path.substr(0, slash + 1);
}

/// What a symbolic link says; empty where it is none.
std::string link_target(const std::string& path) {
  std::array<char, PATH_MAX> buffer{};
  const ssize_t length = ::readlink(path.c_str(), buffer.data(), buffer.size());
  return {buffer.data(), static_cast<std::size_t>(std::max<ssize_t>(length, 0))};
}

/// Where links lead; the path itself where nothing stands there yet.
std::string real_path(const std::string& path) {
  std::array<char, PATH_MAX> buffer{};
  return ::realpath(path.c_str(), buffer.data()) != nullptr ? buffer.data() : path;
}

}  // namespace

IoResult<std::string> read_file(const std::string& path, std::size_t size_max) {
  // Without O_NONBLOCK a pipe that nobody writes to would hold the open() for ever.
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
  if (file.value < 0) return std::unexpected(system_error(path, errno));
  struct stat status{};
  if (fstat(file.value, &status) != 0) return std::unexpected(system_error(path, errno));
  if (S_ISDIR(status.st_mode)) return std::unexpected(IoError{path + ": is a folder, not a file"});
  const bool pipe = S_ISFIFO(status.st_mode);
  if (!pipe && !S_ISREG(status.st_mode)) {
    return std::unexpected(IoError{path + ": is a device, not a file"});
  }
  std::string text;
  std::array<char, 65536> buffer;
  while (true) {
    const ssize_t count = ::read(file.value, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) {
      wait_for(file.value, POLLIN);
      continue;
    }
    if (count < 0) return std::unexpected(system_error(path, errno));
    if (count == 0 && pipe && text.empty()) {
      return std::unexpected(IoError{path + ": nobody writes to this pipe"});
    }
    if (count == 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(count));
    if (text.size() > size_max) {
      return std::unexpected(
          IoError{path + ": larger than " + std::to_string(size_max) + " bytes"});
    }
  }
}

IoResult<std::string> read_part(const std::string& path, std::uint64_t offset, std::size_t size) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
  if (file.value < 0) return std::unexpected(system_error(path, errno));
  struct stat status{};
  if (fstat(file.value, &status) != 0) return std::unexpected(system_error(path, errno));
  if (!S_ISREG(status.st_mode)) return std::unexpected(IoError{path + ": is no plain file"});
  if (offset >= static_cast<std::uint64_t>(status.st_size)) return std::string();
  std::string text(size, '\0');
  std::size_t got = 0;
  while (got < size) {
    const auto at = static_cast<off_t>(offset + got);
    const ssize_t count = ::pread(file.value, text.data() + got, size - got, at);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return std::unexpected(system_error(path, errno));
    if (count == 0) break;
    got += static_cast<std::size_t>(count);
  }
  text.resize(got);
  return text;
}

IoResult<void> replace_file(const std::string& path, std::string_view text) {
  struct stat status{};
  const bool exists = ::stat(path.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) {
    return std::unexpected(IoError{path + ": is a folder, not a file"});
  }
  if (exists && !S_ISREG(status.st_mode)) return write_in_place(path, text);
  const std::string place = real_path(path);
  // A name of its own: a file that somebody else calls .new is not ours to overwrite.
  const std::string beside = place + "." + std::to_string(::getpid()) + ".new";
  {
    const Descriptor file{::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC,
                                 S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH)};
    if (file.value < 0) return std::unexpected(system_error(path, errno));
    int error = write_all(file.value, text);
    if (error == 0 && fsync(file.value) != 0) error = errno;
    if (error != 0) {
      ::unlink(beside.c_str());
      return std::unexpected(system_error(path, error));
    }
  }
  if (std::rename(beside.c_str(), place.c_str()) != 0) {
    const int error = errno;
    ::unlink(beside.c_str());
    return std::unexpected(system_error(path, error));
  }
  return {};
}

IoResult<FolderTurn> FolderTurn::take(const std::string& path, Duration patience) {
  const std::string folder = folder_of(path);
  // Close on exec, or a child would keep the turn.
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return std::unexpected(system_error(path, errno));
  FolderTurn turn(descriptor);
  const Clock clock;
  const Instant end = clock.now() + patience;
  while (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) return std::unexpected(system_error(path, errno));
    if (clock.now() > end) {
      return std::unexpected(
          IoError{path + ": another program changes files of that folder, and does not end"});
    }
    clock.pause(kTurnLook);
  }
  return turn;
}

FolderTurn::~FolderTurn() {
  if (folder_ >= 0) ::close(folder_);
}

IoResult<std::uint64_t> file_size(const std::string& path) {
  struct stat status{};
  if (::stat(path.c_str(), &status) != 0) return std::unexpected(system_error(path, errno));
  if (!S_ISREG(status.st_mode)) return std::unexpected(IoError{path + ": is no plain file"});
  return static_cast<std::uint64_t>(status.st_size);
}

bool is_file(const std::string& path) {
  struct stat status{};
  return ::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode);
}

IoResult<void> check_place(const std::string& path) {
  struct stat status{};
  if (::stat(path.c_str(), &status) == 0) {
    if (S_ISDIR(status.st_mode)) {
      return std::unexpected(IoError{path + ": is a folder, not a file"});
    }
    if (::access(path.c_str(), W_OK) == 0) return {};
    return std::unexpected(system_error(path, errno));
  }
  if (!path.empty() && ::access(folder_of(path).c_str(), W_OK) == 0) return {};
  return std::unexpected(system_error(path, path.empty() ? ENOENT : errno));
}

bool exists(const std::string& path) {
  struct stat status{};
  return ::lstat(path.c_str(), &status) == 0 || (errno != ENOENT && errno != ENOTDIR);
}

bool same_file(const std::string& a, const std::string& b) {
  struct stat status_a{};
  struct stat status_b{};
  const bool has_a = ::stat(a.c_str(), &status_a) == 0;
  const bool has_b = ::stat(b.c_str(), &status_b) == 0;
  if (has_a && has_b) {
    return status_a.st_dev == status_b.st_dev && status_a.st_ino == status_b.st_ino;
  }
  if (has_a || has_b) return false;
  const auto whole = [](const std::string& path) {
    std::error_code error;
    auto absolute = std::filesystem::absolute(path, error);
    const auto canonical = std::filesystem::weakly_canonical(absolute, error);
    return error ? absolute : canonical;
  };
  return whole(a) == whole(b);
}

IoResult<LineFile> LineFile::create(const std::string& path) {
  return open(path, "we");
}

IoResult<LineFile> LineFile::append(const std::string& path) {
  return open(path, "ae");
}

IoResult<LineFile> LineFile::open(const std::string& path, const char* mode) {
  std::FILE* file = std::fopen(path.c_str(), mode);
  if (file == nullptr) return std::unexpected(system_error(path, errno));
  return LineFile(file, path);
}

void LineFile::add(std::string_view line) {
  if (failure_) return;
  std::fwrite(line.data(), 1, line.size(), file_.get());
  std::fputc('\n', file_.get());
  if (std::fflush(file_.get()) != 0) failure_ = system_error(path_, errno);
}

IoResult<ScopedLink> ScopedLink::create(const std::string& target, const std::string& path) {
  const std::string lock_path = path + ".lock";
  const IoError in_use{path + ": is a link that is in use; remove it or choose another name"};
  struct stat status{};
  const bool is_there = lstat(path.c_str(), &status) == 0;
  if (is_there && !S_ISLNK(status.st_mode)) {
    return std::unexpected(IoError{path + ": exists and is not a link; choose another name"});
  }
  // A link to our own target dangled too until we came: pseudo-terminals get old names again.
  const bool leads_elsewhere =
      is_there && link_target(path) != target && ::access(path.c_str(), F_OK) == 0;
  const bool has_lock = ::access(lock_path.c_str(), F_OK) == 0;
  if (leads_elsewhere && !has_lock) return std::unexpected(in_use);
  auto lock = LockedFile::open(lock_path, 1);
  if (!lock) return std::unexpected(leads_elsewhere ? in_use : lock.error());
  if (is_there) ::unlink(path.c_str());
  if (::symlink(target.c_str(), path.c_str()) != 0) {
    const IoError error = system_error(path, errno);
    ::unlink(lock_path.c_str());
    return std::unexpected(error);
  }
  return ScopedLink(target, path, std::move(*lock));
}

ScopedLink::ScopedLink(ScopedLink&& other) noexcept
    : target_(std::move(other.target_)),
      path_(std::exchange(other.path_, {})),
      lock_(std::move(other.lock_)) {}

ScopedLink::~ScopedLink() {
  if (path_.empty()) return;
  // Somebody else's link by now: leave it.
  if (link_target(path_) == target_) ::unlink(path_.c_str());
  ::unlink(lock_.path().c_str());
}

std::string runtime_folder() {
  const char* folder = std::getenv("XDG_RUNTIME_DIR");
  const bool usable = folder != nullptr && ::access(folder, W_OK | X_OK) == 0;
  return usable ? folder : "/tmp";
}

int process_id() {
  return ::getpid();
}

}  // namespace sinew::io
