#include "sinew/io/child_process.h"

#include <gtest/gtest.h>

#include <csignal>

#include "sinew/io/clock.h"

namespace sinew::io {
namespace {

using namespace std::chrono_literals;

TEST(ChildProcess, gives_its_exit_and_all_that_it_wrote) {
  std::string seen;
  const auto end = run_program({"sh", "-c", "echo one; echo two >&2; exit 7"}, 10s,
                               [&](std::string_view text) { seen += text; });
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit, 7);
  EXPECT_EQ(end->output, "one\ntwo\n");
  EXPECT_EQ(seen, end->output);
}

TEST(ChildProcess, words_reach_it_as_they_are_and_stdin_is_empty) {
  const auto end =
      run_program({"sh", "-c", "cat; printf '%s|' \"$@\"", "sh", "a b", "$x", ""}, 10s);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->output, "a b|$x||");
}

TEST(ChildProcess, one_that_is_not_there_is_an_error_that_names_it) {
  EXPECT_FALSE(has_program("no-such-program-of-ours"));
  EXPECT_TRUE(has_program("sh"));
  EXPECT_TRUE(has_program("/bin/sh"));
  const auto end = run_program({"no-such-program-of-ours"}, 10s);
  ASSERT_FALSE(end);
  EXPECT_TRUE(end.error().sentence.contains("no-such-program-of-ours")) << end.error().sentence;
}

TEST(ChildProcess, one_that_takes_too_long_is_ended_with_what_it_has_begun) {
  const Clock clock;
  const auto end = run_program({"sh", "-c", "echo begun; sleep 60 & sleep 60"}, 300ms);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->exit, 128 + SIGKILL);
  EXPECT_EQ(end->output, "begun\n");
  EXPECT_LT(clock.now() - Instant{}, 20s);
}

TEST(ChildProcess, of_very_much_output_the_end_is_kept) {
  const auto end = run_program({"sh", "-c", "seq 100000; echo last"}, 20s);
  ASSERT_TRUE(end);
  EXPECT_LE(end->output.size(), std::size_t{64} << 10);
  EXPECT_TRUE(end->output.ends_with("99999\n100000\nlast\n"));
}

}  // namespace
}  // namespace sinew::io
