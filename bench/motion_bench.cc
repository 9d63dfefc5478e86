#include <benchmark/benchmark.h>

#include "bench/inputs.h"
#include "sinew/motion/rest_to_rest.h"

namespace sinew::bench {
namespace {

struct Moves {
  Moves() {
    for (const Joint& joint : in.model.joints) {
      limits.push_back({joint.velocity_max, joint.acceleration_max, joint.jerk_max});
    }
  }
  SerialInputs in{"robot-arm-2"};
  std::vector<motion::AxisLimits> limits;
};

void rest_to_rest_6_axes(benchmark::State& state) {
  const Moves moves;
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t now = i++ % kInputs;
    benchmark::DoNotOptimize(motion::RestToRest(moves.in.q[now], moves.in.far[now], moves.limits));
  }
}
BENCHMARK(rest_to_rest_6_axes);

void sample_6_axes(benchmark::State& state) {
  const Moves moves;
  const motion::RestToRest plan(moves.in.q[0], moves.in.far[0], moves.limits);
  motion::AxisStates states;
  double t = 0;
  const double h = plan.duration() / 1000.5;
  for (auto _ : state) {
    plan.sample(t, states);
    t = t > plan.duration() ? 0 : t + h;
    benchmark::DoNotOptimize(states);
  }
}
BENCHMARK(sample_6_axes);

}  // namespace
}  // namespace sinew::bench
