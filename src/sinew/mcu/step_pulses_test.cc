#include "sinew/mcu/step_pulses.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "support/property.h"

namespace sinew::mcu {
namespace {

using Ways = std::array<std::int32_t, kArmAxes>;

struct Made {
  StepPulses pulses;
  std::array<std::int64_t, kArmAxes> steps{};
  std::vector<int> ticks_of_base;  ///< of its steps, within the last slice

  void tick(int place) {
    const std::uint8_t axes = pulses.tick();
    for (std::size_t i = 0; i < kArmAxes; ++i) {
      if ((axes >> i & 1) == 0) continue;
      steps[i] += (pulses.backwards() >> i & 1) != 0 ? -1 : 1;
      if (i == 0) ticks_of_base.push_back(place);
    }
  }
  void slice(const Ways& ways) {
    pulses.put(ways.data());
    ticks_of_base.clear();
    for (int i = 0; i < StepPulses::kTicks; ++i) tick(i);
  }
};

TEST(StepPulses, any_ways_end_at_the_step_that_is_nearest) {
  test::for_random_cases(300, [](test::Random& random) {
    Made made;
    std::array<std::int64_t, kArmAxes> sums{};
    const auto most = random.integer(10, (1 << 21) - 64);
    for (int k = 0; k < 60; ++k) {
      Ways ways{};
      for (std::size_t i = 0; i < kArmAxes; ++i) {
        ways[i] = static_cast<std::int32_t>(random.integer(-most, most));
        sums[i] += ways[i];
      }
      made.slice(ways);
      for (std::size_t i = 0; i < kArmAxes; ++i) {
        // Ways below a rate's unit, 32 of 65536, wait for the next slice.
        const double exact = static_cast<double>(sums[i]) / 65536;
        EXPECT_NEAR(static_cast<double>(made.steps[i]), exact, 0.5 + 33.0 / 65536) << k;
        EXPECT_EQ(made.pulses.steps(static_cast<std::uint8_t>(i)), made.steps[i]);
      }
    }
    EXPECT_EQ(made.pulses.late(), 0);
  });
}

TEST(StepPulses, steps_of_a_slice_are_as_even_as_ticks_allow) {
  for (int steps = 1; steps <= StepPulses::kTicks - 1; ++steps) {
    Made made;
    made.slice({steps * 65536, 0, 0, 0, 0});
    ASSERT_EQ(made.ticks_of_base.size(), static_cast<std::size_t>(steps));
    const double gap = static_cast<double>(StepPulses::kTicks) / steps;
    for (std::size_t i = 1; i < made.ticks_of_base.size(); ++i) {
      EXPECT_NEAR(made.ticks_of_base[i] - made.ticks_of_base[i - 1], gap, 1) << steps;
    }
  }
}

TEST(StepPulses, a_slice_that_comes_late_makes_none_and_is_counted) {
  Made made;
  made.slice({65536 * 3, 0, 0, 0, 0});
  for (int i = 0; i < StepPulses::kTicks; ++i) made.tick(i);
  EXPECT_EQ(made.steps[0], 3);
  EXPECT_EQ(made.pulses.late(), 1);
}

TEST(StepPulses, a_freeze_leaves_the_count_of_what_was_made) {
  test::for_random_cases(300, [](test::Random& random) {
    Made made;
    Ways ways{};
    for (auto& way : ways) way = static_cast<std::int32_t>(random.integer(-2'000'000, 2'000'000));
    made.slice(ways);
    made.pulses.put(ways.data());
    const auto ticks = random.integer(0, StepPulses::kTicks);
    for (int i = 0; i < ticks; ++i) made.tick(i);
    if (ticks > 0) made.pulses.put(ways.data());
    made.pulses.freeze();
    const auto frozen = made.steps;
    for (std::size_t i = 0; i < kArmAxes; ++i) {
      EXPECT_EQ(made.pulses.steps(static_cast<std::uint8_t>(i)), frozen[i]) << ticks;
    }
    for (int i = 0; i < 3 * StepPulses::kTicks; ++i) made.tick(i);
    EXPECT_EQ(made.steps, frozen);
  });
}

}  // namespace
}  // namespace sinew::mcu
