#include "sinew/devices/icp/icp_driver_step_merge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

/// Runs it to its end and checks after each step that every leg is within one step of its share.
void expect_straight(const StepMerge::Counts& counts) {
  StepMerge merge(counts);
  StepMerge::Counts made{};
  const auto total = static_cast<double>(merge.total());
  for (std::int64_t k = 1; !merge.done(); ++k) {
    const StepMerge::Step step = merge.next();
    ASSERT_EQ(step, merge.next()) << "asking changes nothing";
    made[step.leg] += step.direction;
    merge.advance();
    ASSERT_EQ(merge.remaining(), merge.total() - k);
    for (std::size_t i = 0; i < kLegs; ++i) {
      const double share = static_cast<double>(counts[i]) * static_cast<double>(k) / total;
      ASSERT_LT(std::abs(static_cast<double>(made[i]) - share), 1 + 1e-9)
          << "leg " << i << " after " << k << " of " << total;
    }
  }
  EXPECT_EQ(made, counts) << "it ends where it was sent";
}

TEST(StepMerge, nothing_to_do_is_done) {
  EXPECT_TRUE(StepMerge().done());
  EXPECT_TRUE(StepMerge(StepMerge::Counts{}).done());
}

TEST(StepMerge, equal_ways_take_turns) {
  StepMerge merge({2, -2, 2, -2, 2, -2});
  std::array<int, kLegs> seen{};
  for (int k = 0; k < 6; ++k) {
    const StepMerge::Step step = merge.next();
    ++seen[step.leg];
    EXPECT_EQ(step.direction, step.leg % 2 == 0 ? 1 : -1);
    merge.advance();
  }
  for (const int count : seen) EXPECT_EQ(count, 1);
}

TEST(StepMerge, one_leg_alone_steps_every_time) {
  expect_straight({0, 0, -5, 0, 0, 0});
}

TEST(StepMerge, whole_stroke_of_all_legs_ends_to_the_step) {
  expect_straight({685714, -3, 0, 100000, -685714, 1});
}

TEST(StepMerge, every_leg_stays_within_one_step_of_the_straight_line) {
  test::for_random_cases(2'000, [](test::Random& random) {
    StepMerge::Counts counts{};
    const std::int64_t most = random.chance(0.2) ? 5 : 700;
    for (auto& count : counts) {
      count = random.chance(0.2) ? 0 : random.integer(-most, most);
    }
    expect_straight(counts);
  });
}

TEST(StepMerge, no_allocation) {
  const test::AllocationCounter allocations;
  StepMerge merge({500, -20, 3, 0, 77, 500});
  while (!merge.done()) merge.advance();
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew
