#include "sinew/core/error.h"

#include <gtest/gtest.h>

#include "sinew/core/units.h"

namespace sinew {
namespace {

TEST(Error, table_stands_in_the_order_of_the_codes) {
  const auto table = error_table();
  for (std::size_t i = 0; i < table.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(table[i].code), i) << table[i].name;
    EXPECT_FALSE(table[i].name.empty());
    EXPECT_FALSE(describe({.code = table[i].code}).empty());
  }
  EXPECT_EQ(table.back().code, ErrorCode::kCountedElsewhere) << "the last enumerator has no row";
}

TEST(Error, sentence_speaks_in_mm_and_degrees) {
  EXPECT_EQ(describe({ErrorCode::kOutOfReach, -1, 0.696, 0.684}),
            "out of reach by 12 mm: needs 696 mm, the arm has 684 mm");
  EXPECT_EQ(describe({ErrorCode::kJointLimit, 2, from_deg(131.4), from_deg(126)}, "elbow"),
            "elbow would need 131.4 deg, limit 126 deg, 5.4 deg too far");
  EXPECT_EQ(describe({ErrorCode::kUnsendable, -1, 13}),
            "the value at 13 cannot be sent: the byte 0D in it would cut the command in two");
  EXPECT_EQ(describe({ErrorCode::kJointLimit, 2, 0, -0.0}),
            "J3 would need 0 deg, limit 0 deg, 0 deg too far");
}

}  // namespace
}  // namespace sinew
