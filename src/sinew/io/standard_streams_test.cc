#include "sinew/io/standard_streams.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>

#include "sinew/io/interrupt.h"

namespace sinew::io {
namespace {

/// Runs `body` in a process of its own; its exit code.
template <class Body>
int in_child(const Body& body) {
  const pid_t child = fork();
  if (child == 0) _exit(body());
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST(StandardStreams, closed_ones_are_taken_so_that_no_port_gets_their_numbers) {
  EXPECT_EQ(in_child([] {
              for (const int descriptor : {0, 1, 2}) ::close(descriptor);
              hold_standard_streams();
              return ::open("/dev/null", O_RDWR) > STDERR_FILENO ? 0 : 1;
            }),
            0);
}

TEST(StandardStreams, closed_or_full_stdout_is_told) {
  EXPECT_EQ(in_child([] {
              ::close(1);
              hold_standard_streams();
              const auto written = write_stdout("x");
              return !written && written.error().sentence == "standard output: bad file descriptor"
                         ? 0
                         : 1;
            }),
            0);
  EXPECT_EQ(in_child([] {
              ::dup2(::open("/dev/full", O_WRONLY), 1);
              return write_stdout("x") ? 1 : 0;
            }),
            0);
}

TEST(StandardStreams, reader_that_went_away_is_an_error_and_not_the_end) {
  EXPECT_EQ(in_child([] {
              std::array<int, 2> ends{};
              if (::pipe(ends.data()) != 0) return 2;
              ::dup2(ends[1], 1);
              ::close(ends[0]);
              hold_standard_streams();
              return write_stdout("x") ? 1 : 0;
            }),
            0);
}

TEST(Interrupts, each_signal_counts_and_none_kills) {
  EXPECT_EQ(in_child([] {
              catch_interrupts();
              if (interrupts() != 0) return 10;
              for (const int signal : {SIGINT, SIGTERM, SIGTERM, SIGHUP}) std::raise(signal);
              for (int i = 0; i < 2; ++i) std::raise(SIGINT);
              return interrupts();
            }),
            5)
      << "SIGTERM twice in a row is one wish";
}

}  // namespace
}  // namespace sinew::io
