#pragma once

#include "sinew/motion/joint_profile.h"
#include "sinew/motion/rest_to_rest.h"

namespace sinew::planning {

/// A velocity that a joint shall have at the end of a cycle, and how quickly it changes then: rad/s
/// and rad/s^2, or of a leg in m.
struct JointReference {
  double velocity = 0;
  double rate = 0;
};

/// One joint of a jog, cycle by cycle. Whatever velocity it is asked for, velocity, acceleration
/// and jerk stay inside their limits, and at every instant it can still come to rest inside its
/// limits of position: from a state that keeps this, every next one does.
///
/// A joint that stands outside of its limits of position may go back in, and no farther out.
/// Seconds and rad (or m). @rt
class JogJoint {
 public:
  JogJoint() = default;
  JogJoint(const motion::AxisLimits& limits, const motion::PositionRange& range)
      : limits_(limits), bounds_(limits), range_(range) {}

  const motion::AxisLimits& limits() const { return limits_; }

  /// `dt` > 0 after `state`, as near to the reference as can be, and onto it where the limits
  /// allow: a reference that changes steadily is followed without lag.
  motion::AxisState follow(const motion::AxisState& state, const JointReference& reference,
                           double dt);
  /// To rest, as soon as the limits allow.
  motion::OnlineProfile stop(const motion::AxisState& state) const {
    return motion::OnlineProfile::stop(state, bounds_);
  }
  /// Where it may be on its way to rest: inside its limits of position, and where it cannot avoid
  /// any more to leave them.
  motion::PositionRange range_from(const motion::AxisState& state) const;

  /// How fast it may go upwards (or downwards: a positive number too) from q, without acceleration,
  /// so that it still comes to rest at its limit with this share of its acceleration and jerk;
  /// infinite where the limit is far, 0 at it and beyond.
  double approach_speed(double q, bool upwards, double share) const;

 private:
  bool keeps_velocity(const motion::AxisState& state) const;
  bool rests_inside(const motion::AxisState& state, const motion::PositionRange& range) const;
  motion::AxisState towards_velocity(const motion::AxisState& state,
                                     const JointReference& reference, double dt);

  motion::AxisLimits limits_;
  motion::ProfileBounds bounds_;
  motion::PositionRange range_;
  motion::JointProfile profile_;  ///< workspace
};

}  // namespace sinew::planning
