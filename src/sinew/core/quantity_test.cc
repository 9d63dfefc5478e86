#include "sinew/core/quantity.h"

#include <gtest/gtest.h>

#include "sinew/core/units.h"

namespace sinew {
namespace {

double value_of(std::string_view text, Measure measure) {
  const auto value = parse_quantity(text, measure, UnitRule::kRequired);
  EXPECT_TRUE(value) << text << ": " << value.error();
  return value.value_or(-1);
}

std::string complaint_of(std::string_view text, Measure measure) {
  const auto value = parse_quantity(text, measure, UnitRule::kRequired);
  return value ? "accepted" : value.error();
}

TEST(Quantity, every_unit_comes_to_si) {
  EXPECT_DOUBLE_EQ(value_of("90deg", Measure::kAngle), kPi / 2);
  EXPECT_DOUBLE_EQ(value_of("-1.57rad", Measure::kAngle), -1.57);
  EXPECT_DOUBLE_EQ(value_of("12.5 mm", Measure::kLength), 0.0125);
  EXPECT_DOUBLE_EQ(value_of("2in", Measure::kLength), 0.0508);
  EXPECT_DOUBLE_EQ(value_of("+0.1m", Measure::kLength), 0.1);
  EXPECT_DOUBLE_EQ(value_of("200ms", Measure::kTime), 0.2);
  EXPECT_DOUBLE_EQ(value_of("50%", Measure::kShare), 0.5);
  EXPECT_DOUBLE_EQ(value_of("9V", Measure::kVoltage), 9);
  EXPECT_DOUBLE_EQ(value_of("500g", Measure::kMass), 0.5);
}

TEST(Quantity, what_is_none_is_said_with_what_would_be) {
  EXPECT_EQ(complaint_of("30", Measure::kAngle), "'30' needs a unit: deg, rad");
  EXPECT_EQ(complaint_of("30mm", Measure::kAngle),
            "'30mm' ends in 'mm', which is none of deg, rad");
  EXPECT_EQ(complaint_of("", Measure::kTime), "a number is missing");
  EXPECT_EQ(complaint_of("+-3deg", Measure::kAngle), "'+-3deg' is not a finite number");
  EXPECT_EQ(complaint_of("nan", Measure::kAngle), "'nan' is not a finite number");
  EXPECT_EQ(complaint_of("1e999s", Measure::kTime), "'1e999s' is not a finite number");
}

}  // namespace
}  // namespace sinew
