#include <benchmark/benchmark.h>

#include <cmath>

#include "bench/inputs.h"
#include "sinew/planning/collision/collision.h"
#include "sinew/planning/paths/move_path.h"
#include "sinew/planning/timing/path_follower.h"

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

/// The same as a law that can be changed on the way.
void path_timing_changeable_100_pieces(benchmark::State& state) {
  const Waves waves;
  planning::PathTiming timing(4 * Waves::kPieces);
  planning::TimeLaw law(timing.phases_max());
  for (auto _ : state) {
    if (timing.prepare(waves.path, waves.limits, 1, planning::LawUse::kChangeable) ||
        timing.plan({}, 1, law))
      state.SkipWithError("");
    benchmark::DoNotOptimize(law);
  }
}
BENCHMARK(path_timing_changeable_100_pieces);

/// A line of 300 mm of the tool: made and checked for limits, checked for contact, and timed.
void planned_line_300mm_6r(benchmark::State& state) {
  const RobotModel model = robot("robot-arm-2");
  const planning::ToolSpace space(model);
  planning::MovePathBuilder builder(space);
  const planning::CollisionModel collision(model);
  planning::PlannedPath path(space.size());
  planning::PathTiming timing;
  planning::TimeLaw law(timing.phases_max());
  std::vector<motion::AxisLimits> limits;
  for (const Joint& joint : model.joints) {
    limits.push_back({joint.velocity_max, joint.acceleration_max, joint.jerk_max});
  }
  const planning::JointArray q{0, from_deg(-30), from_deg(30), 0, from_deg(60), 0};
  const auto from = *builder.place_at({q.data(), space.size()}, space.home());
  const planning::Move line{
      .way = planning::MoveL{
          {{from.X_BT.R, from.X_BT.p + Vec3{-0.05, 0.29, -0.05}}, planning::Asked::kPoint}}};
  for (auto _ : state) {
    if (!builder.build(from, {&line, 1}, 0, path) ||
        collision.check_path(path.joints, collision.margin()) || timing.prepare(path, limits) ||
        timing.plan({}, 1, law)) {
      state.SkipWithError("refused");
    }
    benchmark::DoNotOptimize(law);
  }
}
BENCHMARK(planned_line_300mm_6r);

/// On its way, in a law that can be changed.
struct UnderWay {
  explicit UnderWay(double share) {
    if (timing.prepare(waves.path, waves.limits, 2, planning::LawUse::kChangeable) ||
        timing.plan({}, 1, law))
      std::abort();
    start = law.sample(law.duration() * share);
  }
  Waves waves;
  planning::PathTiming timing{4 * Waves::kPieces};
  planning::TimeLaw law{timing.phases_max()};
  planning::TimeLaw next{timing.phases_max()};
  planning::PathState start;
};

void path_replan_100_pieces(benchmark::State& state) {
  UnderWay motion(0.25);
  double feed = 0.5;
  for (auto _ : state) {
    feed = 1.5 - feed;
    if (motion.timing.plan(motion.start, feed, motion.next)) state.SkipWithError("");
    benchmark::DoNotOptimize(motion.next);
  }
}
BENCHMARK(path_replan_100_pieces);

/// To rest from the middle of it.
void path_stop_100_pieces(benchmark::State& state) {
  UnderWay motion(0.5);
  for (auto _ : state) {
    if (motion.timing.stop(motion.start, motion.next)) state.SkipWithError("");
    benchmark::DoNotOptimize(motion.next);
  }
}
BENCHMARK(path_stop_100_pieces);

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
