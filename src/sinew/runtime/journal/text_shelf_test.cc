#include "sinew/runtime/journal/text_shelf.h"

#include <gtest/gtest.h>

#include "sinew/sim/memory_disk.h"
#include "support/property.h"

namespace sinew::runtime {
namespace {

using Code = ShelfRefusal::Code;

class ShelfTest : public testing::Test {
 protected:
  std::string read(const char* file) {
    const auto text = shelf_.read(file);
    return text ? text->text : "nothing";
  }
  std::uint64_t put(const char* file, std::string_view text, std::uint64_t revision = 0) {
    const auto saved = shelf_.save(file, text, revision);
    EXPECT_TRUE(saved);
    return saved.value_or(0);
  }

  sim::MemoryDisk disk_;
  TextShelf shelf_{disk_};
};

TEST(Revision, is_of_the_text_alone_and_exact_in_every_client) {
  EXPECT_EQ(revision_of("a"), revision_of("a"));
  EXPECT_NE(revision_of("a"), revision_of("b"));
  EXPECT_NE(revision_of(""), 0u);
  EXPECT_NE(revision_of("wait 1s\n"), revision_of("wait 1s"));
  for (const char* text : {"", "a", "wait 1s\n"}) EXPECT_LT(revision_of(text), 1ULL << 53);
}

TEST_F(ShelfTest, only_who_knows_what_stands_there_replaces_it) {
  const std::uint64_t first = put("a.sinew", "one");
  EXPECT_EQ(first, revision_of("one"));
  const auto again = shelf_.save("a.sinew", "two", 0);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, Code::kConflict);
  EXPECT_EQ(again.error().revision, first);
  EXPECT_EQ(read("a.sinew"), "one");

  const std::uint64_t second = put("a.sinew", "two", first);
  const auto late = shelf_.save("a.sinew", "three", first);
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().revision, second);
  EXPECT_EQ(read("a.sinew"), "two");

  EXPECT_EQ(shelf_.remove("a.sinew", first).error().code, Code::kConflict);
  EXPECT_TRUE(shelf_.remove("a.sinew", second));
  EXPECT_EQ(shelf_.remove("a.sinew", second).error().code, Code::kConflict);
  EXPECT_EQ(shelf_.remove("a.sinew", 0).error().code, Code::kMissing);
  EXPECT_EQ(shelf_.save("a.sinew", "three", second).error().revision, 0u);
}

TEST_F(ShelfTest, a_change_by_an_editor_is_a_conflict_too) {
  const std::uint64_t mine = put("a.sinew", "one");
  disk_.overwrite("a.sinew", {'x'});
  EXPECT_EQ(shelf_.save("a.sinew", "two", mine).error().code, Code::kConflict);
  EXPECT_EQ(read("a.sinew"), "x");
}

TEST_F(ShelfTest, has_its_bounds) {
  const std::string large(TextShelf::kTextMax + 1, 'x');
  EXPECT_EQ(shelf_.save("a.sinew", large, 0).error().code, Code::kTooLarge);
  put("a.sinew", std::string_view(large).substr(1));
  for (std::size_t i = 1; i < TextShelf::kTextsMax; ++i) put(("p" + std::to_string(i)).c_str(), "");
  EXPECT_EQ(shelf_.save("b.sinew", "", 0).error().code, Code::kTooMany);
  put("a.sinew", "what is there may change", revision_of(std::string_view(large).substr(1)));
}

TEST_F(ShelfTest, lists_those_of_an_ending) {
  put("b.sinew", "two");
  put("a.sinew", "one");
  put("points.toml", "");
  const auto entries = shelf_.list(".sinew");
  ASSERT_TRUE(entries);
  ASSERT_EQ(entries->size(), 2u);
  EXPECT_EQ((*entries)[0].name, "a.sinew");
  EXPECT_EQ((*entries)[0].revision, revision_of("one"));
  EXPECT_EQ((*entries)[1].size, 3u);
}

TEST_F(ShelfTest, a_full_disk_leaves_what_was_kept_and_no_litter) {
  const std::uint64_t revision = put("a.sinew", "one");
  disk_.set_capacity(40);
  const auto saved = shelf_.save("a.sinew", std::string(100, 'x'), revision);
  ASSERT_FALSE(saved);
  EXPECT_EQ(saved.error().code, Code::kDisk);
  EXPECT_EQ(saved.error().disk.code, DiskErrorCode::kFull);
  EXPECT_EQ(read("a.sinew"), "one");
  EXPECT_EQ(*disk_.list(), std::vector<std::string>{"a.sinew"});
  put("a.sinew", "short", revision);
}

TEST_F(ShelfTest, whenever_a_call_fails_the_old_text_or_the_new_one_is_there) {
  for (std::uint64_t n = 1; n < 12; ++n) {
    sim::MemoryDisk disk;
    TextShelf shelf(disk);
    const std::uint64_t revision = *shelf.save("a.sinew", "old", 0);
    disk.fail_from_call(disk.calls() + n, {DiskErrorCode::kFailed, 5});
    const auto saved = shelf.save("a.sinew", "new", revision);
    disk.fail_from_call(0, {});
    const auto text = shelf.read("a.sinew");
    ASSERT_TRUE(text) << "call " << n;
    EXPECT_TRUE(text->text == "old" || text->text == "new") << "call " << n << ": " << text->text;
    if (saved) {
      EXPECT_EQ(text->text, "new");
      return;
    }
  }
  FAIL() << "saving takes more calls than were tried";
}

TEST_F(ShelfTest, whenever_the_power_goes_the_old_text_or_the_new_one_is_there) {
  test::for_random_cases(300, [](test::Random& random) {
    sim::MemoryDisk disk;
    TextShelf shelf(disk);
    const std::string old(static_cast<std::size_t>(random.integer(0, 3000)), 'o');
    const std::string next(static_cast<std::size_t>(random.integer(0, 3000)), 'n');
    const std::uint64_t revision = *shelf.save("a.sinew", old, 0);
    disk.cut_power_at_call(disk.calls() + static_cast<std::uint64_t>(random.integer(1, 6)));
    const auto saved = shelf.save("a.sinew", next, revision);
    const bool cut = disk.power_is_cut();
    disk.lose_power(static_cast<std::uint64_t>(random.integer(0, 1'000'000)));
    sim::MemoryDisk after = disk;
    after.cut_power_at_call(0);
    const auto text = TextShelf(after).read("a.sinew");
    ASSERT_TRUE(text);
    ASSERT_TRUE(text->text == old || text->text == next);
    if (saved && !cut) {
      ASSERT_EQ(text->text, next);
    }
  });
}

}  // namespace
}  // namespace sinew::runtime
