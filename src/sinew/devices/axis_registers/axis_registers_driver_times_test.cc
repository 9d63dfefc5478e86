#include "sinew/devices/axis_registers/axis_registers_driver_times.h"

#include <gtest/gtest.h>

#include <array>

#include "support/property.h"
#include "support/robots.h"

namespace sinew {
namespace {

AxisRegistersDevice boards(bool reports_status) {
  AxisRegistersDevice device;
  device.reports_status = reports_status;
  for (int i = 0; i < 6; ++i) device.boards.push_back({});
  return device;
}

using Own = std::array<double, 6>;

TEST(AxisRegisterTimes, one_board_is_told_polled_until_it_rests_and_read_back) {
  const AxisRegistersDevice device = boards(true);
  AxisRegisterTimes times(device, {});
  const auto move = times.next(Own{0, 0, 2, 0, 0, 0});
  EXPECT_NEAR(move.own, 2, 1e-9);
  EXPECT_NEAR(move.arrival, 2.074, 1e-9);
  // The poll that finds it at rest may just have missed it.
  EXPECT_GE(move.report, move.arrival + 0.082);
  EXPECT_LE(move.report, move.arrival + 3 * 0.082);
}

TEST(AxisRegisterTimes, each_further_board_begins_a_frame_later) {
  const AxisRegistersDevice device = boards(true);
  AxisRegisterTimes times(device, {});
  EXPECT_NEAR(times.next(Own{2, 2, 2, 2, 2, 2}).own, 2 + 5 * 0.082, 1e-9);
  AxisRegisterTimes again(device, {});
  EXPECT_NEAR(again.next(Own{2, 0, 0, 0, 0, 0.5}).own, 2, 1e-9);
}

TEST(AxisRegisterTimes, boards_that_are_told_nothing_are_asked_once) {
  const AxisRegistersDevice device = boards(true);
  AxisRegisterTimes times(device, {});
  const auto move = times.next(Own{});
  EXPECT_EQ(move.arrival, 0);
  EXPECT_NEAR(move.report, 0.082 * 6, 1e-9);
  EXPECT_EQ(move.own, 0);
}

TEST(AxisRegisterTimes, boards_that_tell_nothing_are_waited_for) {
  const AxisRegistersDevice device = boards(false);
  AxisRegisterTimes times(device, {});
  const auto move = times.next(Own{0, 3, 0, 1, 0, 0});
  EXPECT_NEAR(move.own, 3, 1e-9);
  EXPECT_NEAR(move.report, 3 + 0.082 + 0.072, 1e-9);
}

TEST(AxisRegisterTimes, nobody_is_told_as_done_before_it_has_arrived) {
  test::for_random_cases(2000, [&](test::Random& random) {
    const AxisRegistersDevice device = boards(random.chance(0.8));
    AxisRegisterTimes times(device, {});
    for (int k = 0; k < 4; ++k) {
      Own own{};
      for (double& time : own) time = random.chance(0.6) ? random.uniform(0.01, 20) : 0;
      const auto move = times.next(own);
      for (const double time : own) ASSERT_GE(move.own, time - 1e-9);
      ASSERT_GE(move.report, move.arrival);
      ASSERT_LE(move.report, move.arrival + 0.082 * 20);
    }
  });
}

}  // namespace
}  // namespace sinew
