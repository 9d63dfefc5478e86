#include "cli/process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <stdexcept>
#include <thread>

namespace sinew::test {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kLook = std::chrono::milliseconds(1);

/// In the child: `number` leads to where the test wants it.
void redirect(const std::string& where, int kept, int number) {
  if (where == "closed") {
    ::close(number);
    return;
  }
  ::dup2(where.empty() ? kept : ::open(where.c_str(), O_WRONLY | O_CREAT, 0600), number);
}

}  // namespace

Json Ended::json() const {
  Json json = Json::parse(out, nullptr, false);
  if (!json.is_discarded()) return json;
  ADD_FAILURE() << "stdout is no JSON: " << out << "\nstderr: " << err;
  return nullptr;
}

Process::Process(const Arguments& arguments, const Streams& streams)
    : out_(memfd_create("stdout", MFD_CLOEXEC)), err_(memfd_create("stderr", MFD_CLOEXEC)) {
  std::vector<std::string> words{SINEW_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork");
  if (pid_ > 0) return;
  redirect(streams.out, out_, STDOUT_FILENO);
  redirect(streams.err, err_, STDERR_FILENO);
  execv(argv[0], argv.data());
  _exit(127);
}

Process::~Process() {
  if (pid_ > 0) {
    signal(SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  ::close(out_);
  ::close(err_);
}

void Process::signal(int number) const {
  if (pid_ > 0) kill(pid_, number);
}

std::string Process::text_of(int file) {
  std::string text;
  std::array<char, 4096> buffer{};
  while (true) {
    const ssize_t count =
        pread(file, buffer.data(), buffer.size(), static_cast<off_t>(text.size()));
    if (count <= 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

void Process::wait_for(int file, const std::string& text) const {
  const auto limit = Clock::now() + std::chrono::seconds(10);
  while (text_of(file).find(text) == std::string::npos) {
    ASSERT_LT(Clock::now(), limit) << "waited for '" << text << "', got: " << out() << err();
    std::this_thread::sleep_for(kLook);
  }
}

Ended Process::end() {
  const auto limit = Clock::now() + std::chrono::seconds(20);
  int status = 0;
  while (waitpid(pid_, &status, WNOHANG) == 0) {
    if (Clock::now() > limit) {
      ADD_FAILURE() << "does not end; so far: " << out() << err();
      signal(SIGKILL);
    }
    std::this_thread::sleep_for(kLook);
  }
  pid_ = -1;
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), out(), err()};
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
