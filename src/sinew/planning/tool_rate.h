#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "sinew/core/vec3.h"
#include "sinew/planning/planned_path.h"

namespace sinew::planning {

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
  return rate;
}

}  // namespace sinew::planning
