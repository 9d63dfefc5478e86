#include "sinew/core/spelling.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

TEST(Spelling, distance_counts_insertions_removals_replacements_and_swaps) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("upper_deg", "upper_deg"), 0U);
  EXPECT_EQ(edit_distance("uper_deg", "upper_deg"), 1U);
  EXPECT_EQ(edit_distance("uppper_deg", "upper_deg"), 1U);
  EXPECT_EQ(edit_distance("ubper_deg", "upper_deg"), 1U);
  EXPECT_EQ(edit_distance("upper_dge", "upper_deg"), 1U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(Spelling, nearest_word_wins_and_far_words_lose) {
  constexpr std::string_view kWords[] = {"upper_deg", "upper_rad", "lower_deg", "d_mm"};
  EXPECT_EQ(nearest_spelling("uper_deg", kWords), "upper_deg");
  EXPECT_EQ(nearest_spelling("upper_mm", kWords), "upper_deg");
  EXPECT_EQ(nearest_spelling("d_nm", kWords), "d_mm");
  EXPECT_EQ(nearest_spelling("colour", kWords), "");
  EXPECT_EQ(nearest_spelling("x", kWords), "") << "nothing of x is left in any of the words";
}

TEST(Spelling, unprintable_bytes_are_shown_as_numbers) {
  EXPECT_EQ(printable("d_mm"), "d_mm");
  EXPECT_EQ(printable("a\n\x7f\xc3"), "a\\x0a\\x7f\\xc3");
  EXPECT_EQ(printable(std::string(61, 'a')), std::string(60, 'a') + "...");
}

}  // namespace
}  // namespace sinew
