#include "cli/process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <stdexcept>

namespace sinew::test {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

int milliseconds_to(Clock::time_point limit) {
  const auto left = std::chrono::ceil<milliseconds>(limit - Clock::now()).count();
  return static_cast<int>(std::max<long>(left, 0));
}

/// In the child: `number` leads to where the test wants it.
void redirect(const std::string& where, int kept, int number) {
  if (where == "closed") {
    ::close(number);
    return;
  }
  const int place = where.empty() ? kept : ::open(where.c_str(), O_WRONLY | O_CREAT, 0600);
  if (place < 0) ::_exit(127);
  ::dup2(place, number);
}

}  // namespace

Json Ended::json() const {
  Json json = Json::parse(out, nullptr, false);
  if (!json.is_discarded()) return json;
  ADD_FAILURE() << "stdout is no JSON: " << out << "\nstderr: " << err;
  return nullptr;
}

bool Ended::was_late() const {
  if (exit != 1) return false;
  const Json report = Json::parse(out, nullptr, false);
  if (!report.is_object()) return false;
  const std::string stopped_by = report.value("stopped_by", "");
  if (stopped_by == "cycle_overrun" || stopped_by == "clock_gap") return true;
  if (!report.contains("refusal")) return false;
  const std::string code = report["refusal"].value("code", "");
  return code == "device_silent" || code == "cycle_overrun" || code == "clock_gap" ||
         code == "stream_ended" || code == "link_silent" ||
         // What answered too late is taken for the answer to something else.
         code == "device_refused";
}

Typed::Typed() {
  if (pipe2(ends_.data(), O_CLOEXEC) != 0) throw std::runtime_error("pipe");
}

Typed::~Typed() {
  end();
  ::close(ends_[0]);
}

void Typed::say(const std::string& text) const {
  EXPECT_EQ(::write(ends_[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
}

void Typed::end() {
  if (ends_[1] >= 0) ::close(ends_[1]);
  ends_[1] = -1;
}

Process::Process(const Arguments& arguments, const Streams& streams) {
  std::vector<std::string> words{SINEW_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::array<int, 2> out{};
  std::array<int, 2> err{};
  if (pipe2(out.data(), O_CLOEXEC) != 0 || pipe2(err.data(), O_CLOEXEC) != 0) {
    throw std::runtime_error("pipe");
  }
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork");
  if (pid_ == 0) {
    // What a test does not look for must not go among its user's own files.
    setenv("XDG_STATE_HOME", SINEW_TEST_STATE, 0);
    if (streams.in >= 0) ::dup2(streams.in, STDIN_FILENO);
    redirect(streams.out, out[1], STDOUT_FILENO);
    redirect(streams.err, err[1], STDERR_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  ::close(out[1]);
  ::close(err[1]);
  out_.file = out[0];
  err_.file = err[0];
}

Process::~Process() {
  if (pid_ > 0) {
    signal(SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  for (const Output* output : {&out_, &err_}) {
    if (output->file >= 0) ::close(output->file);
  }
}

void Process::signal(int number) const {
  if (pid_ > 0) kill(pid_, number);
}

bool Process::pump(Clock::time_point limit) {
  std::array<pollfd, 2> files{{{out_.file, POLLIN, 0}, {err_.file, POLLIN, 0}}};
  if (::poll(files.data(), files.size(), milliseconds_to(limit)) <= 0) return false;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (files[i].revents == 0) continue;
    Output& output = i == 0 ? out_ : err_;
    std::array<char, 4096> buffer{};
    const ssize_t count = ::read(output.file, buffer.data(), buffer.size());
    if (count > 0) {
      output.text.append(buffer.data(), static_cast<std::size_t>(count));
    } else {
      ::close(output.file);
      output.file = -1;
    }
  }
  return true;
}

void Process::wait_for(const Output& output, const std::string& text) {
  const auto limit = Clock::now() + std::chrono::seconds(10);
  while (output.text.find(text) == std::string::npos) {
    ASSERT_TRUE(output.file >= 0 && pump(limit))
        << "waited for '" << text << "', got: " << out_.text << err_.text;
  }
}

std::string Process::line_after(std::size_t position) {
  const auto limit = Clock::now() + std::chrono::seconds(10);
  while (out_.text.find('\n', position) == std::string::npos) {
    if (out_.file >= 0 && pump(limit)) continue;
    ADD_FAILURE() << "waited for a line, got: " << out_.text << err_.text;
    return {};
  }
  return out_.text.substr(position, out_.text.find('\n', position) - position);
}

void Process::let_run(std::chrono::milliseconds time) {
  const auto limit = Clock::now() + time;
  while ((out_.file >= 0 || err_.file >= 0) && pump(limit)) {
  }
}

Ended Process::end() {
  const auto limit = Clock::now() + std::chrono::seconds(300);
  bool late = false;
  while (!late && (out_.file >= 0 || err_.file >= 0)) late = !pump(limit);
  // Both streams may be elsewhere: only the process itself tells when it has ended.
  pollfd process{static_cast<int>(syscall(SYS_pidfd_open, pid_, 0)), POLLIN, 0};
  late = late || ::poll(&process, 1, milliseconds_to(limit)) <= 0;
  ::close(process.fd);
  if (late) {
    ADD_FAILURE() << "does not end; so far: " << out_.text << err_.text;
    signal(SIGKILL);
  }
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), out_.text, err_.text};
}

Ended sinew(const Arguments& arguments, const Streams& streams) {
  return Process(arguments, streams).end();
}

Json answer(Arguments arguments) {
  arguments.emplace_back("--json");
  const Ended ended = sinew(arguments);
  EXPECT_EQ(ended.exit, 0) << ended.err;
  EXPECT_EQ(ended.err, "");
  return ended.json();
}

}  // namespace sinew::test
