#include "firmware/emulation_stm8/ucsim.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <stdexcept>

namespace sinew::emulation {
namespace {

using Pipe = std::array<int, 2>;

constexpr int kPatienceMs = 20'000;
/// An expression and what it prints: everything before it has been answered. The console prints
/// commands too.
constexpr std::string_view kMark = "199900990+1";
constexpr std::string_view kMarked = "\n199900991\n";
/// What a stop prints: its reason first, in parentheses, and a line at the end.
constexpr std::string_view kStop = "\nStop at 0x";
constexpr std::string_view kStopEnd = "Host usage:";
/// An event break. Ours run on by themselves; later versions print them all the same.
constexpr std::string_view kRunsOn = "(112)";

/// `text` has a stop from `from` on that does not run on. `from` becomes where to look next time.
bool has_stopped(std::string_view text, std::size_t& from) {
  for (;;) {
    const std::size_t stop = text.find(kStop, from);
    if (stop == std::string_view::npos) {
      from = std::max(from, text.size() - std::min(text.size(), kStop.size()));
      return false;
    }
    from = stop;
    const std::size_t end = text.find(kStopEnd, stop);
    if (end == std::string_view::npos) return false;
    const std::string_view reason = text.substr(text.find('(', stop), kRunsOn.size());
    if (reason != kRunsOn) return true;
    from = end;
  }
}

Pipe make_pipe() {
  Pipe ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error("pipe");
  return ends;
}

/// In the child. The UART reads a file: its end of a pipe, by name.
[[noreturn]] void become_emulator(const std::string& image, int in, int out, int uart) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::dup2(in, STDIN_FILENO);
  ::dup2(out, STDOUT_FILENO);
  ::dup2(out, STDERR_FILENO);
  // A copy that stays open over exec.
  const std::string port = "uart=1,in=/dev/fd/" + std::to_string(::dup(uart));
  execlp(SINEW_UCSIM, SINEW_UCSIM, "-t", "S103", "-b", "-S", port.c_str(), image.c_str(), nullptr);
  _exit(127);
}

}  // namespace

Ucsim::Ucsim(const std::string& image) {
  // An emulator that ended is an exception, not the end of the test.
  std::signal(SIGPIPE, SIG_IGN);
  const Pipe in = make_pipe();
  const Pipe out = make_pipe();
  const Pipe uart = make_pipe();
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork");
  if (pid_ == 0) become_emulator(image, in[0], out[1], uart[0]);
  for (const int end : {in[0], out[1], uart[0]}) ::close(end);
  in_ = in[1];
  out_ = out[0];
  uart_ = uart[1];
}

Ucsim::~Ucsim() {
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  for (const int end : {in_, out_, uart_}) ::close(end);
}

std::string Ucsim::command(std::string_view lines) {
  // No empty lines: they repeat the command before.
  while (lines.starts_with('\n')) lines.remove_prefix(1);
  while (lines.ends_with('\n')) lines.remove_suffix(1);
  write(std::string(lines) + "\n" + std::string(kMark) + "\n");
  std::string text;
  while (text.find(kMarked) == std::string::npos) text += read();
  return text;
}

std::string Ucsim::run(std::uint64_t clocks) {
  write("step " + std::to_string(clocks) + " clk\n");
  std::string text;
  for (std::size_t from = 0; !has_stopped(text, from);) text += read();
  return text;
}

void Ucsim::send_uart(std::string_view bytes) const {
  if (::write(uart_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
    throw std::runtime_error("the emulator's UART takes nothing");
  }
}

void Ucsim::write(std::string_view text) const {
  if (::write(in_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    throw std::runtime_error("the emulator takes no commands");
  }
}

std::string Ucsim::read() const {
  pollfd file{out_, POLLIN, 0};
  if (::poll(&file, 1, kPatienceMs) <= 0) throw std::runtime_error("the emulator hangs");
  std::array<char, 65536> buffer{};
  const ssize_t count = ::read(out_, buffer.data(), buffer.size());
  if (count <= 0) throw std::runtime_error("the emulator ended");
  return {buffer.data(), static_cast<std::size_t>(count)};
}

}  // namespace sinew::emulation
