#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <vector>

#include "bench/inputs.h"
#include "sinew/motion/step_runs.h"
#include "sinew/motion/step_segments.h"
#include "sinew/motion/step_timing.h"

namespace sinew::bench {
namespace {

using motion::JerkPhase;
using motion::StepSegment;

constexpr std::size_t kMoves = 64;
constexpr std::size_t kSegmentsMax = 8192;

/// Random moves of one axis of robot-arm-2, 16 microsteps of 200 behind 17:1, and how many steps
/// each has. An iteration of these rows is one step.
struct StepInputs {
  /// @param piece  s: cut into cubics of this length, as a spline is; 0: seven phases of a move
  explicit StepInputs(double piece) {
    Numbers numbers;
    for (std::size_t i = 0; i < kMoves; ++i) {
      const double q = numbers.uniform(-2.9, 2.9);
      const double target = numbers.uniform(-2.9, 2.9);
      const auto move =
          motion::plan_axis(std::abs(target - q), {from_deg(29.5), from_deg(10), from_deg(10)});
      moves.emplace_back();
      for (const JerkPhase& phase : motion::jerk_phases(move, q, target - q)) add(phase, piece);
      motion::StepSegments converter(hardware, q);
      segments.emplace_back(kSegmentsMax);
      segments.back().resize(*converter.convert(moves.back(), segments.back()));
      steps.push_back(std::abs(converter.steps() - converter.start_steps()));
    }
  }
  void add(const JerkPhase& phase, double piece) {
    for (double t = 0; t < phase.duration;) {
      const double length = piece > 0 ? std::min(piece, phase.duration - t) : phase.duration;
      moves.back().push_back({motion::advanced(phase.start, phase.jerk, t), phase.jerk, length});
      t += length;
    }
  }
  motion::StepHardware hardware{.steps_per_unit = 3200 * 17 / (2 * kPi)};
  std::vector<std::vector<JerkPhase>> moves;
  std::vector<std::vector<StepSegment>> segments;
  std::vector<std::int64_t> steps;
};

/// From the plan to bytes, every step checked.
void compressed(benchmark::State& state, double piece) {
  const StepInputs in(piece);
  motion::StepRuns compressor({.tolerance = 25}, kSegmentsMax);
  std::vector<StepSegment> segments(kSegmentsMax);
  std::vector<motion::StepRun> runs(kSegmentsMax);
  std::array<std::uint8_t, motion::StepRunCode::kBytesMax> bytes{};
  std::size_t i = 0;
  double sent = 0;
  double steps = 0;
  while (state.KeepRunningBatch(in.steps[i % kMoves])) {
    const auto& move = in.moves[i % kMoves];
    motion::StepSegments converter(in.hardware, move[0].start.q);
    const std::size_t size = *converter.convert(move, segments);
    const std::size_t count =
        *compressor.compress({segments.data(), size}, converter.start_offset(), 0, runs);
    motion::StepRunCode code;
    for (std::size_t k = 0; k < count; ++k) {
      sent += static_cast<double>(code.encode(runs[k], bytes));
    }
    steps += static_cast<double>(in.steps[i % kMoves]);
    ++i;
  }
  state.counters["bytes_per_step"] = sent / steps;
}

void steps_compressed(benchmark::State& state) {
  compressed(state, 0);
}
BENCHMARK(steps_compressed);

void steps_compressed_spline(benchmark::State& state) {
  compressed(state, 0.01);
}
BENCHMARK(steps_compressed_spline);

/// The axis' part, which small processors do in integers: here as a host does it.
void steps_timed(benchmark::State& state) {
  const StepInputs in(0);
  std::size_t i = 0;
  while (state.KeepRunningBatch(in.steps[i % kMoves])) {
    motion::StepTimer timer;
    motion::TimedStep step;
    for (const StepSegment& segment : in.segments[i % kMoves]) {
      timer.load(segment);
      while (timer.next(step)) benchmark::DoNotOptimize(step);
    }
    ++i;
  }
}
BENCHMARK(steps_timed);

}  // namespace
}  // namespace sinew::bench
