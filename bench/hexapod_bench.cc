#include <benchmark/benchmark.h>

#include "bench/inputs.h"
#include "sinew/kinematics/hexapod.h"
#include "sinew/kinematics/palletizer.h"

namespace sinew::bench {
namespace {

using kinematics::PoseBP;

/// Poses of the platform about its home, their legs, and starts a little and a lot beside them.
struct HexapodInputs {
  HexapodInputs()
      : model(robot("hexapod")),
        geometry(std::get<HexapodGeometry>(model.geometry)),
        hexapod(geometry) {
    Numbers numbers;
    for (std::size_t i = 0; i < kInputs; ++i) {
      X_BP.push_back(beside(geometry.X_BP_home, numbers, 0.020, 0.2));
      legs.push_back(hexapod.inverse(X_BP.back()));
      warm.push_back(beside(X_BP.back(), numbers, 0.0003, 0.003));
      cold.push_back(beside(X_BP.back(), numbers, 0.020, 0.2));
    }
  }

  static PoseBP beside(const PoseBP& X, Numbers& numbers, double length, double angle) {
    const auto vector = [&](double size) {
      return Vec3{numbers.uniform(-size, size), numbers.uniform(-size, size),
                  numbers.uniform(-size, size)};
    };
    return {rotation_from_vector(vector(angle)) * X.R, X.p + vector(length)};
  }

  RobotModel model;
  HexapodGeometry geometry;
  kinematics::Hexapod hexapod;
  std::vector<PoseBP> X_BP, warm, cold;
  std::vector<JointVector> legs;
};

void hexapod_inverse(benchmark::State& state) {
  const HexapodInputs in;
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(in.hexapod.inverse(in.X_BP[i++ % kInputs]));
  }
}
BENCHMARK(hexapod_inverse);

void hexapod_forward(benchmark::State& state, const HexapodInputs& in,
                     const std::vector<PoseBP>& start) {
  std::size_t i = 0;
  std::size_t solved = 0;
  double iterations = 0;
  for (auto _ : state) {
    const std::size_t now = i++ % kInputs;
    const auto answer = in.hexapod.forward(in.legs[now], start[now]);
    if (!answer) continue;
    ++solved;
    iterations += answer->iterations;
  }
  state.counters["solved"] = static_cast<double>(solved) / static_cast<double>(i);
  state.counters["iterations"] = iterations / static_cast<double>(i);
}
void hexapod_forward_warm(benchmark::State& state) {
  const HexapodInputs in;
  hexapod_forward(state, in, in.warm);
}
void hexapod_forward_cold(benchmark::State& state) {
  const HexapodInputs in;
  hexapod_forward(state, in, in.cold);
}
BENCHMARK(hexapod_forward_warm);
BENCHMARK(hexapod_forward_cold);

void inverse_palletizer(benchmark::State& state) {
  const RobotModel model = robot("maxarm");
  const auto& geometry = std::get<PalletizerGeometry>(model.geometry);
  Numbers numbers;
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < kInputs; ++i) {
    points.push_back(kinematics::forward(geometry, random_joints(numbers, model)).p);
  }
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(kinematics::inverse(geometry, model.joints, points[i++ % kInputs]));
  }
}
BENCHMARK(inverse_palletizer);

}  // namespace
}  // namespace sinew::bench
