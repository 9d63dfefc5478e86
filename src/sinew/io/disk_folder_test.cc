#include "sinew/io/disk_folder.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <ctime>
#include <memory>

#include "support/scratch_folder.h"

namespace sinew::io {
namespace {

using Bytes = std::vector<std::uint8_t>;

DiskFolder folder_at(const std::string& path) {
  auto folder = DiskFolder::open_folder(path);
  EXPECT_TRUE(folder);
  return std::move(*folder);
}

DiskErrorCode code(const auto& result) {
  EXPECT_FALSE(result);
  return result ? DiskErrorCode{} : result.error().code;
}

TEST(DiskFolder, files_grow_and_are_read_whole) {
  const test::ScratchFolder scratch;
  DiskFolder disk = folder_at(scratch.at("state/robot"));
  const DiskFile file = *disk.create("a");
  EXPECT_TRUE(disk.append(file, Bytes{1, 2}));
  EXPECT_TRUE(disk.sync(file));
  EXPECT_TRUE(disk.sync_folder());
  disk.close(file);
  const DiskFile again = *disk.open("a");
  EXPECT_TRUE(disk.append(again, Bytes{3}));
  disk.close(again);
  Bytes out(4);
  EXPECT_EQ(disk.read("a", out), 3U);
  EXPECT_EQ(out, (Bytes{1, 2, 3, 0}));
  Bytes exact(3);
  EXPECT_EQ(disk.read("a", exact), 3U);
  const DiskFile over = *disk.open("a");
  EXPECT_TRUE(disk.write(over, 1, Bytes{9}));
  EXPECT_TRUE(disk.append(over, Bytes{4}));
  EXPECT_TRUE(disk.write(over, 5, Bytes{6}));
  disk.close(over);
  Bytes whole(6);
  EXPECT_EQ(disk.read("a", whole), 6U);
  EXPECT_EQ(whole, (Bytes{1, 9, 3, 4, 0, 6}));
  Bytes small(2);
  EXPECT_EQ(code(disk.read("a", small)), DiskErrorCode::kTooLarge);
  const DiskFile anew = *disk.create("a");
  EXPECT_EQ(disk.stamp("a")->size, 0U);
  disk.close(anew);
}

TEST(DiskFolder, names_move_at_once_and_are_listed_sorted) {
  const test::ScratchFolder scratch;
  DiskFolder disk = folder_at(scratch.at());
  scratch.file("b", "old");
  scratch.file("a", "new");
  const DiskStamp stamp = *disk.stamp("a");
  EXPECT_TRUE(disk.rename("a", "b"));
  EXPECT_EQ(test::text_of(scratch.at("b")), "new");
  EXPECT_EQ(disk.stamp("b")->identity, stamp.identity);
  scratch.file("a", "");
  EXPECT_EQ(disk.list(), (std::vector<std::string>{"a", "b"}));
  EXPECT_TRUE(disk.remove("a"));
  EXPECT_EQ(disk.list(), std::vector<std::string>{"b"});
}

TEST(DiskFolder, stamp_tells_another_file_of_the_same_name_and_a_later_change) {
  const test::ScratchFolder scratch;
  DiskFolder disk = folder_at(scratch.at());
  scratch.file("a", "1");
  const DiskStamp first = *disk.stamp("a");
  scratch.file("copy", "1");
  ASSERT_TRUE(disk.rename("copy", "a"));
  EXPECT_NE(disk.stamp("a")->identity, first.identity);
  // The time of change follows the wall clock even where a copy sets the others back.
  const std::array<timespec, 2> past{timespec{1, 0}, timespec{1, 0}};
  ASSERT_EQ(utimensat(AT_FDCWD, scratch.at("a").c_str(), past.data(), 0), 0);
  EXPECT_GE(disk.stamp("a")->changed_ns, first.changed_ns);
}

TEST(DiskFolder, refusals_have_their_kind) {
  const test::ScratchFolder scratch;
  DiskFolder disk = folder_at(scratch.at());
  EXPECT_EQ(code(disk.open("no")), DiskErrorCode::kMissing);
  EXPECT_EQ(code(disk.stamp("no")), DiskErrorCode::kMissing);
  EXPECT_EQ(code(disk.remove("no")), DiskErrorCode::kMissing);
  EXPECT_EQ(code(disk.rename("no", "a")), DiskErrorCode::kMissing);
  for (const char* bad : {"", ".", "..", "../a", "a/b"}) {
    EXPECT_EQ(code(disk.create(bad)), DiskErrorCode::kFailed) << bad;
  }
  EXPECT_EQ(code(disk.create(std::string(101, 'a'))), DiskErrorCode::kFailed);
  EXPECT_TRUE(scratch.names().empty());
  // A link is somebody else's file.
  ASSERT_EQ(symlink("/dev/full", scratch.at("link").c_str()), 0);
  EXPECT_EQ(code(disk.open("link")), DiskErrorCode::kFailed);
  scratch.file("file", "");
  EXPECT_FALSE(DiskFolder::open_folder(scratch.at("file")));
}

TEST(DiskFolder, full_disk_is_told) {
  // The one folder of a system in which every write finds no room.
  DiskFolder disk = folder_at("/dev");
  const DiskFile file = *disk.open("full");
  EXPECT_EQ(code(disk.append(file, Bytes{1})), DiskErrorCode::kFull);
  EXPECT_EQ(code(disk.write(file, 7, Bytes{1})), DiskErrorCode::kFull);
  disk.close(file);
  EXPECT_EQ(disk_error("a", {DiskErrorCode::kFull, 0}).sentence, "a: no space left on device");
  EXPECT_EQ(disk_error("a", {DiskErrorCode::kLocked, 7}).sentence, "a: in use by process 7");
}

TEST(DiskFolder, lock_holds_against_another_of_this_process_and_names_it) {
  const test::ScratchFolder scratch;
  auto first = std::make_unique<DiskFolder>(folder_at(scratch.at()));
  DiskFolder second = folder_at(scratch.at());
  EXPECT_TRUE(first->lock("lock"));
  EXPECT_EQ(code(first->lock("lock")), DiskErrorCode::kLocked);
  const auto refused = second.lock("lock");
  EXPECT_EQ(refused.error(), (DiskError{DiskErrorCode::kLocked, ::getpid()}));
  first.reset();
  EXPECT_TRUE(second.lock("lock"));
}

TEST(DiskFolder, lock_of_a_process_that_was_killed_is_none) {
  const test::ScratchFolder scratch;
  std::array<int, 2> ready{};
  ASSERT_EQ(pipe(ready.data()), 0);
  const pid_t child = fork();
  if (child == 0) {
    DiskFolder disk = folder_at(scratch.at());
    const char letter = disk.lock("lock") ? 'y' : 'n';
    if (write(ready[1], &letter, 1) != 1) _exit(1);
    pause();
    _exit(0);
  }
  char letter = 0;
  ASSERT_EQ(read(ready[0], &letter, 1), 1);
  ASSERT_EQ(letter, 'y');
  DiskFolder disk = folder_at(scratch.at());
  EXPECT_EQ(disk.lock("lock").error(), (DiskError{DiskErrorCode::kLocked, child}));
  kill(child, SIGKILL);
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  EXPECT_EQ(test::text_of(scratch.at("lock")), std::to_string(child) + "\n");
  EXPECT_TRUE(disk.lock("lock"));
  EXPECT_EQ(test::text_of(scratch.at("lock")), std::to_string(::getpid()) + "\n");
  close(ready[0]);
  close(ready[1]);
}

}  // namespace
}  // namespace sinew::io
