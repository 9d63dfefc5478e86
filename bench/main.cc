// Speeds as ratios to KDL in the same process: `make bench`.
#include <benchmark/benchmark.h>

#include <array>
#include <vector>

#include "bench/ratio_reporter.h"

int main(int argc, char** argv) {
  // Rows are interleaved and repeated, so that a slow second of the machine hits them alike; a
  // flag of the caller comes later and wins.
  static std::array<char[48], 4> defaults{
      "--benchmark_repetitions=9", "--benchmark_enable_random_interleaving=true",
      "--benchmark_report_aggregates_only=true", "--benchmark_min_time=0.05"};
  std::vector<char*> arguments{argv[0]};
  for (auto& flag : defaults) arguments.push_back(flag);
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  sinew::bench::RatioReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  benchmark::Shutdown();
  return 0;
}
