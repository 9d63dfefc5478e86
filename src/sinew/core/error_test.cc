#include "sinew/core/error.h"

#include <gtest/gtest.h>

#include "sinew/core/error_code.h"
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
  EXPECT_EQ(table.back().code, ErrorCode::kProbeClosed) << "the last enumerator has no row";
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

TEST(Error, lengths_of_bodies_are_told_to_a_tenth_of_a_millimetre_and_an_overlap_as_one) {
  EXPECT_EQ(describe({ErrorCode::kOutOfReach, -1, 0.203 + 1.1e-8, 0.203}),
            "out of reach by less than 0.1 mm: needs 203 mm, the arm has 203 mm");
  Error contact{ErrorCode::kCollision, 4, -0.1718, 0.005};
  EXPECT_EQ(describe(contact, "tool and table"),
            "tool and table would overlap by 171.8 mm; required clearance 5 mm");
  contact.code = ErrorCode::kCellContact;
  EXPECT_EQ(describe(contact, "tool"),
            "tool would overlap something else in its cell by 171.8 mm; required clearance 5 mm");
  EXPECT_EQ(describe({ErrorCode::kLegLength, 0, 0.24002, 0.24}),
            "J1 would need 240 mm, limit 240 mm, 0.02 mm too far");
}

TEST(Error, jaws_that_would_close_into_something_back_off_by_as_much_as_they_go_on) {
  EXPECT_NE(describe({ErrorCode::kJawsContact, 4, 0.001, 0.03}).find("30 mm farther"),
            std::string::npos);
  EXPECT_TRUE(describe({ErrorCode::kJawsContact, 4, 0.001, 0.03}).ends_with("dz=-30mm"));
  EXPECT_TRUE(describe({ErrorCode::kJawsContact, 4, 0.001, 0.01821}).ends_with("dz=-18.3mm"));
}

}  // namespace
}  // namespace sinew
