#include "sinew/planning/timing/trajectory.h"

#include <algorithm>

namespace sinew::planning {

void sample_motion(const PlannedPath& path, const PathState& state, double jerk, std::size_t& hint,
                   JointMotion& out) {
  const double s = std::clamp(state.s, 0.0, path.joints.length());
  hint = path.joints.piece_at(s, hint);
  PathPoint at;
  path.joints.sample_piece(hint, s - path.joints.begin(hint), at);
  const double v = state.v;
  const double a = state.a;
  for (std::size_t j = 0; j < kMaxJoints; ++j) {
    out.q[j] = at.q[j];
    out.qd[j] = at.dq[j] * v;
    out.qdd[j] = at.ddq[j] * v * v + at.dq[j] * a;
    out.qddd[j] = at.dddq[j] * v * v * v + 3 * at.ddq[j] * v * a + at.dq[j] * jerk;
  }
}

void Trajectory::sample(double t, JointMotion& out) const {
  std::size_t hint = 0;
  sample_motion(*path_, law_->sample(t), law_->jerk(t), hint, out);
}

PathProgress Trajectory::progress_at(const PlannedPath& path, double s) {
  const double length = path.joints.length();
  s = std::clamp(s, 0.0, length);
  PathProgress result;
  result.way = s;
  result.path_share = length > 0 ? s / length : 1;
  if (path.sections.empty()) return result;
  const auto after =
      std::upper_bound(path.sections.begin(), path.sections.end(), s,
                       [](double at, const PathSection& section) { return at < section.begin; });
  const auto section = after == path.sections.begin() ? after : after - 1;
  // A move may have several sections, its blends with its neighbours among them.
  auto first = section;
  while (first != path.sections.begin() && (first - 1)->move == section->move) --first;
  auto last = section + 1;
  while (last != path.sections.end() && last->move == section->move) ++last;
  const double end = last == path.sections.end() ? length : last->begin;
  result.move = section->move;
  result.move_share = end > first->begin ? (s - first->begin) / (end - first->begin) : 1;
  return result;
}

}  // namespace sinew::planning
