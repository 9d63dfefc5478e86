#pragma once

#include <set>
#include <string>
#include <vector>

#include "system/system_cell.h"

namespace sinew::test {

/// Robots with all that may go wrong, all of it from one seed, in virtual time.
struct SystemPlan {
  std::uint64_t seed = 0;
  Duration time = std::chrono::seconds(20);
  unsigned robots = 0b1111;  ///< one bit each
  bool supplies = false;     ///< sink as well, from time to time
  /// Misfortunes that are drawn and do not happen, by their numbers; what is left of a failing seed
  /// behind shrinking has fewer.
  std::set<std::uint64_t> spared = {};
  /// For tests of the tests: a misfortune whose text has this in it counts as a broken promise.
  std::string planted = {};
};

struct SystemRun {
  std::uint64_t hash = 0;               ///< of all that happened
  std::vector<std::string> failures;    ///< promises that were broken; the first one ends the run
  std::vector<Misfortune> misfortunes;  ///< those that happened, robot by robot
};

/// 20 s and then as long as it takes until all are ready again, 120 s at most.
SystemRun run_system(const SystemPlan& plan, SystemCounts& counts);

/// A failing plan with as little in it as still fails: less time, fewer robots, fewer misfortunes.
/// @param tries  runs that may be spent on it
SystemPlan shrunk(SystemPlan plan, int tries);

/// "robots hexapod learm, 7.3 s, 2 misfortunes", and a line for each: for people.
std::string describe(const SystemPlan& plan, const SystemRun& run);

}  // namespace sinew::test
