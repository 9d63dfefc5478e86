#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>

namespace sinew::test {

/// Seeded random numbers for one property; one seed replays one run on every platform.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  /// SplitMix64 (Steele, Lea, Flood, 2014): cheap to seed, and every case seeds its own.
  std::uint64_t bits() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  /// In [lower, upper).
  double uniform(double lower, double upper) {
    return lower + (upper - lower) * static_cast<double>(bits() >> 11) * 0x1p-53;
  }
  /// In [lower, upper], both included.
  std::int64_t integer(std::int64_t lower, std::int64_t upper) {
    const auto span = static_cast<std::uint64_t>(upper - lower) + 1;
    return lower + static_cast<std::int64_t>(span == 0 ? bits() : bits() % span);
  }
  bool chance(double probability) { return uniform(0, 1) < probability; }

 private:
  std::uint64_t state_;
};

/// The seed of this process: SINEW_SEED where it is set, else a fixed one, so that a plain test
/// run never changes its mind; campaigns set fresh ones.
inline std::uint64_t seed() {
  const char* text = std::getenv("SINEW_SEED");
  return text != nullptr ? std::strtoull(text, nullptr, 0) : 20261121;
}

/// Runs `body(random)` `cases` times, stops at the first case that fails and says how to replay
/// it, and records the number of cases that ran, which a test of its own holds against the
/// minimum of minimum_cases.h.
template <class Body>
void for_random_cases(std::uint64_t cases, Body&& body) {
  const std::uint64_t first_seed = seed();
  std::uint64_t ran = 0;
  for (; ran < cases; ++ran) {
    Random random(first_seed ^ (ran * 0xD1342543DE82EF95ULL));
    body(random);
    if (::testing::Test::HasFailure()) {
      ADD_FAILURE() << "case " << ran << " of " << cases
                    << "; replay with SINEW_SEED=" << first_seed;
      break;
    }
  }
  ::testing::Test::RecordProperty("cases", std::to_string(ran));
  std::cout << "  seed " << first_seed << ", " << ran << " cases\n";
}

}  // namespace sinew::test
