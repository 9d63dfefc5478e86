#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "sinew/core/error.h"
#include "sinew/motion/joint_profile.h"
#include "sinew/motion/rest_to_rest.h"

namespace sinew::motion {

/// How the joints of a motion keep step.
enum class Synchronisation : unsigned char {
  /// All take the same time, the shortest that all can; the path is straight in joint space where
  /// that costs no time.
  kTime,
  /// The path is straight in joint space, as quick as the limits let it be; refused
  /// (kNotStraight) where the states at the ends do not lie along the line between them.
  kStraight,
};

/// What keeps a motion from being quicker.
enum class MotionLimit : unsigned char { kNone, kVelocity, kAcceleration, kJerk };

/// Motion of all joints of a robot, each a profile of its own. @rt
class MotionProfile {
 public:
  /// Of no joints.
  MotionProfile();

  std::size_t size() const { return size_; }
  double duration() const { return duration_; }  ///< s
  const JointProfile& joint(std::size_t i) const { return joints_[i]; }
  /// The joint that sets the duration, and what of it.
  std::size_t slowest() const { return slowest_; }
  MotionLimit limited_by() const { return limited_by_; }
  /// All joints share one shape: the path is a straight line in joint space.
  bool straight() const { return straight_; }

  /// States at t (s), held at both ends (a velocity motion goes on at its velocities); exactly the
  /// target at the end. Elements from size() on are not touched.
  void sample(double t, AxisStates& out) const;

 private:
  friend class MotionBuilder;

  std::size_t size_ = 0;
  std::size_t slowest_ = 0;
  double duration_ = 0;
  MotionLimit limited_by_ = MotionLimit::kNone;
  bool straight_ = false;
  std::array<JointProfile, kAxesMax> joints_;
};

/// The quickest motion of several joints from any states to any states, all arriving at once.
///
/// A joint that starts outside its limits (they were lowered under way) first goes back inside as
/// soon as its jerk allows. Every joint arrives within 1e-9 of its target.
///
/// @param start, target  one per joint, at most kAxesMax; rad or m and s.
/// @param bounds         lower < 0 < upper, jerk > 0.
/// @error kMotionInput (a value is not finite, or bounds are out of order), kTargetVelocity,
///        kTargetAcceleration (the target cannot be reached from rest, or not be left again,
///        inside the limits), kNotStraight, kNotConverged (a check of the result that has never
///        been seen to fail); index: joint
/// @rt
Expected<MotionProfile> plan_motion(std::span<const AxisState> start,
                                    std::span<const AxisState> target,
                                    std::span<const ProfileBounds> bounds,
                                    Synchronisation how = Synchronisation::kTime);

/// Every joint to its velocity and no acceleration, each as quickly as it can, wherever that is;
/// it then goes on at that velocity. For jogging. @error as plan_motion. @rt
Expected<MotionProfile> plan_velocity(std::span<const AxisState> start,
                                      std::span<const double> velocity,
                                      std::span<const ProfileBounds> bounds);

/// Every joint to rest, each as quickly as it can. @error kMotionInput @rt
Expected<MotionProfile> plan_stop(std::span<const AxisState> start,
                                  std::span<const ProfileBounds> bounds);

}  // namespace sinew::motion
