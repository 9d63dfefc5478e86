#include "sinew/io/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <utility>

namespace sinew::io {
namespace {

struct Descriptor {
  int value = -1;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(descriptor, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace

IoResult<std::string> read_file(const std::string& path, std::size_t size_max) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (file.value < 0) return std::unexpected(system_error(path, errno));
  struct stat status{};
  if (fstat(file.value, &status) != 0) return std::unexpected(system_error(path, errno));
  if (S_ISDIR(status.st_mode)) return std::unexpected(IoError{path + ": is a folder, not a file"});
  std::string text;
  std::array<char, 65536> buffer;
  while (true) {
    const ssize_t count = ::read(file.value, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return std::unexpected(system_error(path, errno));
    if (count == 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(count));
    if (text.size() > size_max) {
      return std::unexpected(
          IoError{path + ": larger than " + std::to_string(size_max) + " bytes"});
    }
  }
}

IoResult<void> replace_file(const std::string& path, std::string_view text) {
  const std::string beside = path + ".new";
  {
    const Descriptor file{::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
    if (file.value < 0) return std::unexpected(system_error(path, errno));
    if (!write_all(file.value, text) || fsync(file.value) != 0) {
      const int error = errno;
      ::unlink(beside.c_str());
      return std::unexpected(system_error(path, error));
    }
  }
  if (std::rename(beside.c_str(), path.c_str()) != 0) {
    const int error = errno;
    ::unlink(beside.c_str());
    return std::unexpected(system_error(path, error));
  }
  return {};
}

IoResult<LineFile> LineFile::create(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "we");
  if (file == nullptr) return std::unexpected(system_error(path, errno));
  return LineFile(file);
}

void LineFile::add(std::string_view line) {
  std::fwrite(line.data(), 1, line.size(), file_.get());
  std::fputc('\n', file_.get());
  std::fflush(file_.get());
}

IoResult<ScopedLink> ScopedLink::create(const std::string& target, const std::string& path) {
  struct stat status{};
  if (lstat(path.c_str(), &status) == 0) {
    if (!S_ISLNK(status.st_mode)) {
      return std::unexpected(IoError{path + ": exists and is not a link; nothing was replaced"});
    }
    if (::access(path.c_str(), F_OK) == 0) {
      return std::unexpected(IoError{path + ": is a link that is in use; remove it or choose "
                                            "another name"});
    }
    ::unlink(path.c_str());
  }
  if (::symlink(target.c_str(), path.c_str()) != 0) {
    return std::unexpected(system_error(path, errno));
  }
  return ScopedLink(target, path);
}

ScopedLink::ScopedLink(ScopedLink&& other) noexcept
    : target_(std::move(other.target_)), path_(std::exchange(other.path_, {})) {}

ScopedLink::~ScopedLink() {
  if (path_.empty()) return;
  // Somebody else's link by now: leave it.
  std::array<char, PATH_MAX> buffer{};
  const ssize_t length = ::readlink(path_.c_str(), buffer.data(), buffer.size() - 1);
  if (length >= 0 && target_ == buffer.data()) ::unlink(path_.c_str());
}

}  // namespace sinew::io
