#include "sinew/planning/studies/drive_train.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"

namespace sinew::planning {
namespace {

/// The way that the joint goes; one at rest is about to go where its load resists.
double direction(const JointDuty& duty) {
  const double way = duty.velocity != 0 ? duty.velocity : duty.torque + duty.acceleration;
  return way < 0 ? -1 : 1;
}

double rotor_inertia(const StepperDrive& drive) {
  return drive.rotor_inertia * drive.motors;
}

}  // namespace

double DriveTrain::demand(const JointDuty& duty) const {
  const double s = direction(duty);
  if (const ServoRating* rating = servo()) return std::abs(duty.torque + s * rating->friction);
  const StepperDrive& drive = *stepper();
  const double N = drive.gear_ratio;
  const double joint =
      duty.torque + s * drive.coulomb_friction + drive.viscous_friction * duty.velocity;
  const double lost = (1 / drive.gear_efficiency - 1) * std::abs(joint);
  const double motor = (joint + s * lost) / N + rotor_inertia(drive) * N * duty.acceleration;
  return std::abs(motor) * N * drive.gear_efficiency;
}

double DriveTrain::available(double velocity) const {
  if (const ServoRating* rating = servo()) {
    return rating->stall_torque * std::max(0.0, 1 - std::abs(velocity) / rating->no_load_speed);
  }
  const StepperDrive& drive = *stepper();
  const double beyond = std::abs(velocity) * drive.gear_ratio / drive.corner_speed;
  return drive.holding_torque * drive.motors * drive.gear_ratio * drive.gear_efficiency /
         std::max(1.0, beyond);
}

std::optional<RatioAnswer> DriveTrain::ratio_for(const JointDuty& duty, double step_rate_max,
                                                 double reserve) const {
  const StepperDrive* drive = stepper();
  if (drive == nullptr) return std::nullopt;
  const double speed = std::abs(duty.velocity);
  const double infinite = std::numeric_limits<double>::infinity();
  RatioAnswer answer;
  answer.highest_useful = speed > 0 ? drive->corner_speed / speed : infinite;
  if (step_rate_max > 0) answer.highest_for_speed = velocity_at(step_rate_max, 1) / speed;
  // Driving up: torque T eta N has to cover load + J eta a N^2, both of all motors together.
  const double torque = drive->holding_torque * drive->motors * drive->gear_efficiency / reserve;
  const double rotor = rotor_inertia(*drive) * drive->gear_efficiency * std::abs(duty.acceleration);
  const double load =
      std::abs(duty.torque) + drive->coulomb_friction + drive->viscous_friction * speed;
  const double root = torque * torque - 4 * rotor * load;
  if (root < 0) return answer;
  const double lowest = 2 * load / (torque + std::sqrt(root));
  if (lowest <= answer.highest_useful) answer.lowest = lowest;
  return answer;
}

double DriveTrain::velocity_at(double step_rate, double ratio) const {
  const StepperDrive* drive = stepper();
  SINEW_ASSERT(drive != nullptr && ratio > 0);
  return step_rate * 2 * kPi / (drive->steps_per_turn * drive->microsteps) / ratio;
}

std::optional<DriveTrain> drive_train(const RobotModel& model, std::size_t i) {
  const Dynamics& dynamics = model.dynamics;
  if (i < dynamics.drives.size()) return DriveTrain(dynamics.drives[i]);
  if (i < dynamics.servos.size()) return DriveTrain(dynamics.servos[i]);
  return std::nullopt;
}

}  // namespace sinew::planning
