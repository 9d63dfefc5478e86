#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "sinew/core/vec3.h"
#include "sinew/planning/paths/planned_path.h"

namespace sinew::planning {

/// How fast a tool is at the first of at least four places, in even steps of the path, by the cubic
/// through them and the quarter of what a fifth says that it is wrong by. Where a speed rises ever
/// faster towards an end, what the chords say of it falls short.
/// @param at  place i, counted from that end
/// @rt
template <class At>
double end_speed(const At& at, std::size_t places, double step) {
  const Vec3 cubic = 1.0 / 6 * (18 * at(1) - 11 * at(0) - 9 * at(2) + 2 * at(3));
  double speed = norm(cubic);
  if (places > 4) {
    speed += norm(at(0) - 4 * at(1) + 6 * at(2) - 4 * at(3) + at(4)) / 4;
  }
  return speed / step;
}

/// What a tool does along places that follow each other in even steps of the path: bounds, where
/// what lies between the places adds the half of what changes from one to the next, and the bow
/// that a chord cuts off. The first and the last place lie one step off the bends next to them,
/// which are means over two steps: there the whole of what these change by is added.
/// @param p     m, at least two
/// @param step  of s between them
/// @rt
inline ToolRate tool_rate(std::span<const Vec3> p, double step) {
  ToolRate rate;
  double change = 0;
  double last = 0;
  double bend_change = 0;
  Vec3 bend_last;
  for (std::size_t i = 0; i + 1 < p.size(); ++i) {
    const double speed = norm(p[i + 1] - p[i]) / step;
    rate.speed = std::max(rate.speed, speed);
    if (i > 0) {
      const Vec3 bend = (p[i + 1] - p[i]) - (p[i] - p[i - 1]);
      rate.curvature = std::max(rate.curvature, norm(bend) / (step * step));
      if (i > 1) bend_change = std::max(bend_change, norm(bend - bend_last) / (step * step));
      bend_last = bend;
      change = std::max(change, std::abs(speed - last));
    }
    last = speed;
  }
  rate.curvature += bend_change;
  const double turn = rate.curvature * step;
  if (rate.speed > 0) rate.speed += std::min(turn * turn / (24 * rate.speed), turn / 2);
  rate.speed += change / 2;
  if (p.size() > 3) {
    const auto from_end = [&](std::size_t i) { return p[p.size() - 1 - i]; };
    const double first = end_speed([&](std::size_t i) { return p[i]; }, p.size(), step);
    rate.speed = std::max({rate.speed, first, end_speed(from_end, p.size(), step)});
  }
  return rate;
}

}  // namespace sinew::planning
