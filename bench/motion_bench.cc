#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <vector>

#include "bench/inputs.h"
#include "sinew/motion/rest_to_rest.h"
#include "sinew/motion/synchronised.h"

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

/// From states under way to states under way, all joints with velocity and acceleration.
struct StateMoves : Moves {
  StateMoves() {
    Numbers numbers;
    for (const motion::AxisLimits& limit : limits) bounds.emplace_back(limit);
    for (std::size_t i = 0; i < kInputs; ++i) {
      start.push_back(states(numbers, in.q[i]));
      target.push_back(states(numbers, in.far[i]));
    }
  }
  std::vector<motion::AxisState> states(Numbers& numbers, const JointVector& q) const {
    std::vector<motion::AxisState> result;
    for (std::size_t j = 0; j < q.size(); ++j) {
      const auto& [velocity, acceleration, jerk] = limits[j];
      motion::AxisState state{q[j], 0, numbers.uniform(-0.7, 0.7) * acceleration};
      // What a joint with this acceleration can still hold or have come from.
      const double margin = state.qdd * state.qdd / (2 * jerk);
      if (margin > 0.9 * velocity) state.qdd = 0;
      const double most = state.qdd == 0 ? velocity : velocity - margin;
      state.qd = numbers.uniform(-0.9, 0.9) * most;
      result.push_back(state);
    }
    return result;
  }
  std::vector<motion::ProfileBounds> bounds;
  std::vector<std::vector<motion::AxisState>> start, target;
};

const StateMoves& state_moves() {
  static const StateMoves moves;
  return moves;
}

void state_to_state_6_axes(benchmark::State& state) {
  const StateMoves& moves = state_moves();
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t now = i++ % kInputs;
    benchmark::DoNotOptimize(
        motion::plan_motion(moves.start[now], moves.target[now], moves.bounds));
  }
}
BENCHMARK(state_to_state_6_axes);

/// How long each input takes when nothing else disturbs it: the best of several runs, so that what
/// is left is the input's own doing and not another process's.
const std::vector<double>& state_to_state_times() {
  static const std::vector<double> sorted = [] {
    using Clock = std::chrono::steady_clock;
    const StateMoves& moves = state_moves();
    std::vector<double> best(kInputs, INFINITY);
    for (int run = 0; run < 15; ++run) {
      for (std::size_t i = 0; i < kInputs; ++i) {
        const auto begin = Clock::now();
        benchmark::DoNotOptimize(
            motion::plan_motion(moves.start[i], moves.target[i], moves.bounds));
        const std::chrono::duration<double, std::nano> time = Clock::now() - begin;
        best[i] = std::min(best[i], time.count());
      }
    }
    std::sort(best.begin(), best.end());
    return best;
  }();
  return sorted;
}

void state_to_state_6_axes_p99(benchmark::State& state) {
  for (auto _ : state) state.counters["ns"] = state_to_state_times()[kInputs * 99 / 100];
}
BENCHMARK(state_to_state_6_axes_p99)->Iterations(1);

void state_to_state_6_axes_worst(benchmark::State& state) {
  for (auto _ : state) state.counters["ns"] = state_to_state_times().back();
}
BENCHMARK(state_to_state_6_axes_worst)->Iterations(1);

void velocity_retarget_6_axes(benchmark::State& state) {
  const StateMoves& moves = state_moves();
  std::vector<std::vector<double>> velocities(kInputs);
  for (std::size_t i = 0; i < kInputs; ++i) {
    for (const motion::AxisState& target : moves.target[i]) velocities[i].push_back(target.qd);
  }
  std::size_t i = 0;
  for (auto _ : state) {
    const std::size_t now = i++ % kInputs;
    benchmark::DoNotOptimize(
        motion::plan_velocity(moves.start[now], velocities[now], moves.bounds));
  }
}
BENCHMARK(velocity_retarget_6_axes);

void sample_state_to_state_6_axes(benchmark::State& state) {
  const StateMoves& moves = state_moves();
  const auto plan = motion::plan_motion(moves.start[0], moves.target[0], moves.bounds);
  motion::AxisStates states;
  double t = 0;
  const double h = plan->duration() / 1000.5;
  for (auto _ : state) {
    plan->sample(t, states);
    t = t > plan->duration() ? 0 : t + h;
    benchmark::DoNotOptimize(states);
  }
}
BENCHMARK(sample_state_to_state_6_axes);

}  // namespace
}  // namespace sinew::bench
