#pragma once

#include "sinew/planning/paths/planned_path.h"
#include "sinew/planning/timing/time_law.h"

namespace sinew::planning {

/// All joints at one instant: q in rad (or m) and its derivatives with respect to time.
struct JointMotion {
  JointArray q{};
  JointArray qd{};
  JointArray qdd{};
  JointArray qddd{};
};

/// The joints on `path` while s moves as `state`. @param hint  the piece to look at first; comes
/// back as the one it was. @rt
void sample_motion(const PlannedPath& path, const PathState& state, double jerk, std::size_t& hint,
                   JointMotion& out);

/// How far a motion has come.
struct PathProgress {
  std::size_t move = 0;   ///< of those that were asked for, from 0
  double move_share = 0;  ///< of that move's way, 0..1
  double way = 0;         ///< s, from the beginning of the path
  double path_share = 0;  ///< of the whole way, 0..1
};

/// A path and the law by which it is taken; both stay alive elsewhere. Sampling is @rt.
class Trajectory {
 public:
  Trajectory(const PlannedPath& path, const TimeLaw& law) : path_(&path), law_(&law) {}

  double duration() const { return law_->duration(); }  ///< s
  const PlannedPath& path() const { return *path_; }
  const TimeLaw& law() const { return *law_; }

  /// At t (s), held at both ends.
  void sample(double t, JointMotion& out) const;
  PathProgress progress(double t) const { return progress_at(*path_, law_->sample(t).s); }

  static PathProgress progress_at(const PlannedPath& path, double s);

 private:
  const PlannedPath* path_;
  const TimeLaw* law_;
};

}  // namespace sinew::planning
