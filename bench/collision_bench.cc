#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>

#include "bench/inputs.h"
#include "sinew/planning/collision/collision.h"

namespace sinew::bench {
namespace {

using planning::CollisionModel;
using planning::JointArray;
using planning::JointPath;

JointArray array_of(const JointVector& q) {
  JointArray values{};
  std::copy(q.begin(), q.end(), values.begin());
  return values;
}

/// The tool along 300 mm sideways with its attitude kept, a spline through a pose every 2.5 mm, as
/// a planned line is.
JointPath line_of_300_mm(const SerialInputs& in) {
  constexpr std::size_t kSteps = 120;
  constexpr double kStep = 2.5e-3;  // m
  JointVector q{0, from_deg(-20), from_deg(20), from_deg(10), from_deg(50), 0};
  kinematics::PoseBT X_BT = in.arm.forward(q);
  X_BT.p.y -= kSteps / 2 * kStep;
  std::vector<double> knots;
  std::vector<JointArray> points;
  for (std::size_t i = 0; i <= kSteps; ++i) {
    auto branches = *in.arm.inverse(X_BT, q);
    kinematics::sort_by_distance(branches, q);
    q = branches[0].q;
    knots.push_back(static_cast<double>(i) * kStep);
    points.push_back(array_of(q));
    X_BT.p.y += kStep;
  }
  JointArray first{}, last{};
  for (std::size_t k = 0; k < q.size(); ++k) {
    first[k] = (points[1][k] - points[0][k]) / kStep;
    last[k] = (points[kSteps][k] - points[kSteps - 1][k]) / kStep;
  }
  JointPath path(q.size());
  path.append_spline(knots, points, first, last);
  return path;
}

void collision_distance_6r(benchmark::State& state) {
  const SerialInputs in("robot-arm-2");
  const CollisionModel collision(in.model);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(collision.distance(in.q[i++ % kInputs]));
}
BENCHMARK(collision_distance_6r);

void collision_line_6r(benchmark::State& state) {
  const SerialInputs in("robot-arm-2");
  const CollisionModel collision(in.model);
  const JointPath path = line_of_300_mm(in);
  for (auto _ : state) {
    const auto contact = collision.check_path(path, collision.margin());
    if (contact) state.SkipWithError("the line is not clear");
    benchmark::DoNotOptimize(contact);
  }
}
BENCHMARK(collision_line_6r);

void collision_jog_6r(benchmark::State& state) {
  const SerialInputs in("robot-arm-2");
  const CollisionModel collision(in.model);
  JointVector qd;
  for (const Joint& joint : in.model.joints) qd.push_back(joint.velocity_max);
  std::size_t i = 0;
  for (auto _ : state) {
    const JointVector& q = in.q[i++ % kInputs];
    benchmark::DoNotOptimize(collision.speed_share(q, qd, collision.margin()));
  }
}
BENCHMARK(collision_jog_6r);

void collision_distance_hexapod(benchmark::State& state) {
  const RobotModel model = robot("hexapod");
  const CollisionModel collision(model);
  Numbers numbers;
  std::vector<JointVector> legs(kInputs);
  for (JointVector& q : legs) {
    for (const Joint& joint : model.joints) {
      q.push_back(joint.home + numbers.uniform(-0.02, 0.02));
    }
  }
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(collision.distance(legs[i++ % kInputs]));
}
BENCHMARK(collision_distance_hexapod);

}  // namespace
}  // namespace sinew::bench
