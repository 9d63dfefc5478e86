#include <benchmark/benchmark.h>

#include <vector>

#include "bench/inputs.h"
#include "sinew/planning/paths/move_path.h"

namespace sinew::bench {
namespace {

using planning::JointArray;
using planning::Move;
using planning::MoveL;

/// A robot, where it stands, and room for a path.
struct PathInputs {
  PathInputs(std::string_view id, const JointArray& q)
      : model(robot(id)), space(model), builder(space), path(space.size()) {
    from = *builder.place_at({q.data(), space.size()}, space.home());
  }
  /// A straight line by `way` (m, in base), the tool as it is.
  Move line(const Vec3& way) const {
    return {.way = MoveL{{{from.X_BT.R, from.X_BT.p + way}, planning::Asked::kPoint}}};
  }

  RobotModel model;
  planning::ToolSpace space;
  planning::MovePathBuilder builder;
  planning::PlannedPath path;
  planning::RobotPlace from;
};

void build(benchmark::State& state, PathInputs& in, const std::vector<Move>& moves) {
  for (auto _ : state) {
    const auto stretch = in.builder.build(in.from, moves, 0, in.path);
    if (!stretch) {
      state.SkipWithError("refused");
      return;
    }
    benchmark::DoNotOptimize(stretch);
  }
  state.counters["pieces"] = static_cast<double>(in.path.joints.size());
}

const JointArray kBent6r{0, from_deg(-30), from_deg(30), 0, from_deg(60), 0};

void move_path_line_300mm_6r(benchmark::State& state) {
  PathInputs in("robot-arm-2", kBent6r);
  build(state, in, {in.line({-0.05, 0.29, -0.05})});
}
BENCHMARK(move_path_line_300mm_6r);

void move_path_line_60mm_5r_pitch(benchmark::State& state) {
  PathInputs in("learm", {0, from_deg(25), from_deg(70), from_deg(60), 0});
  build(state, in, {in.line({0, 0.06, 0})});
}
BENCHMARK(move_path_line_60mm_5r_pitch);

void move_path_line_100mm_palletizer(benchmark::State& state) {
  PathInputs in("maxarm", {from_deg(120), from_deg(90), from_deg(10)});
  build(state, in, {in.line({0.1, 0, 0})});
}
BENCHMARK(move_path_line_100mm_palletizer);

void move_path_line_30mm_hexapod(benchmark::State& state) {
  const RobotModel model = robot("hexapod");
  const planning::ToolSpace space(model);
  PathInputs in("hexapod", *space.inverse_near(space.point(space.home()), {}));
  build(state, in, {in.line({0.03, 0, 0})});
}
BENCHMARK(move_path_line_30mm_hexapod);

void move_path_square_with_blends_6r(benchmark::State& state) {
  PathInputs in("robot-arm-2", kBent6r);
  std::vector<Move> moves{in.line({0, 0.1, 0}), in.line({0, 0.1, -0.1}), in.line({0, 0, -0.1}),
                          in.line({0, 0, 0})};
  for (Move& move : moves) move.blend_radius = 0.02;
  build(state, in, moves);
}
BENCHMARK(move_path_square_with_blends_6r);

}  // namespace
}  // namespace sinew::bench
