#include "sinew/io/private_file.h"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <system_error>

namespace sinew::io {
namespace {

struct Descriptor {
  int value = -1;
  ~Descriptor() {
    if (value >= 0) ::close(value);
  }
};

/// Whole under its name, or not at all.
IoResult<void> make(const std::string& path, const std::string& text) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  std::error_code failed;
  const bool made = std::filesystem::create_directories(folder, failed);
  if (failed) return std::unexpected(system_error(folder, failed.value()));
  if (made) ::chmod(folder.c_str(), S_IRWXU);
  const std::string beside = path + "." + std::to_string(::getpid()) + ".new";
  const Descriptor file{
      ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR)};
  if (file.value < 0) return std::unexpected(system_error(beside, errno));
  int error = 0;
  const ssize_t count = ::write(file.value, text.data(), text.size());
  if (count < 0) error = errno;
  if (error == 0 && static_cast<std::size_t>(count) != text.size()) error = ENOSPC;
  if (error == 0 && ::fsync(file.value) != 0) error = errno;
  // A link, unlike a rename, leaves what another process was quicker to put there.
  if (error == 0 && ::link(beside.c_str(), path.c_str()) != 0 && errno != EEXIST) error = errno;
  ::unlink(beside.c_str());
  if (error != 0) return std::unexpected(system_error(path, error));
  return {};
}

}  // namespace

IoResult<void> fill_unguessable(std::span<std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::getrandom(bytes.data(), bytes.size(), 0);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return std::unexpected(system_error("the kernel's randomness", errno));
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return {};
}

IoResult<std::string> keep_private(const std::string& path, const std::string& fresh) {
  const auto open = [&] {
    return ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  };
  Descriptor file{open()};
  if (file.value < 0 && errno == ENOENT) {
    if (auto made = make(path, fresh); !made) return std::unexpected(made.error());
    file.value = open();
  }
  if (file.value < 0) return std::unexpected(system_error(path, errno));
  struct stat status{};
  if (::fstat(file.value, &status) != 0) return std::unexpected(system_error(path, errno));
  if (!S_ISREG(status.st_mode) || status.st_uid != ::geteuid()) {
    return std::unexpected(IoError{path + ": is no plain file of this user"});
  }
  if ((status.st_mode & 0077) != 0) {
    return std::unexpected(
        IoError{path + ": others may read it, so it is no secret any more; delete it, and a new "
                       "one is made"});
  }
  std::array<char, 4096> text;
  const ssize_t count = ::read(file.value, text.data(), text.size());
  if (count < 0) return std::unexpected(system_error(path, errno));
  return std::string(text.data(), static_cast<std::size_t>(count));
}

}  // namespace sinew::io
