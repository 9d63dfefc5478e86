#include "sinew/io/locked_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace sinew::io {

IoResult<LockedFile> LockedFile::open(const std::string& path, std::size_t size) {
  const auto refuse = [&](const char* what) {
    return std::unexpected(IoError{path + ": " + what});
  };
  // A pipe would keep open() waiting.
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0644);
  if (file < 0) return std::unexpected(system_error(path, errno));
  LockedFile result(path, file);
  struct stat status{};
  if (::fstat(file, &status) != 0) return std::unexpected(system_error(path, errno));
  if (!S_ISREG(status.st_mode)) return refuse("not a plain file");
  if (::flock(file, LOCK_EX | LOCK_NB) != 0) {
    return errno == EWOULDBLOCK ? IoResult<LockedFile>(refuse("in use by another process"))
                                : std::unexpected(system_error(path, errno));
  }
  if (status.st_size != 0 && status.st_size != static_cast<off_t>(size)) {
    return refuse("damaged, or not such a file: its size is wrong");
  }
  if (const int error = ::posix_fallocate(file, 0, static_cast<off_t>(size)); error != 0) {
    return std::unexpected(system_error(path, error));
  }
  return result;
}

LockedFile::~LockedFile() {
  if (file_ >= 0) ::close(file_);
}

IoResult<void> LockedFile::read(std::size_t offset, std::span<char> out) const {
  while (!out.empty()) {
    const ssize_t count = ::pread(file_, out.data(), out.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return std::unexpected(system_error(path_, count < 0 ? errno : EIO));
    out = out.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::size_t>(count);
  }
  return {};
}

IoResult<void> LockedFile::write(std::size_t offset, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::pwrite(file_, text.data(), text.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return std::unexpected(system_error(path_, count < 0 ? errno : EIO));
    text.remove_prefix(static_cast<std::size_t>(count));
    offset += static_cast<std::size_t>(count);
  }
  return {};
}

IoResult<void> LockedFile::sync() {
  if (::fsync(file_) != 0) return std::unexpected(system_error(path_, errno));
  return {};
}

}  // namespace sinew::io
