#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/driver/driver.h"
#include "sinew/model/robot_model.h"
#include "sinew/motion/rest_to_rest.h"
#include "sinew/planning/collision/collision.h"

namespace sinew::control {

/// The last look at every piece of motion before it reaches a driver. It knows nothing of plans: it
/// holds each piece against the robot's limits and against the piece before it, and what it lets
/// through is inside of them, whoever made it.
///
/// Of a streaming device's pieces, from (q0, qd0) to (q1, qd1) in T, it holds for every joint
///
///   |qd1| <= v,   |q1 - q0| <= v T                                  velocity
///   |qd1 - qd0| <= a T                                              acceleration
///   |A - A_before| <= j (T + T_before) / 2,  A = (qd1 - qd0) / T    jerk
///   |q1 - q0 - (qd0 + qd1) T / 2| <= j T^3 / 12                     q and qd tell the same story
///
/// All four follow from a motion inside v, a and j (A is the mean acceleration over T; means over
/// neighbouring times of a function with slope j are no farther apart than their middles times j;
/// the last is the error of the trapezoid rule), so no such motion is ever refused. What a device
/// makes of a whole move by itself is not the governor's: it looks at where that begins and ends.
///
/// A robot may rest where its bodies overlap: homing leaves it there, so its model is what is
/// wrong, and it must leave. The motion that leads it out names the pairs of links that it finds
/// too near; these are not looked at until it rests, if where it begins one of them is what is
/// nearest, and a streaming device then gets no more than kLeavingShare of its velocity.
///
/// @rt apart from its construction.
class Governor {
 public:
  static constexpr double kLeavingShare = 0.1;
  /// Relative; for rounding, and for the steps in which a device takes its positions.
  static constexpr double kTolerance = 1e-6;

  /// @param model   outlives this.
  /// @param limits  one per joint, what its motions are planned with or more.
  Governor(const RobotModel& model, std::span<const motion::AxisLimits> limits);

  /// The machine rests there; the next piece begins there.
  void rest(std::span<const double> q);
  /// What the gripper is like from now on.
  void fit(const ToolState& tool);
  /// The jaws go to that width (m), from what they were fitted to, where the machine rests.
  /// @error kJawsContact, kCollision
  Expected<void> pass_jaws(double to);
  /// What passes from now on leads apart what is too near to each other here; until rest().
  void leave(std::span<const LinkPair> overlaps);
  /// Nobody knows where it is: nothing passes but pass_blind().
  void lose() {
    known_ = false;
    overlaps_.clear();
  }

  /// @error kMoveInput (index: no number, or how many joints), kSegmentTime (s; not above 0, or
  ///        beyond a day), kPositionUnknown (also, with its index: it would move a joint that is
  ///        left out), kJointLimit (index), kVelocityLimit, kAccelerationLimit, kJerkLimit, kJump
  ///        (index, how many times what is allowed), kCollision (index, other: links). Then nothing
  ///        changes.
  Expected<void> pass(const JointMove& move);
  /// A slow first move of a machine that cannot say where it is: only where it ends can be looked
  /// at. @error kMoveInput, kSegmentTime, kJointLimit, kCollision
  Expected<void> pass_blind(const JointMove& move);

  /// One joint a little, from nobody knows where: no farther than the device's nudge_max, and where
  /// something is known of it, not beyond its limits nor nearer to anything.
  /// @error kTaskNotSupported (no such device), kMoveInput (there is no such joint), kNudgeRange,
  ///        kJointLimit, kCollision
  Expected<void> pass_nudge(std::size_t joint, double way,
                            std::span<const JointPosition> positions) const;

  bool known() const { return known_; }
  std::span<const double> q() const { return {q_.data(), size_}; }

 private:
  using Array = std::array<double, kMaxJoints>;

  std::optional<Error> look_at_numbers(const JointMove& move) const;
  std::optional<Error> look_at_place(const JointMove& move) const;
  std::optional<Error> look_at_piece(const JointMove& move, std::size_t joint,
                                     double seconds) const;
  std::optional<Error> look_at_contacts(const JointMove& move) const;
  planning::Clearance nearest(std::size_t pose, std::span<const double> q) const {
    return collision_.distance_in(pose, q, nullptr, {overlaps_.data(), overlaps_.size()});
  }
  void look_around();
  void take(const JointMove& move, double seconds);

  const RobotModel& model_;
  planning::CollisionModel collision_;
  ToolState tool_;
  std::array<motion::AxisLimits, kMaxJoints> limits_{};
  std::size_t size_;
  bool streams_;

  bool known_ = false;
  Array q_{};
  Array qd_{};
  Array acceleration_{};  ///< mean over the piece before
  double seconds_ = 0;    ///< that it took; 0: the machine rests
  FixedVector<LinkPair, 64> overlaps_;
  planning::Clearance nearest_;  ///< where it rested last, but for overlaps_
  /// The same in each pose of the joints that are left out.
  std::array<planning::Clearance, planning::CollisionModel::kPosesMax> poses_;
};

}  // namespace sinew::control
