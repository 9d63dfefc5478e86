#include "sinew/mcu/blink_code.h"

#include <gtest/gtest.h>

namespace sinew::mcu {
namespace {

TEST(BlinkCode, every_number_can_be_counted) {
  for (std::uint8_t number = 1; number <= 20; ++number) {
    const std::uint32_t group = number * 500U + 1500;
    for (const std::uint32_t start : {0U, 7 * group}) {
      int flashes = 0;
      std::uint32_t lit = 0;
      for (std::uint32_t ms = 0; ms < group; ++ms) {
        const bool on = is_lit(start + ms, number);
        lit += on ? 1 : 0;
        flashes += on && (ms == 0 || !is_lit(start + ms - 1, number)) ? 1 : 0;
      }
      EXPECT_EQ(flashes, number);
      EXPECT_EQ(lit, number * 200U);
    }
  }
}

}  // namespace
}  // namespace sinew::mcu
