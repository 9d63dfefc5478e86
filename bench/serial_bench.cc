#include <benchmark/benchmark.h>

#include "bench/inputs.h"

namespace sinew::bench {
namespace {

void forward_6r(benchmark::State& state) {
  const SerialInputs in("robot-arm-2");
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(in.arm.chain().forward(in.q[i++ % kInputs]));
  }
}
BENCHMARK(forward_6r);

void forward_6r_portable(benchmark::State& state) {
  const SerialInputs in("robot-arm-2");
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(in.arm.chain().forward_portable(in.q[i++ % kInputs]));
  }
}
BENCHMARK(forward_6r_portable);

void forward_and_jacobian_6r(benchmark::State& state) {
  const SerialInputs in("robot-arm-2");
  std::size_t i = 0;
  kinematics::Jacobian J;
  for (auto _ : state) {
    benchmark::DoNotOptimize(in.arm.chain().forward(in.q[i++ % kInputs], J));
    benchmark::DoNotOptimize(J);
  }
}
BENCHMARK(forward_and_jacobian_6r);

void inverse(benchmark::State& state, std::string_view id) {
  const SerialInputs in(id);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(in.arm.inverse(in.X_BT[i++ % kInputs]));
  }
}
void inverse_6r_all_branches(benchmark::State& state) {
  inverse(state, "robot-arm-2");
}
void inverse_6r_portable(benchmark::State& state) {
  const SerialInputs in("robot-arm-2");
  const auto solver = kinematics::SixR::match(in.geometry, in.model.joints);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(solver->inverse_portable(in.X_BF[i++ % kInputs]));
  }
}
void inverse_5r_pitch(benchmark::State& state) {
  inverse(state, "learm");
}
void inverse_5r_roll(benchmark::State& state) {
  const SerialInputs in("bigrobotarm");
  const auto solver = kinematics::FiveRRoll::match(in.geometry, in.model.joints);
  std::size_t i = 0;
  for (auto _ : state) {
    const auto& X_BT = in.X_BT[i++ % kInputs];
    benchmark::DoNotOptimize(solver->inverse({X_BT.p, X_BT.R.z}));
  }
}
BENCHMARK(inverse_6r_all_branches);
BENCHMARK(inverse_6r_portable);
BENCHMARK(inverse_5r_pitch);
BENCHMARK(inverse_5r_roll);

void inverse_numeric(benchmark::State& state, const SerialInputs& in,
                     const std::vector<JointVector>& start) {
  std::size_t i = 0;
  std::size_t solved = 0;
  for (auto _ : state) {
    const std::size_t now = i++ % kInputs;
    const auto answer =
        kinematics::inverse_numeric(in.arm.chain(), in.model.joints, in.X_BF[now], start[now]);
    solved += answer.has_value();
  }
  state.counters["solved"] = static_cast<double>(solved) / static_cast<double>(i);
}
void inverse_numeric_near(benchmark::State& state) {
  const SerialInputs in("robot-arm-2");
  inverse_numeric(state, in, in.near);
}
void inverse_numeric_far(benchmark::State& state) {
  const SerialInputs in("robot-arm-2");
  inverse_numeric(state, in, in.far);
}
BENCHMARK(inverse_numeric_near);
BENCHMARK(inverse_numeric_far);

}  // namespace
}  // namespace sinew::bench
