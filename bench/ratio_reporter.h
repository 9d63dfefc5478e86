#pragma once

#include <benchmark/benchmark.h>

#include <map>
#include <string>

namespace sinew::bench {

/// The yardstick of every row: KDL's forward kinematics of a 6R arm in the same process.
inline constexpr const char* kYardstick = "kdl/forward_6r";

/// Prints one row a benchmark, with its ratio to KDL's forward kinematics and to its goal, once all
/// have run. Machines are shared and noisy: the ratio is the result, the time is for orientation.
class RatioReporter : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context& context) override;
  void ReportRuns(const std::vector<Run>& runs) override;
  void Finalize() override;

 private:
  std::map<std::string, double> median_ns_;
};

}  // namespace sinew::bench
