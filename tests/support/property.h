#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>

#include "sinew/core/split_mix.h"

namespace sinew::test {

/// Seeded random numbers for one case of a property; one seed replays one run on every platform.
class Random : public SplitMix64 {
 public:
  using SplitMix64::SplitMix64;

  /// In [lower, upper], both included.
  std::int64_t integer(std::int64_t lower, std::int64_t upper) {
    const auto span = static_cast<std::uint64_t>(upper - lower) + 1;
    return lower + static_cast<std::int64_t>(span == 0 ? bits() : bits() % span);
  }
  bool chance(double probability) { return uniform(0, 1) < probability; }

  /// What was drawn is none of the property's business: this case asserts nothing, and does not
  /// count. `return random.discard();` where a body leaves before its first assertion.
  void discard() { discarded_ = true; }
  bool discarded() const { return discarded_; }

 private:
  bool discarded_ = false;
};

/// The seed of this process: SINEW_SEED where it is set, else a fixed one, so that a plain test
/// run never changes its mind; campaigns set fresh ones.
inline std::uint64_t seed() {
  const char* text = std::getenv("SINEW_SEED");
  return text != nullptr ? std::strtoull(text, nullptr, 0) : 20261121;
}

/// Of the test that runs now, over all its properties.
struct CaseCounts {
  const ::testing::TestInfo* test = nullptr;
  std::uint64_t asserted = 0;
  std::uint64_t discarded = 0;
};
inline CaseCounts& case_counts() {
  static CaseCounts counts;
  const auto* now = ::testing::UnitTest::GetInstance()->current_test_info();
  if (counts.test != now) counts = {now, 0, 0};
  return counts;
}

/// Runs `body(random)` until it has asserted `cases` times, in four times as many tries at most;
/// stops at the first case that fails and says how to replay it. Fails where every case was
/// discarded, and records how many were not, which a test of its own holds against the minimum of
/// minimum_cases.h.
template <class Body>
void for_random_cases(std::uint64_t cases, Body&& body) {
  const std::uint64_t first_seed = seed();
  const std::uint64_t tries_max = 4 * cases;
  std::uint64_t ran = 0;
  std::uint64_t discarded = 0;
  for (; ran - discarded < cases && ran < tries_max; ++ran) {
    Random random(first_seed ^ (ran * 0xD1342543DE82EF95ULL));
    body(random);
    if (::testing::Test::HasFailure()) {
      ADD_FAILURE() << "case " << ran << " of " << cases
                    << "; replay with SINEW_SEED=" << first_seed;
      break;
    }
    discarded += random.discarded() ? 1 : 0;
  }
  if (cases > 0 && ran == tries_max && discarded == ran) {
    ADD_FAILURE() << "all " << ran << " cases were discarded: nothing was asserted";
  }
  CaseCounts& counts = case_counts();
  counts.asserted += ran - discarded;
  counts.discarded += discarded;
  ::testing::Test::RecordProperty("cases", std::to_string(counts.asserted));
  ::testing::Test::RecordProperty("discarded", std::to_string(counts.discarded));
  std::cout << "  seed " << first_seed << ", " << ran - discarded << " cases, " << discarded
            << " more discarded\n";
}

}  // namespace sinew::test
