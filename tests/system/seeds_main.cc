// sinew-sim: runs of the whole system by their seeds, for as long as somebody likes.
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <string>

#include "system/system_run.h"

namespace sinew::test {
namespace {

constexpr int kShrinkTries = 200;

struct Request {
  std::string seeds = "1..1000";
  double seconds = 0;  ///< 0: until the last seed
  bool hashes = false;
  bool supplies = false;
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

/// "7", or "1..1000".
bool read_seeds(Request& request) {
  const auto number = [](const std::string& text, std::uint64_t& value) {
    std::size_t used = 0;
    try {
      value = std::stoull(text, &used, 10);
    } catch (const std::exception&) {
      return false;
    }
    return used == text.size() && text[0] != '-';
  };
  const std::size_t dots = request.seeds.find("..");
  if (dots == std::string::npos) {
    request.last = 0;
    const bool fine = number(request.seeds, request.first);
    request.last = request.first;
    return fine;
  }
  return number(request.seeds.substr(0, dots), request.first) &&
         number(request.seeds.substr(dots + 2), request.last) && request.first <= request.last;
}

/// What a seed that fails says: what broke, and how little of it still does.
void tell(const SystemPlan& plan_that_fails, const SystemRun& run) {
  std::cout << "seed " << plan_that_fails.seed << " FAILS: " << run.failures.front()
            << "\n  shrinks ..." << std::endl;
  SystemCounts counts;
  const SystemPlan plan = shrunk(plan_that_fails, kShrinkTries);
  const SystemRun less = run_system(plan, counts);
  std::cout << "  to " << describe(plan, less) << "\n";
  if (!less.failures.empty()) std::cout << "  " << less.failures.front() << "\n";
}

int run(const Request& request) {
  using Clock = std::chrono::steady_clock;
  SystemCounts counts;
  const auto begin = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  std::uint64_t ran = 0;
  std::uint64_t failed = 0;
  for (std::uint64_t seed = request.first; seed <= request.last; ++seed) {
    if (request.seconds > 0 && elapsed() > request.seconds) break;
    const SystemPlan plan{.seed = seed, .supplies = request.supplies};
    const SystemRun one = run_system(plan, counts);
    ++ran;
    if (request.hashes)
      std::printf("%llu %016llx\n", static_cast<unsigned long long>(seed),
                  static_cast<unsigned long long>(one.hash));
    if (one.failures.empty()) continue;
    ++failed;
    tell(plan, one);
  }
  if (!request.hashes) {
    std::cout << ran << " seeds in " << elapsed() << " s: " << counts.commands << " commands, "
              << counts.motions_done << " motions done, " << counts.faults << " misfortunes, "
              << counts.kills << " dead hosts, " << failed << " failed\n";
  }
  return failed == 0 ? 0 : 1;
}

}  // namespace
}  // namespace sinew::test

int main(int argc, char** argv) {
  CLI::App app(
      "sinew-sim: controllers, drivers, wires, devices, disks and clients in virtual time");
  sinew::test::Request request;
  app.add_option("--seeds", request.seeds, "one seed, or A..B")->capture_default_str();
  app.add_option("--seconds", request.seconds, "stops behind the seed that is under way then");
  app.add_flag("--supplies", request.supplies, "supplies sink as well");
  app.add_flag("--hashes", request.hashes, "each seed with the hash of all that happened");
  CLI11_PARSE(app, argc, argv);
  if (!sinew::test::read_seeds(request)) {
    std::cerr << "sinew-sim: --seeds: is a number, or two as in 1..1000\n";
    return 2;
  }
  testing::InitGoogleTest();
  return sinew::test::run(request);
}
