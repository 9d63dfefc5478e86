#pragma once

#include "sinew/core/fixed_vector.h"
#include "sinew/motion/farthest.h"
#include "sinew/motion/joint_profile.h"

namespace sinew::motion {

/// One joint to a velocity, without acceleration there, as quickly as its bounds allow and wherever
/// that is: the acceleration goes to its peak, stays, and goes back to 0. An acceleration outside
/// its bounds comes back inside first.
class VelocityChange {
 public:
  /// @param start, bounds  as not refused by `refusal`.
  /// @param velocity       inside the bounds. @rt
  VelocityChange(const AxisState& start, double velocity, const ProfileBounds& bounds);

  /// Arrives and goes on at that velocity. @rt
  void profile(JointProfile& out) const;
  JointProfile profile() const;
  Binding binding() const { return binding_; }

 private:
  struct Phase {
    double jerk = 0;
    double duration = 0;  ///< s
  };

  AxisState start_;
  double velocity_;
  FixedVector<Phase, 4> phases_;
  Binding binding_ = Binding::kJerk;
};

}  // namespace sinew::motion
