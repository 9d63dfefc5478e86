#include "sinew/planning/timing/path_check.h"

#include <algorithm>
#include <cmath>

namespace sinew::planning {
namespace {

// Of the path's length: where a phase ends on a border of the path, it ends there but for rounding.
constexpr double kBorder = 1e-11;

struct Load {
  const PlannedPath& path;
  std::span<const motion::AxisLimits> limits;
  double feed;
  double shared_velocity;
  PathLoad worst{};
  std::size_t section = 0;

  void add(std::size_t piece, const PathState& state, double jerk) {
    const double begin = path.joints.begin(piece);
    PathPoint at;
    path.joints.sample_piece(piece,
                             std::clamp(state.s, begin, path.joints.begin(piece + 1)) - begin, at);
    const auto raise = [](double& value, double other) { value = std::max(value, other); };
    const auto& [s, v, a] = state;
    const double share = std::min(1.0, path.sections[section].joint_share * feed);
    double speeds = 0;
    for (std::size_t j = 0; j < limits.size(); ++j) {
      const double qd = at.dq[j] * v;
      const double qdd = at.ddq[j] * v * v + at.dq[j] * a;
      const double qddd = at.dddq[j] * v * v * v + 3 * at.ddq[j] * v * a + at.dq[j] * jerk;
      speeds += std::abs(qd);
      raise(worst.velocity[j], std::abs(qd) / (share * limits[j].velocity));
      raise(worst.acceleration[j], std::abs(qdd) / limits[j].acceleration);
      raise(worst.jerk[j], std::abs(qddd) / limits[j].jerk);
    }
    raise(worst.shared, speeds / (share * shared_velocity));
    const PathSection& asked = path.sections[section];
    const ToolRate& tool = path.tool[piece];
    raise(worst.tool_speed, tool.speed * v / (asked.tool_speed * feed));
    raise(worst.tool_acceleration,
          (tool.curvature * v * v + tool.speed * std::abs(a)) / asked.tool_acceleration);
  }
};

}  // namespace

double PathLoad::worst() const {
  double result = std::max({tool_speed, tool_acceleration, shared});
  for (std::size_t j = 0; j < kMaxJoints; ++j) {
    result = std::max({result, velocity[j], acceleration[j], jerk[j]});
  }
  return result;
}

PathLoad check(const PlannedPath& path, const TimeLaw& law,
               std::span<const motion::AxisLimits> limits, double feed, int samples,
               double shared_velocity) {
  Load load{path, limits, feed, shared_velocity};
  const auto phases = law.phases();
  const auto section_at = [&](double s) {
    std::size_t i = 0;
    const auto after =
        std::upper_bound(path.sections.begin(), path.sections.end(), s,
                         [](double at, const PathSection& section) { return at < section.begin; });
    if (after != path.sections.begin())
      i = static_cast<std::size_t>(after - path.sections.begin()) - 1;
    return i;
  };
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const LawPhase& phase = phases[i];
    const double end = i + 1 < phases.size() ? phases[i + 1].t : law.duration();
    // The phase in parts that each lie on one piece of the path and in one section: both ends of a
    // part belong to it.
    double t = 0;
    while (t < end - phase.t) {
      const auto s_at = [&](double time) { return advanced(phase.state, phase.jerk, time).s; };
      const double begin = s_at(t);
      const std::size_t piece = path.joints.piece_at(begin + kBorder * path.joints.length());
      load.section = section_at(begin + kBorder * path.joints.length());
      double border = path.joints.begin(piece + 1);
      if (load.section + 1 < path.sections.size()) {
        border = std::min(border, path.sections[load.section + 1].begin);
      }
      double to = end - phase.t;
      if (piece + 1 < path.joints.size() || border < path.joints.length()) {
        if (s_at(to) > border + kBorder * path.joints.length()) {
          double low = t;
          while (true) {
            const double middle = low + (to - low) / 2;
            if (!(middle > low && middle < to)) break;
            (s_at(middle) <= border ? low : to) = middle;
          }
        }
      }
      for (int k = 0; k <= samples; ++k) {
        const double time = t + (to - t) * k / samples;
        load.add(piece, advanced(phase.state, phase.jerk, time), phase.jerk);
      }
      t = to;
    }
  }
  return load.worst;
}

}  // namespace sinew::planning
