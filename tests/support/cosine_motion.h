#pragma once

#include <cmath>
#include <cstddef>
#include <span>

#include "sinew/core/units.h"
#include "sinew/driver/driver.h"

namespace sinew::test {

/// A whole motion of a streaming driver, in segments along a cosine.
struct CosineMotion {
  JointVector from, to;
  double seconds = 1;
  std::size_t segments = 1;
  std::size_t next = 1;
  Instant begun{};

  CosineMotion(std::span<const JointPosition> positions, const JointVector& end, double duration,
               double segment, Instant now)
      : to(end),
        seconds(duration),
        segments(static_cast<std::size_t>(std::lround(duration / segment))),
        begun(now) {
    for (const JointPosition& joint : positions) from.push_back(joint.q);
  }

  JointMove piece() const {
    const double u = static_cast<double>(next) / static_cast<double>(segments);
    JointMove move;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const double way = to[i] - from[i];
      move.q.push_back(from[i] + way * (1 - std::cos(kPi * u)) / 2);
      const bool last = next == segments;
      move.qd.push_back(last ? 0 : way * kPi / 2 * std::sin(kPi * u) / seconds);
    }
    move.duration = from_seconds(seconds / static_cast<double>(segments));
    return move;
  }
};

}  // namespace sinew::test
