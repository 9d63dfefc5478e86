#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sinew/planning/timing/path_check.h"
#include "sinew/planning/timing/path_timing.h"
#include "support/property.h"

namespace sinew::planning::test_paths {

using test::Random;

inline double ten_to(Random& random, double lower, double upper) {
  return std::pow(10, random.uniform(lower, upper));
}

/// A path and the limits of what goes along it.
struct Case {
  PlannedPath path;
  std::vector<motion::AxisLimits> limits;
};

/// A smooth random way through `ways` + 1 points, in `pieces` pieces each, as a planner would make
/// it.
inline Case random_spline(Random& random, std::size_t joints, std::size_t ways, std::size_t pieces,
                          double reach) {
  JointPath coarse(joints, ways);
  std::vector<double> knots{0};
  std::vector<JointArray> points{{}};
  for (std::size_t i = 0; i < ways; ++i) {
    JointArray next = points.back();
    for (std::size_t j = 0; j < joints; ++j) next[j] += reach * random.uniform(-1, 1);
    knots.push_back(knots.back() + random.uniform(0.05, 0.2));
    points.push_back(next);
  }
  const auto slope = [&](std::size_t i) {
    JointArray dq{};
    for (std::size_t j = 0; j < joints; ++j) {
      dq[j] = (points[i + 1][j] - points[i][j]) / (knots[i + 1] - knots[i]);
    }
    return dq;
  };
  coarse.append_spline(knots, points, slope(0), slope(ways - 1));

  const std::size_t n = ways * pieces;
  Case result{PlannedPath(joints, n), {}};
  std::vector<double> fine;
  std::vector<JointArray> q;
  PathPoint at;
  for (std::size_t i = 0; i <= n; ++i) {
    fine.push_back(coarse.length() * static_cast<double>(i) / static_cast<double>(n));
    coarse.sample(fine.back(), at);
    q.push_back(at.q);
  }
  coarse.sample(0, at);
  const JointArray first = at.dq;
  coarse.sample(coarse.length(), at);
  result.path.joints.append_spline(fine, q, first, at.dq);
  result.path.tool.assign(n, {1, random.uniform(0, 3)});
  result.path.sections.push_back({});
  for (std::size_t j = 0; j < joints; ++j) {
    const double velocity = ten_to(random, -0.5, 0.5);
    const double acceleration = velocity * ten_to(random, 0, 1);
    result.limits.push_back({velocity, acceleration, acceleration * ten_to(random, 0.5, 1.7)});
  }
  return result;
}

inline Case random_case(Random& random, std::size_t pieces = 20) {
  const auto joints = static_cast<std::size_t>(random.integer(2, 6));
  const auto ways = static_cast<std::size_t>(random.integer(2, 7));
  Case result = random_spline(random, joints, ways, pieces, ten_to(random, -1.5, -0.5));
  PathSection& section = result.path.sections[0];
  if (random.chance(0.5)) {
    section.tool_speed = ten_to(random, -1.5, 0);
    section.tool_acceleration = ten_to(random, -1, 1);
  }
  section.joint_share = random.chance(0.5) ? 1 : random.uniform(0.2, 1);
  // Another section from the middle of the path on.
  if (random.chance(0.5)) {
    PathSection second = section;
    second.begin = result.path.joints.length() * random.uniform(0.1, 0.9);
    second.move = 1;
    second.tool_speed = ten_to(random, -1.5, 0);
    result.path.sections.push_back(second);
  }
  return result;
}

/// A straight line in joint space, in pieces.
inline Case straight(std::vector<double> to, std::vector<motion::AxisLimits> limits, double length,
                     std::size_t pieces = 1) {
  Case result{PlannedPath(to.size(), pieces), std::move(limits)};
  std::vector<double> from(to.size(), 0.0);
  double done = 0;
  for (std::size_t i = 1; i <= pieces; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(pieces);
    std::vector<double> next = to;
    for (double& q : next) q *= share;
    result.path.joints.append_line(from, next, length * (share - done));
    result.path.tool.push_back({1, 0});
    from = next, done = share;
  }
  result.path.sections.push_back({});
  return result;
}

/// The largest jump between a phase's end and the next one's beginning.
inline PathState largest_jump(const TimeLaw& law) {
  PathState worst;
  const auto phases = law.phases();
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const bool last = i + 1 == phases.size();
    const double end = last ? law.duration() : phases[i + 1].t;
    const PathState next = last ? law.end() : phases[i + 1].state;
    const PathState here = advanced(phases[i].state, phases[i].jerk, end - phases[i].t);
    worst.s = std::max(worst.s, std::abs(here.s - next.s));
    worst.v = std::max(worst.v, std::abs(here.v - next.v));
    worst.a = std::max(worst.a, std::abs(here.a - next.a));
  }
  return worst;
}

}  // namespace sinew::planning::test_paths
