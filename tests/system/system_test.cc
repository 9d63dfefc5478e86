#include <gtest/gtest.h>

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
            << " without power), " << counts.latched << " faults latched, " << counts.records
            << " records, " << counts.looks << " looks at them\n";
  EXPECT_GE(counts.commands, 20 * ran);
  EXPECT_GE(counts.faults, 5 * ran);
  EXPECT_GT(counts.motions_done, ran);
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

}  // namespace
}  // namespace sinew::test
