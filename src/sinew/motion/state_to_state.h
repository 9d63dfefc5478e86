#pragma once

#include <array>
#include <optional>

#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/motion/farthest.h"
#include "sinew/motion/joint_profile.h"

namespace sinew::motion {

/// kMotionInput where a value is not finite or bounds are out of order. @rt
std::optional<Error> refusal(const AxisState& start, const ProfileBounds& bounds);
/// Also kTargetVelocity and kTargetAcceleration: the target is outside the bounds, or cannot be
/// reached from rest or be left to rest inside them. @rt
std::optional<Error> refusal_of_target(const AxisState& target, const ProfileBounds& bounds);

/// Phases of full jerk that bring a state back inside its bounds, and the state after them. A state
/// is inside where acceleration and velocity are, and the velocity stays so if the acceleration is
/// taken back to 0 at once.
struct Recovery {
  struct Phase {
    double jerk = 0;
    double duration = 0;  ///< s
  };
  FixedVector<Phase, 5> phases;
  double duration = 0;  ///< s
  AxisState state;
};

/// Back inside as soon as the jerk allows: first the acceleration, then the velocity. No phase for
/// a state that is inside. @rt
Recovery recovery(const AxisState& start, const ProfileBounds& bounds);

/// One joint between two states: which durations it can take, and its motion in each of them.
///
/// For each duration T the ways that are possible are an interval, between the ways of the two
/// Farthest motions; T is possible where the way at hand lies inside. So the quickest motion is
/// where one of the two first reaches it, the possible durations are found without search for
/// blocked intervals, and the motion in a given time is the weighted mean of the two, which stays
/// inside all limits as both do. Source: convexity of the reachable set; L. Berscheid, T. Kroeger,
/// Jerk-limited Real-time Trajectory Generation with Arbitrary Target States, RSS 2021, for the
/// problem and its blocked intervals.
class StateToState {
 public:
  /// A duration that is possible, and what binds there: nothing between two farthest motions.
  struct Reach {
    double duration = 0;  ///< s
    std::optional<Binding> binding;
  };

  /// @param start, target, bounds  as not refused by the functions above. @rt
  StateToState(const AxisState& start, const AxisState& target, const ProfileBounds& bounds);

  /// The shortest possible duration that is at least `duration` (s). @rt
  Reach next(double duration) const;
  /// The motion in a possible duration; it arrives within 1e-9 of the target. @rt
  JointProfile profile(double duration) const;
  /// The same into `out`, without a copy. @rt
  void profile(double duration, JointProfile& out) const;

 private:
  std::optional<Reach> next_in(const TimeSpan& span, double time) const;

  AxisState start_, target_;
  double jerk_ = 0;
  Recovery recovery_;
  bool direct_ = false;     // the way is one phase of full jerk
  double direct_time_ = 0;  // s
  double direct_jerk_ = 0;
  double way_ = 0;            // per jerk: s^3
  double way_tolerance_ = 0;  // the same
  Farthest upper_, lower_;    // the lower one in the mirror
  std::array<TimeSpan, 2> spans_;
};

}  // namespace sinew::motion
