#pragma once

#include <array>
#include <span>

#include "sinew/model/device.h"
#include "sinew/planning/jog/jog_joint.h"

namespace sinew::planning {

/// All joints of a jog to rest, in the time that the slowest of them needs and, as well as their
/// accelerations allow, along the direction in which they move: each follows its share of the
/// slowest one's way to rest, and beside that loses what acceleration it has too much.
///
/// Joints for which that does not fit into their limits take a way of their own, in the same time
/// where they can. None reverses, or becomes faster, but for what its acceleration at the start
/// makes of its velocity before the jerk limit lets it end. Seconds and rad (or m). @rt
class JogStop {
 public:
  /// From these states, one per joint, inside their limits of velocity and acceleration.
  void plan(std::span<const JogJoint> joints, std::span<const motion::AxisState> states);

  double duration() const { return duration_; }  ///< s
  /// `t` s after the start; from duration() on at rest.
  motion::AxisState at(std::size_t joint, double t) const {
    // Durations differ by rounding.
    return t >= duration_ ? joints_[joint].end() : joints_[joint].at(t);
  }

 private:
  std::array<motion::JointProfile, kMaxJoints> joints_;
  double duration_ = 0;
};

}  // namespace sinew::planning
