#include <benchmark/benchmark.h>

#include <cmath>

#include "bench/inputs.h"
#include "sinew/planning/path_follower.h"

namespace sinew::bench {
namespace {

/// Six joints of robot-arm-2 along waves of 100 pieces, their limits sharpened so that all of them
/// bind somewhere.
struct Waves {
  Waves() {
    const SerialInputs in("robot-arm-2");
    for (const Joint& joint : in.model.joints) {
      limits.push_back({joint.velocity_max, 10 * joint.acceleration_max, 100 * joint.jerk_max});
    }
    std::vector<double> knots;
    std::vector<planning::JointArray> points;
    planning::JointArray slopes[2] = {};
    for (std::size_t i = 0; i <= kPieces; ++i) {
      const double s = 0.01 * static_cast<double>(i);
      knots.push_back(s);
      planning::JointArray q{};
      for (std::size_t j = 0; j < 6; ++j) {
        const double rate = 2 + static_cast<double>(j);
        q[j] = 0.3 * std::sin(rate * s);
        if (i == 0) slopes[0][j] = 0.3 * rate;
        if (i == kPieces) slopes[1][j] = 0.3 * rate * std::cos(rate * s);
      }
      points.push_back(q);
    }
    path.joints.append_spline(knots, points, slopes[0], slopes[1]);
    path.tool.assign(kPieces, {1, 1});
    path.sections.push_back({0, 0, 0.25, 1, 1});
  }

  static constexpr std::size_t kPieces = 100;
  planning::PlannedPath path{6, kPieces};
  std::vector<motion::AxisLimits> limits;
};

void path_timing_100_pieces(benchmark::State& state) {
  const Waves waves;
  planning::PathTiming timing(4 * Waves::kPieces);
  planning::TimeLaw law(timing.phases_max());
  for (auto _ : state) {
    if (timing.prepare(waves.path, waves.limits) || timing.plan({}, 1, law))
      state.SkipWithError("");
    benchmark::DoNotOptimize(law);
  }
}
BENCHMARK(path_timing_100_pieces);

void path_replan_100_pieces(benchmark::State& state) {
  const Waves waves;
  planning::PathTiming timing(4 * Waves::kPieces);
  planning::TimeLaw law(timing.phases_max());
  planning::TimeLaw next(timing.phases_max());
  if (timing.prepare(waves.path, waves.limits, 2) || timing.plan({}, 1, law)) std::abort();
  const planning::PathState start = law.sample(law.duration() / 4);
  double feed = 0.5;
  for (auto _ : state) {
    feed = 1.5 - feed;
    if (timing.plan(start, feed, next)) state.SkipWithError("");
    benchmark::DoNotOptimize(next);
  }
}
BENCHMARK(path_replan_100_pieces);

void trajectory_sample_6_joints(benchmark::State& state) {
  const Waves waves;
  planning::PathTiming timing(4 * Waves::kPieces);
  planning::TimeLaw law(timing.phases_max());
  if (timing.prepare(waves.path, waves.limits) || timing.plan({}, 1, law)) std::abort();
  const planning::Trajectory trajectory(waves.path, law);
  planning::JointMotion motion;
  double t = 0;
  const double h = law.duration() / 1000.5;
  for (auto _ : state) {
    trajectory.sample(t, motion);
    t = t > law.duration() ? 0 : t + h;
    benchmark::DoNotOptimize(motion);
  }
}
BENCHMARK(trajectory_sample_6_joints);

}  // namespace
}  // namespace sinew::bench
