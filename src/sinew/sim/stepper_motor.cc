#include "sinew/sim/stepper_motor.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/units.h"

namespace sinew::sim {
namespace {

/// Of the holding torque, what the magnets hold without current. Usual in data sheets of hybrid
/// motors: 3 to 6 %.
constexpr double kDetentShare = 0.05;
/// Damping of a rotor by its own windings and bearings, as a share of critical. Measured ring-down
/// times of small hybrid motors give 0.05 to 0.2.
constexpr double kDampingRatio = 0.15;
/// The windings damp with what they have: an out-of-step rotor is not dragged along.
constexpr double kDampingShare = 0.2;
constexpr double kRestSpeed = 1e-4;  // rad/s
/// Steps of the integration per period of the rotor's own oscillation.
constexpr double kStepsPerPeriod = 24;

}  // namespace

StepperMotor::StepperMotor(const StepperDrive& drive, double inertia, double angle)
    : pole_pairs_(drive.steps_per_turn / 4),
      holding_torque_(drive.holding_torque * drive.motors),
      corner_speed_(drive.corner_speed),
      inertia_(inertia),
      angle_(angle),
      field_(angle) {
  SINEW_ASSERT(pole_pairs_ > 0 && holding_torque_ > 0 && corner_speed_ > 0 && inertia_ > 0);
}

void StepperMotor::set_power(bool on) {
  if (on && !powered_) {
    const double turn = 2 * kPi / pole_pairs_;
    field_ = std::round(angle_ / turn) * turn;
    in_step_ = false;
  }
  powered_ = on;
}

void StepperMotor::place(double angle, double speed) {
  angle_ = field_ = angle;
  speed_ = speed;
}

double StepperMotor::available_torque(double field_speed) const {
  if (!powered_) return kDetentShare * holding_torque_;
  return supply_ratio_ * holding_torque_ / std::max(1.0, std::abs(field_speed) / corner_speed_);
}

double StepperMotor::pull(double field, double angle) const {
  // The magnets know full steps only: four times as many rests as the windings have.
  return powered_ ? std::sin(pole_pairs_ * (field - angle)) : -std::sin(4 * pole_pairs_ * angle);
}

bool StepperMotor::settled(double load, double coulomb) const {
  // On the far side of an electrical turn it balances as a pencil does.
  const bool balancing = powered_ && std::abs(field_ - angle_) > kPi / 2 / pole_pairs_;
  return std::abs(speed_) < kRestSpeed && !balancing &&
         std::abs(available_torque(0) * pull(field_, angle_) + load) <=
             std::max(coulomb, 1e-3 * holding_torque_);
}

void StepperMotor::advance(double turn, double load, double coulomb, double viscous, double dt) {
  if (dt <= 0) return;
  const double field_speed = turn / dt;
  if (!powered_) turn = 0;
  if (turn == 0 && settled(load, coulomb)) {
    speed_ = 0;
    return;
  }
  const double available = available_torque(field_speed);
  const double own_rate = std::sqrt(holding_torque_ * pole_pairs_ / inertia_);
  const double damping = 2 * kDampingRatio * own_rate * inertia_;
  const double damping_max = kDampingShare * available;
  const auto steps = std::max(1.0, std::ceil(dt * own_rate * kStepsPerPeriod / (2 * kPi)));
  const double h = dt / steps;
  for (int i = 0; i < static_cast<int>(steps); ++i) {
    field_ += turn / steps;
    const double slip_speed = speed_ - (powered_ ? field_speed : 0);
    const double driving = available * pull(field_, angle_) + load - viscous * speed_ -
                           std::clamp(damping * slip_speed, -damping_max, damping_max);
    const double free_speed = speed_ + h * driving / inertia_;
    // Dry friction may stop the rotor, never push it.
    const double grip = h * coulomb / inertia_;
    speed_ = std::abs(free_speed) <= grip ? 0 : free_speed - std::copysign(grip, free_speed);
    angle_ += h * speed_;
  }
  // More than half an electrical turn behind: it hangs on to another pole, the steps are lost.
  const double electrical = 2 * kPi / pole_pairs_;
  in_step_ = in_step_ || std::abs(field_ - angle_) < electrical / 4;
  if (powered_ && std::abs(field_ - angle_) > electrical / 2) {
    field_ -= std::round((field_ - angle_) / electrical) * electrical;
    slipped_ = slipped_ || in_step_;
  }
}

}  // namespace sinew::sim
