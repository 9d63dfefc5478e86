#include "sinew/io/request_lines.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace sinew::io {
namespace {

constexpr std::size_t kLineMax = 1000;

}  // namespace

std::optional<std::string> RequestLines::next() {
  while (true) {
    const std::size_t end = pending_.find('\n');
    if (end != std::string::npos) {
      std::string line = pending_.substr(0, end);
      pending_.erase(0, end + 1);
      return line;
    }
    if (pending_.size() > kLineMax) pending_.clear();
    // What is typed for the shell is not ours, and reading it would suspend us.
    const bool not_ours = ::isatty(STDIN_FILENO) == 1 && ::tcgetpgrp(STDIN_FILENO) != ::getpgrp();
    pollfd waiting{STDIN_FILENO, POLLIN, 0};
    if (ended_ || not_ours || ::poll(&waiting, 1, 0) <= 0) return std::nullopt;
    char buffer[256];
    const ssize_t size = ::read(STDIN_FILENO, buffer, sizeof buffer);
    if (size < 0 && (errno == EINTR || errno == EAGAIN)) return std::nullopt;
    if (size <= 0) {
      ended_ = true;
      // The last line need not end with a line feed.
      return pending_.empty() ? std::nullopt : std::optional(std::exchange(pending_, {}));
    }
    pending_.append(buffer, static_cast<std::size_t>(size));
  }
}

}  // namespace sinew::io
