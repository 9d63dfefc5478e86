#pragma once

#include <optional>
#include <variant>

#include "sinew/model/dynamics.h"
#include "sinew/model/robot_model.h"

namespace sinew::planning {

/// A joint that has to move: what its links ask for, and how fast.
struct JointDuty {
  double torque = 0;        ///< Nm by weight and inertia of links and payload, friction not counted
  double velocity = 0;      ///< rad/s
  double acceleration = 0;  ///< rad/s^2; turns the rotors too
};

/// Which gear ratio does a duty.
struct RatioAnswer {
  /// The smallest one whose torque does; none where its own rotors or its torque that falls with
  /// speed are in the way of every ratio.
  std::optional<double> lowest;
  /// Beyond it torque falls as fast as the ratio grows: corner speed over joint speed.
  double highest_useful = 0;
  /// The largest one at which the joint still reaches its speed with the steps that there are;
  /// none where nobody said how many.
  std::optional<double> highest_for_speed;
};

/// What moves one joint: the motors and the gear of a stepper drive, or a servo; Nm at the joint (N
/// at a leg). Torques are counted as `motor torque x motors x ratio x efficiency`, so that they can
/// be held against each other. docs/torque.md, eq. (13) to (17). @rt
class DriveTrain {
 public:
  explicit DriveTrain(const StepperDrive& drive) : what_(drive) {}
  explicit DriveTrain(const ServoRating& servo) : what_(servo) {}

  /// What the motors have to cover so that the joint does its duty. The gear's losses count against
  /// the motor while it drives and for it while it is driven; a joint at rest (velocity 0) is about
  /// to move the hard way.
  double demand(const JointDuty& duty) const;

  /// What the motors give while the joint turns with `velocity`.
  double available(double velocity) const;

  /// @param step_rate_max  microsteps a second; 0 where nobody knows.
  /// @param reserve        how many times the demand the motors shall give
  /// @return               nothing for a servo, whose gear cannot be changed.
  std::optional<RatioAnswer> ratio_for(const JointDuty& duty, double step_rate_max,
                                       double reserve = 1) const;

  /// Joint speed that this many microsteps a second make at a ratio; rad/s. Steppers only.
  double velocity_at(double step_rate, double ratio) const;

  const StepperDrive* stepper() const { return std::get_if<StepperDrive>(&what_); }
  const ServoRating* servo() const { return std::get_if<ServoRating>(&what_); }

 private:
  std::variant<StepperDrive, ServoRating> what_;
};

/// Of joint i; nothing where the robot's file does not say.
std::optional<DriveTrain> drive_train(const RobotModel& model, std::size_t i);

}  // namespace sinew::planning
