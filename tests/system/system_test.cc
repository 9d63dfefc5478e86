#include <gtest/gtest.h>

#include <chrono>
#include <iostream>

#include "sinew/runtime/robot_variant.h"
#include "support/how_many.h"
#include "support/robots.h"
#include "system/system_cell.h"

namespace sinew::test {
namespace {

using namespace std::chrono_literals;

/// Seeds of a run. With sanitizers each takes ten times as long.
std::uint64_t seeds() {
  return how_many("SINEW_SEEDS", 1000, 50);
}

struct Kind {
  const char* robot;
  const char* profile;  ///< null: its default
};
constexpr Kind kKinds[] = {{"hexapod", nullptr}, {"bigrobotarm", "document"}, {"learm", "bus"}};

std::optional<std::string> profile_of(const Kind& kind) {
  return kind.profile == nullptr ? std::nullopt : std::optional<std::string>(kind.profile);
}

/// 20 s of three robots with all that may go wrong, and then as long as it takes until they are
/// ready again. @return  the hash of all that happened
std::uint64_t run_seed(std::uint64_t seed, SystemCounts& counts) {
  constexpr Duration kSlice = 20ms;
  TraceHash hash;
  std::vector<RobotModel> robots;
  for (const Kind& kind : kKinds) {
    robots.push_back(runtime::variant_of(robot(kind.robot), profile_of(kind), {}).value());
  }
  std::vector<std::unique_ptr<Station>> stations;
  for (std::size_t k = 0; k < robots.size(); ++k) {
    stations.push_back(std::make_unique<Station>(robots[k], profile_of(kKinds[k]),
                                                 seed * 0x9E3779B97F4A7C15ULL + k, counts, hash));
  }
  const auto run = [&](Duration time) {
    for (Duration t{}; t < time && !testing::Test::HasFailure(); t += kSlice) {
      for (const auto& station : stations) station->slice(kSlice);
    }
  };
  run(20s);
  for (const auto& station : stations) station->heal();
  for (const auto& station : stations) {
    for (Duration t{}; t < 120s && !station->ready() && !testing::Test::HasFailure(); t += kSlice) {
      station->slice(kSlice);
    }
    EXPECT_TRUE(station->ready()) << station->where() << " never came back";
    counts.back += station->ready() ? 1 : 0;
  }
  return hash.value();
}

TEST(System, seeds_of_misfortunes_keep_every_promise) {
  SystemCounts counts;
  const std::uint64_t first = seed();
  std::uint64_t ran = 0;
  const auto begin = std::chrono::steady_clock::now();
  for (; ran < seeds() && !HasFailure(); ++ran) {
    run_seed(first + ran, counts);
    if (HasFailure()) {
      ADD_FAILURE() << "replay with SINEW_SEED=" << first + ran << " SINEW_SEEDS=1";
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

TEST(System, the_same_seed_is_the_same_run_to_the_last_event) {
  SystemCounts counts;
  for (std::uint64_t k = 0; k < 3; ++k) {
    const std::uint64_t one = run_seed(seed() + k, counts);
    EXPECT_EQ(run_seed(seed() + k, counts), one);
    EXPECT_NE(run_seed(seed() + k + 100, counts), one);
  }
}

}  // namespace
}  // namespace sinew::test
