#include <gtest/gtest.h>

#include <bit>
#include <chrono>
#include <iostream>

#include "support/how_many.h"
#include "system/system_run.h"

namespace sinew::test {
namespace {

/// Seeds of a run. With sanitizers each takes ten times as long.
std::uint64_t seeds() {
  return how_many("SINEW_SEEDS", 1000, 50);
}

class System : public testing::TestWithParam<bool> {};

TEST_P(System, seeds_of_misfortunes_keep_every_promise) {
  SystemCounts counts;
  const std::uint64_t first = seed();
  std::uint64_t ran = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (; ran < seeds() / 2 && !HasFailure(); ++ran) {
    const SystemRun run = run_system({.seed = first + ran, .supplies = GetParam()}, counts);
    for (const std::string& failure : run.failures) {
      ADD_FAILURE() << failure << "\nreplay and shrink: sinew-sim --seeds " << first + ran
                    << (GetParam() ? " --supplies" : "");
    }
  }
  const double took =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::cout << "  " << ran << " seeds from " << first << " in " << took << " s: " << counts.commands
            << " commands, " << counts.motions_done << " done, " << counts.faults
            << " misfortunes, " << counts.kills << " dead hosts (" << counts.power_losses
            << " without power), " << counts.disks_failed << " full disks, " << counts.latched
            << " faults latched, " << counts.records << " records, " << counts.looks
            << " looks at them\n";
  EXPECT_GE(counts.commands, 20 * ran);
  EXPECT_GE(counts.faults, 5 * ran);
  EXPECT_GT(counts.motions_done, ran);
  EXPECT_GT(counts.disks_failed, ran / 2);
  RecordProperty("cases", std::to_string(ran));
}

INSTANTIATE_TEST_SUITE_P(Supplies, System, testing::Bool(), [](const auto& parameter) {
  return parameter.param ? "that_sink" : "that_hold";
});

TEST(SystemRuns, the_same_seed_is_the_same_run_to_the_last_event) {
  SystemCounts counts;
  for (std::uint64_t k = 0; k < 3; ++k) {
    const std::uint64_t one = run_system({.seed = seed() + k}, counts).hash;
    EXPECT_EQ(run_system({.seed = seed() + k}, counts).hash, one);
    EXPECT_NE(run_system({.seed = seed() + k + 100}, counts).hash, one);
  }
}

TEST(SystemRuns, a_seed_that_fails_is_shrunk_to_the_one_thing_that_it_takes) {
  SystemCounts counts;
  const SystemPlan whole{.seed = seed(), .planted = "its disk is full"};
  const SystemRun first = run_system(whole, counts);
  ASSERT_FALSE(first.failures.empty()) << "a seed in which no disk is ever full";
  const SystemPlan least = shrunk(whole, 150);
  const SystemRun run = run_system(least, counts);
  ASSERT_EQ(run.failures.size(), 1U);
  EXPECT_EQ(run.misfortunes.size(), 1U) << describe(least, run);
  EXPECT_TRUE(std::has_single_bit(least.robots)) << describe(least, run);
  EXPECT_LT(least.time, whole.time);
  // What is left fails each time, and without it nothing does.
  EXPECT_EQ(run_system(least, counts).failures, run.failures);
  SystemPlan without = least;
  without.spared.insert(run.misfortunes.front().number);
  EXPECT_TRUE(run_system(without, counts).failures.empty());
}

}  // namespace
}  // namespace sinew::test
