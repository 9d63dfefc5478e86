#include "sinew/io/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>

#include "sinew/io/clock.h"

extern char** environ;

namespace sinew::io {
namespace {

constexpr std::size_t kOutputMost = 64 << 10;
constexpr int kLook = 100;  // ms

/// Closed at the end of its life.
struct Descriptor {
  int number = -1;
  ~Descriptor() { close(); }
  void close() {
    if (number >= 0) ::close(number);
    number = -1;
  }
};

struct SpawnActions {
  SpawnActions() { posix_spawn_file_actions_init(&actions); }
  ~SpawnActions() { posix_spawn_file_actions_destroy(&actions); }
  posix_spawn_file_actions_t actions{};
};

struct SpawnAttributes {
  SpawnAttributes() { posix_spawnattr_init(&attributes); }
  ~SpawnAttributes() { posix_spawnattr_destroy(&attributes); }
  posix_spawnattr_t attributes{};
};

/// In a group of its own, with signals as a new program has them.
int spawn(const std::vector<std::string>& arguments, int output, pid_t& child) {
  SpawnActions files;
  posix_spawn_file_actions_addopen(&files.actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files.actions, output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files.actions, output, STDERR_FILENO);
  SpawnAttributes how;
  posix_spawnattr_setflags(&how.attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
  posix_spawnattr_setpgroup(&how.attributes, 0);
  sigset_t all;
  sigfillset(&all);
  posix_spawnattr_setsigdefault(&how.attributes, &all);
  std::vector<std::string> words = arguments;
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return posix_spawnp(&child, pointers[0], &files.actions, &how.attributes, pointers.data(),
                      environ);
}

int exit_of(int status) {
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// What it writes, until it has closed its output or the limit has passed.
void read_output(int from, Instant until, const Clock& clock, ProgramEnd& end,
                 const std::function<void(std::string_view)>& on_output) {
  std::array<char, 4096> piece{};
  while (clock.now() < until) {
    pollfd ready{from, POLLIN, 0};
    if (poll(&ready, 1, kLook) <= 0) continue;
    const ssize_t count = read(from, piece.data(), piece.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    const std::string_view text(piece.data(), static_cast<std::size_t>(count));
    if (on_output) on_output(text);
    end.output += text;
    if (end.output.size() > kOutputMost) end.output.erase(0, end.output.size() - kOutputMost);
  }
}

}  // namespace

bool has_program(const std::string& name) {
  if (name.contains('/')) return access(name.c_str(), X_OK) == 0;
  const char* const path = std::getenv("PATH");
  std::string_view rest = path != nullptr ? path : "/usr/bin:/bin";
  while (!rest.empty()) {
    const std::size_t length = std::min(rest.find(':'), rest.size());
    const std::string file = std::string(rest.substr(0, length)) + "/" + name;
    if (access(file.c_str(), X_OK) == 0) return true;
    rest.remove_prefix(std::min(length + 1, rest.size()));
  }
  return false;
}

IoResult<ProgramEnd> run_program(const std::vector<std::string>& arguments, Duration limit,
                                 const std::function<void(std::string_view)>& on_output) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    return std::unexpected(system_error(arguments[0], errno));
  }
  Descriptor from{ends[0]}, into{ends[1]};
  pid_t child = 0;
  if (const int error = spawn(arguments, into.number, child); error != 0) {
    return std::unexpected(system_error(arguments[0], error));
  }
  into.close();
  const Clock clock;
  const Instant until = clock.now() + limit;
  ProgramEnd end;
  read_output(from.number, until, clock, end, on_output);
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    // With all that it has begun.
    if (clock.now() >= until) kill(-child, SIGKILL);
    clock.pause(std::chrono::milliseconds(2));
  }
  end.exit = exit_of(status);
  return end;
}

}  // namespace sinew::io
