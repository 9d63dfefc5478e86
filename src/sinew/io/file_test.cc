#include "sinew/io/file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <thread>

#include "support/scratch_folder.h"

namespace sinew::io {
namespace {

using Names = std::vector<std::string>;

/// Root may read and write everything; the rest of us is what such tests are about.
class AsNobody {
 public:
  AsNobody() : was_root_(geteuid() == 0) {
    if (was_root_) {
      EXPECT_EQ(seteuid(65534), 0);
    }
  }
  ~AsNobody() {
    if (was_root_) {
      EXPECT_EQ(seteuid(0), 0);
    }
  }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  bool was_root_;
};

template <class Result>
std::string refusal(const Result& result) {
  return result ? "accepted" : result.error().sentence;
}

TEST(ReadPart, gives_what_there_is_of_it) {
  const test::ScratchFolder folder;
  const std::string file = folder.file("a", "0123456789");
  EXPECT_EQ(read_part(file, 0, 4), "0123");
  EXPECT_EQ(read_part(file, 8, 4), "89");
  EXPECT_EQ(read_part(file, 10, 4), "");
  EXPECT_EQ(read_part(file, ~std::uint64_t{0}, 4), "");
  EXPECT_EQ(refusal(read_part(folder.at("b"), 0, 4)),
            folder.at("b") + ": no such file or directory");
  EXPECT_EQ(refusal(read_part(folder.at(), 0, 4)), folder.at() + ": is no plain file");
}

TEST(ReadFile, gives_every_byte_back) {
  const test::ScratchFolder folder;
  std::string bytes;
  for (int i = 0; i < 70'000; ++i) bytes += static_cast<char>(i);
  EXPECT_EQ(read_file(folder.file("a", bytes)), bytes);
  EXPECT_EQ(read_file(folder.file("empty", "")), "");
}

TEST(ReadFile, stops_at_the_limit_and_says_so) {
  const test::ScratchFolder folder;
  const std::string path = folder.file("a", "12345678");
  EXPECT_EQ(read_file(path, 8), "12345678");
  EXPECT_EQ(refusal(read_file(path, 7)), path + ": larger than 7 bytes");
}

TEST(ReadFile, refuses_what_is_no_file_with_its_name) {
  const test::ScratchFolder folder;
  EXPECT_EQ(refusal(read_file(folder.at())), folder.at() + ": is a folder, not a file");
  EXPECT_EQ(refusal(read_file(folder.at("b"))), folder.at("b") + ": no such file or directory");
  EXPECT_EQ(refusal(read_file("")), "'': no such file or directory");
  EXPECT_EQ(refusal(read_file("/dev/zero")), "/dev/zero: is a device, not a file");
  const std::string secret = folder.file("secret", "x");
  ASSERT_EQ(chmod(secret.c_str(), 0), 0);
  ASSERT_EQ(chmod(folder.at().c_str(), 0755), 0);
  const AsNobody nobody;
  EXPECT_EQ(refusal(read_file(secret)), secret + ": permission denied");
}

TEST(ReadFile, waits_for_the_writer_of_a_pipe_but_not_for_one_that_never_comes) {
  const test::ScratchFolder folder;
  const std::string path = folder.at("pipe");
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_EQ(refusal(read_file(path)), path + ": nobody writes to this pipe");

  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  std::thread writer([&] {
    for (const char letter : {'a', 'b'}) {
      // The reader finds the pipe empty and open before each of them.
      int waiting = 1;
      while (waiting > 0) EXPECT_EQ(ioctl(ends[0], FIONREAD, &waiting), 0);
      EXPECT_EQ(::write(ends[1], &letter, 1), 1);
    }
    ::close(ends[1]);
  });
  EXPECT_EQ(read_file("/proc/self/fd/" + std::to_string(ends[0])), "ab");
  writer.join();
  ::close(ends[0]);
}

TEST(ReplaceFile, swaps_the_text_in_one_step) {
  const test::ScratchFolder folder;
  const std::string path = folder.file("a", "old");
  const int reader = ::open(path.c_str(), O_RDONLY);
  ASSERT_TRUE(replace_file(path, "new and longer"));
  std::array<char, 16> buffer{};
  // Who had it open before still sees the old text, whole.
  EXPECT_EQ(::read(reader, buffer.data(), buffer.size()), 3);
  EXPECT_STREQ(buffer.data(), "old");
  ::close(reader);
  EXPECT_EQ(test::text_of(path), "new and longer");
  EXPECT_EQ(folder.names(), Names{"a"});
}

TEST(ReplaceFile, failure_leaves_the_old_text_and_nothing_else) {
  const test::ScratchFolder folder;
  EXPECT_EQ(refusal(replace_file(folder.at(), "x")), folder.at() + ": is a folder, not a file");
  EXPECT_EQ(refusal(replace_file(folder.at("no/a"), "x")),
            folder.at("no/a") + ": no such file or directory");
  EXPECT_EQ(folder.names(), Names{});

  const std::string path = folder.file("a", "old");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{.rlim_cur = 100, .rlim_max = before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto written = replace_file(path, std::string(1000, 'x'));
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(refusal(written), path + ": file too large");
  EXPECT_EQ(test::text_of(path), "old");
  EXPECT_EQ(folder.names(), Names{"a"});
}

TEST(ReplaceFile, somebody_elses_file_called_new_is_left_alone) {
  const test::ScratchFolder folder;
  const std::string other = folder.file("a.new", "theirs");
  ASSERT_TRUE(replace_file(folder.at("a"), "mine"));
  EXPECT_EQ(test::text_of(other), "theirs");
}

TEST(ReplaceFile, link_keeps_pointing_and_its_target_is_replaced) {
  const test::ScratchFolder folder;
  const std::string target = folder.file("target", "old");
  const std::string link = folder.at("link");
  ASSERT_EQ(symlink("target", link.c_str()), 0);
  ASSERT_TRUE(replace_file(link, "new"));
  EXPECT_EQ(test::text_of(target), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(link));
}

TEST(ReplaceFile, devices_are_written_to_and_never_replaced) {
  const test::ScratchFolder folder;
  const std::string full = folder.at("full");
  ASSERT_EQ(symlink("/dev/full", full.c_str()), 0);
  EXPECT_EQ(refusal(replace_file(full, "x")), full + ": no space left on device");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
  const std::string null = folder.at("null");
  ASSERT_EQ(symlink("/dev/null", null.c_str()), 0);
  EXPECT_TRUE(replace_file(null, "x"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  EXPECT_EQ(folder.names().size(), 2U);
}

TEST(CheckPlace, tells_before_the_run_what_would_fail_after_it) {
  const test::ScratchFolder folder;
  EXPECT_TRUE(check_place(folder.at("new")));
  EXPECT_TRUE(check_place(folder.file("old", "x")));
  EXPECT_TRUE(check_place("/dev/null"));
  EXPECT_EQ(test::text_of(folder.at("old")), "x");
  EXPECT_EQ(folder.names(), Names{"old"});
  EXPECT_EQ(refusal(check_place(folder.at())), folder.at() + ": is a folder, not a file");
  EXPECT_EQ(refusal(check_place(folder.at("no/a"))),
            folder.at("no/a") + ": no such file or directory");
  EXPECT_EQ(refusal(check_place("")), "'': no such file or directory");
}

TEST(FolderTurn, is_had_by_one_at_a_time_and_handed_on) {
  const test::ScratchFolder folder;
  const std::string path = folder.at("points.toml");
  auto first = FolderTurn::take(path, std::chrono::milliseconds(0));
  ASSERT_TRUE(first) << first.error().sentence;
  const auto second = FolderTurn::take(folder.at("other.toml"), std::chrono::milliseconds(20));
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().sentence.find("another program"), std::string::npos)
      << second.error().sentence;
  {
    const FolderTurn ends = std::move(*first);
  }
  EXPECT_TRUE(FolderTurn::take(path, std::chrono::milliseconds(0)));
  EXPECT_FALSE(FolderTurn::take(folder.at("no/such.toml"), std::chrono::milliseconds(0)));
}

TEST(SameFile, sees_through_links_dots_and_names_that_are_not_there_yet) {
  const test::ScratchFolder folder;
  const std::string a = folder.file("a", "");
  const std::string b = folder.file("b", "");
  ASSERT_EQ(symlink("a", folder.at("link").c_str()), 0);
  EXPECT_TRUE(same_file(a, a));
  EXPECT_TRUE(same_file(a, folder.at("./a")));
  EXPECT_TRUE(same_file(a, folder.at("link")));
  EXPECT_FALSE(same_file(a, b));
  EXPECT_FALSE(same_file(a, folder.at("c")));
  EXPECT_TRUE(same_file(folder.at("c"), folder.at("x/../c")));
  EXPECT_FALSE(same_file(folder.at("c"), folder.at("d")));
  EXPECT_TRUE(same_file("not there yet", "./not there yet"));
}

TEST(LineFile, each_line_is_out_as_soon_as_it_is_added) {
  const test::ScratchFolder folder;
  auto file = LineFile::create(folder.file("log", "of the run before"));
  ASSERT_TRUE(file);
  EXPECT_EQ(test::text_of(folder.at("log")), "");
  file->add("one");
  EXPECT_EQ(test::text_of(folder.at("log")), "one\n");
  file->add("");
  EXPECT_EQ(test::text_of(folder.at("log")), "one\n\n");
  EXPECT_FALSE(file->failure());
}

TEST(LineFile, full_disk_is_told) {
  auto file = LineFile::create("/dev/full");
  ASSERT_TRUE(file);
  file->add("one");
  file->add("two");
  ASSERT_TRUE(file->failure());
  EXPECT_EQ(file->failure()->sentence, "/dev/full: no space left on device");
  EXPECT_EQ(refusal(LineFile::create("/no/where")), "/no/where: no such file or directory");
}

TEST(ScopedLink, lives_as_long_as_its_object) {
  const test::ScratchFolder folder;
  const std::string path = folder.at("link");
  {
    auto link = ScopedLink::create("/dev/null", path);
    ASSERT_TRUE(link);
    const ScopedLink moved = std::move(*link);
    EXPECT_EQ(std::filesystem::read_symlink(path), "/dev/null");
  }
  EXPECT_EQ(folder.names(), Names{});
}

TEST(ScopedLink, replaces_a_dangling_link_and_nothing_else) {
  const test::ScratchFolder folder;
  const std::string dangling = folder.at("dangling");
  ASSERT_EQ(symlink("/no/such/port", dangling.c_str()), 0);
  EXPECT_TRUE(ScopedLink::create("/dev/null", dangling));

  // The name of a killed run's port may be that of the new run's port.
  const std::string same = folder.at("same");
  ASSERT_EQ(symlink("/dev/null", same.c_str()), 0);
  EXPECT_TRUE(ScopedLink::create("/dev/null", same));

  const std::string file = folder.file("file", "x");
  EXPECT_EQ(refusal(ScopedLink::create("/dev/null", file)),
            file + ": exists and is not a link; choose another name");
  EXPECT_EQ(test::text_of(file), "x");
  EXPECT_EQ(refusal(ScopedLink::create("/dev/null", folder.at())),
            folder.at() + ": exists and is not a link; choose another name");

  const std::string used = folder.at("used");
  ASSERT_EQ(symlink("/dev/zero", used.c_str()), 0);
  EXPECT_EQ(refusal(ScopedLink::create("/dev/null", used)),
            used + ": is a link that is in use; remove it or choose another name");
  EXPECT_EQ(std::filesystem::read_symlink(used), "/dev/zero");
  EXPECT_EQ(refusal(ScopedLink::create("/dev/null", folder.at("no/link"))),
            folder.at("no/link.lock") + ": no such file or directory");
}

/// The port that a killed run's link points at may be another program's by now.
TEST(ScopedLink, replaces_what_a_killed_run_left_and_no_running_one) {
  const test::ScratchFolder folder;
  const std::string path = folder.at("link");
  folder.file("link.lock", "x");
  ASSERT_EQ(symlink("/dev/zero", path.c_str()), 0);
  {
    const auto link = ScopedLink::create("/dev/null", path);
    ASSERT_TRUE(link);
    EXPECT_EQ(std::filesystem::read_symlink(path), "/dev/null");
    EXPECT_EQ(refusal(ScopedLink::create("/dev/full", path)),
              path + ": is a link that is in use; remove it or choose another name");
  }
  EXPECT_EQ(folder.names(), Names{});
}

TEST(ScopedLink, removes_only_its_own) {
  const test::ScratchFolder folder;
  const std::string path = folder.at("link");
  {
    const auto link = ScopedLink::create("/dev/null", path);
    ASSERT_TRUE(link);
    std::filesystem::remove(path);
    ASSERT_EQ(symlink("/dev/zero", path.c_str()), 0);
  }
  EXPECT_EQ(std::filesystem::read_symlink(path), "/dev/zero");
}

}  // namespace
}  // namespace sinew::io
