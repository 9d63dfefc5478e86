#include "sinew/planning/paths/chords.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/pose.h"

namespace sinew::planning {
namespace {

/// A path that bends more than this is followed by chords of this length, m.
constexpr double kShortest = 1e-4;

}  // namespace

std::vector<double> chords(const ToolSpace& space, const PlannedPath& path, double tolerance,
                           double longest, const PoseBT& X_near) {
  std::vector<double> places;
  const JointPath& joints = path.joints;
  PoseBT X_last = X_near;
  PathPoint from, middle, to;
  const auto tool = [&](const JointArray& q) {
    const auto X_BT = space.forward({q.data(), space.size()}, X_last);
    if (X_BT) X_last = *X_BT;
    return X_last;
  };
  // How far the tool is off the path halfway along a chord.
  const auto off = [&](double begin, double end) {
    joints.sample(begin, from);
    joints.sample((begin + end) / 2, middle);
    joints.sample(end, to);
    JointArray q{};
    for (std::size_t j = 0; j < space.size(); ++j) q[j] = (from.q[j] + to.q[j]) / 2;
    const PoseBT X_on = tool(middle.q);
    const PoseBT X_chord = tool(q);
    return std::max(norm(X_on.p - X_chord.p), kTurnRadius * angle_between(X_on.R, X_chord.R));
  };
  double s = 0;
  const double length = joints.length();
  while (s < length) {
    double step = std::min(longest, length - s);
    while (step > kShortest && off(s, s + step) > tolerance) step /= 2;
    // What is left is shared evenly, so that no stump stays behind.
    const double left = length - s;
    step = left / std::ceil(left / step * (1 - 1e-9));
    s = std::min(s + step, length);
    if (length - s < kShortest) s = length;
    places.push_back(s);
  }
  return places;
}

}  // namespace sinew::planning
