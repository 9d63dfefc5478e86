#include "sinew/io/private_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>

#include "support/scratch_folder.h"

namespace sinew::io {
namespace {

using sinew::test::ScratchFolder;

mode_t mode_of(const std::string& path) {
  struct stat status{};
  EXPECT_EQ(::stat(path.c_str(), &status), 0) << path;
  return status.st_mode & 0777;
}

TEST(PrivateFile, is_made_once_and_kept) {
  const ScratchFolder folder;
  const std::string path = folder.at("new/secret");
  const auto first = keep_private(path, "one\n");
  ASSERT_TRUE(first) << first.error().sentence;
  EXPECT_EQ(*first, "one\n");
  EXPECT_EQ(mode_of(path), 0600U);
  EXPECT_EQ(mode_of(folder.at("new")), 0700U);
  EXPECT_EQ(keep_private(path, "two\n").value_or(IoError{}.sentence), "one\n");
}

TEST(PrivateFile, that_others_may_read_is_refused) {
  const ScratchFolder folder;
  const std::string path = folder.file("secret", "one\n");
  ::chmod(path.c_str(), 0640);
  const auto read = keep_private(path, "two\n");
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().sentence.find("others may read it"), std::string::npos);
}

TEST(PrivateFile, that_is_a_link_or_a_folder_is_refused) {
  const ScratchFolder folder;
  const std::string path = folder.file("secret", "one\n");
  ::chmod(path.c_str(), 0600);
  const std::string link = folder.at("link");
  ASSERT_EQ(::symlink(path.c_str(), link.c_str()), 0);
  EXPECT_FALSE(keep_private(link, "two\n"));
  EXPECT_FALSE(keep_private(folder.at(), "two\n"));
  EXPECT_FALSE(keep_private(path + "/below", "two\n"));
}

TEST(PrivateFile, what_nobody_can_guess_differs_each_time) {
  std::array<std::uint8_t, 16> one{};
  std::array<std::uint8_t, 16> other{};
  ASSERT_TRUE(fill_unguessable(one) && fill_unguessable(other));
  EXPECT_NE(one, other);
}

}  // namespace
}  // namespace sinew::io
