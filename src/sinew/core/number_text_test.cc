#include "sinew/core/number_text.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

TEST(NumberText, up_to_so_many_decimals_and_no_zeros_behind_them) {
  EXPECT_EQ(number_text(95, 3), "95");
  EXPECT_EQ(number_text(-0.0004, 3), "0");
  EXPECT_EQ(number_text(2.5, 3), "2.5");
  EXPECT_EQ(number_text(100, 0), "100");
}

TEST(NumberText, six_digits_where_none_are_said) {
  EXPECT_EQ(number_text(95), "95");
  EXPECT_EQ(number_text(-0.0), "0");
  EXPECT_EQ(number_text(1.0 / 3), "0.333333");
  EXPECT_EQ(number_text(1e300), "1e+300");
}

}  // namespace
}  // namespace sinew
