#include "sinew/devices/axis/axis_machine_plant.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/devices/encoder/encoder_device_chip.h"

namespace sinew::sim {
namespace {

// ASSUMED, all of them; docs/simulation.md says why these and what depends on them.
constexpr double kContactDamping = 0.3;           // of critical, gear flanks and rubber of the ends
constexpr double kInertiaMin = 2e-4;              // kg m^2: output shaft, pulley and encoder
constexpr double kSwitchTravel = from_deg(0.15);  // between closing and opening
constexpr double kBounce = 2e-3;                  // s, of a lever switch
constexpr double kHeatRise = 50;                  // K above ambient after hours of holding
constexpr double kHeatTime = 1200;                // s
constexpr double kShutdown = 120;                 // deg C at the motor: the power stage gives up
constexpr double kRestSpeed = 1e-5;               // rad/s
constexpr double kRestTorque = 1e-4;              // of the stall torque
/// Longest step of the integration against the quickest oscillation: a twelfth of its period.
constexpr double kPhasePerStep = 0.5;
constexpr int kStepsMax = 64;  // a tick of 10 ms still is bounded work

StepperMotor rotor(const StepperDrive& drive, double q) {
  return {drive, drive.rotor_inertia * drive.motors, q * drive.gear_ratio};
}

}  // namespace

AxisPlant::AxisPlant(const AxisPlantSettings& settings, double q, std::uint64_t seed)
    : settings_(settings),
      random_(seed),
      motor_(rotor(settings.drive, q)),
      rotor_inertia_(settings.drive.rotor_inertia * settings.drive.motors),
      stall_torque_(settings.drive.holding_torque * settings.drive.motors *
                    settings.drive.gear_ratio * settings.drive.gear_efficiency),
      stiffness_(stall_torque_ / settings.windup),
      q_(q),
      inertia_(kInertiaMin),
      supply_(settings.supply_nominal),
      lower_(settings.end_lower),
      upper_(settings.end_upper),
      temperature_(settings.ambient),
      motor_mounting_(random_.uniform(0, 2 * kPi)),
      joint_mounting_(random_.uniform(0, 2 * kPi)),
      motor_sensor_(motor_.angle() + motor_mounting_, random_.bits()),
      joint_sensor_(q + joint_mounting_, random_.bits()),
      quadrature_(q) {
  SINEW_ASSERT(settings.end_lower < settings.end_upper && settings.windup > 0);
  SINEW_ASSERT(settings.drive.gear_ratio > 0 && settings.drive.gear_efficiency > 0);
  motor_.set_power(false);
  switch_pressed_ = switch_level_ = (q - settings.switch_angle) * settings.switch_direction >= 0;
}

void AxisPlant::set_load(double torque, double inertia) {
  load_ = torque;
  inertia_ = std::max(inertia, kInertiaMin);
}

void AxisPlant::block(double q) {
  if (q >= q_) upper_ = std::min(q, settings_.end_upper);
  if (q <= q_) lower_ = std::max(q, settings_.end_lower);
}

void AxisPlant::unblock() {
  lower_ = settings_.end_lower;
  upper_ = settings_.end_upper;
}

void AxisPlant::set_field(double field) {
  (settings_.joint_as5600 ? joint_sensor_ : motor_sensor_).set_field(field);
}

void AxisPlant::set_coupling(bool holds) {
  if (coupled_ && !holds) slipping_at_ = joint_shaft();
  if (!coupled_ && holds) joint_slip_ = slipping_at_ - q_;
  coupled_ = holds;
}

void AxisPlant::place(double q, double qd, double rotor, double rotor_speed) {
  q_ = q;
  qd_ = qd;
  motor_.place(rotor, rotor_speed);
}

void AxisPlant::reboot() {
  steps_ = 0;
  quadrature_ = Quadrature(joint_shaft());
}

double AxisPlant::gear_torque() const {
  const double ratio = settings_.drive.gear_ratio;
  const double play = settings_.drive.backlash / 2;
  const double lead = motor_.angle() / ratio - q_;
  const double pressed = lead - std::clamp(lead, -play, play);
  if (pressed == 0) return 0;
  const double rotor = rotor_inertia_ * ratio * ratio;
  const double reduced = rotor * inertia_ / (rotor + inertia_);
  const double damping = 2 * kContactDamping * std::sqrt(stiffness_ * reduced);
  const double torque = stiffness_ * pressed + damping * (motor_.speed() / ratio - qd_);
  return pressed > 0 ? std::max(torque, 0.0) : std::min(torque, 0.0);  // flanks do not stick
}

double AxisPlant::end_torque() const {
  const double beyond = q_ - std::clamp(q_, lower_, upper_);
  if (beyond == 0) return 0;
  const double damping = 2 * kContactDamping * std::sqrt(stiffness_ * inertia_);
  const double torque = -stiffness_ * beyond - damping * qd_;
  return beyond > 0 ? std::min(torque, 0.0) : std::max(torque, 0.0);
}

double AxisPlant::joint_torque(double gear) const {
  return gear + load_ + extra_load_ + end_torque() - settings_.drive.viscous_friction * qd_;
}

bool AxisPlant::at_rest(double turn) const {
  if ((turn != 0 && motor_.powered()) || std::abs(qd_) > kRestSpeed) return false;
  const double gear = gear_torque();
  const double at_motor = gear / settings_.drive.gear_ratio;
  const double lost = (1 / settings_.drive.gear_efficiency - 1) * std::abs(at_motor);
  const double holds = std::max(settings_.drive.coulomb_friction, kRestTorque * stall_torque_);
  return std::abs(joint_torque(gear)) <= holds && motor_.settled(-at_motor, lost);
}

void AxisPlant::step(double turn, double h) {
  const double gear = gear_torque();
  const double at_motor = gear / settings_.drive.gear_ratio;
  const double lost = (1 / settings_.drive.gear_efficiency - 1) * std::abs(at_motor);
  const double free_speed = qd_ + h * joint_torque(gear) / inertia_;
  // Dry friction may stop the joint, never push it.
  const double grip = h * settings_.drive.coulomb_friction / inertia_;
  qd_ = std::abs(free_speed) <= grip ? 0 : free_speed - std::copysign(grip, free_speed);
  q_ += h * qd_;
  motor_.advance(turn, -at_motor, lost, 0, h);
}

void AxisPlant::advance(const AxisOutputs& outputs, double dt) {
  if (dt <= 0) return;
  const StepperDrive& drive = settings_.drive;
  const double turn = static_cast<double>(outputs.steps - steps_) * 2 * kPi /
                      (drive.steps_per_turn * drive.microsteps);
  steps_ = outputs.steps;
  const bool powered = outputs.enabled && !browned_out() && temperature_ < kShutdown;
  if (powered != motor_.powered()) motor_.set_power(powered);

  // A chopper keeps its current until the supply cannot push it through the turning coils: volts
  // move the corner speed, not the torque below it.
  const double volts = std::max(supply_ / settings_.supply_nominal, 1e-3);
  const double beyond_corner = std::abs(turn / dt) / drive.corner_speed;
  motor_.set_supply_ratio(std::max(1.0, beyond_corner) / std::max(1.0, beyond_corner / volts));

  resting_ = at_rest(turn);
  if (resting_) {
    qd_ = 0;
  } else {
    const double rotor = rotor_inertia_ * drive.gear_ratio * drive.gear_ratio;
    const double rate = std::sqrt(stiffness_ * (1 / rotor + 1 / inertia_));
    const double wanted = std::ceil(dt * rate / kPhasePerStep);
    const int steps = static_cast<int>(std::clamp(wanted, 1.0, 1.0 * kStepsMax));
    for (int i = 0; i < steps; ++i) step(turn / steps, dt / steps);
  }
  at_end_ = end_torque() != 0;
  const double settles_at = settings_.ambient + (powered ? kHeatRise : 0);
  temperature_ += (settles_at - temperature_) * std::min(1.0, dt / kHeatTime);
  read_sensors(dt);
}

void AxisPlant::read_sensors(double dt) {
  motor_sensor_.turn_to(motor_.angle() + motor_mounting_, dt);
  if (settings_.joint_as5600) joint_sensor_.turn_to(joint_shaft() + joint_mounting_, dt);
  read_switch(dt);
}

void AxisPlant::read_switch(double dt) {
  const double beyond = (q_ - settings_.switch_angle) * settings_.switch_direction;
  const bool pressed = switch_held_ || beyond >= (switch_pressed_ ? -kSwitchTravel : 0);
  if (pressed != switch_pressed_) bounce_left_ = kBounce;
  switch_pressed_ = pressed;
  switch_level_ = bounce_left_ > 0 ? random_.bits() % 2 == 0 : pressed;
  bounce_left_ -= dt;
}

AxisInputs AxisPlant::inputs() const {
  AxisInputs inputs;
  inputs.steps = steps_;
  inputs.joint_counts =
      settings_.joint_as5600 ? joint_sensor_.counts() : quadrature_.counts(joint_shaft());
  inputs.joint_encoder_ok = !settings_.joint_as5600 || joint_sensor_.magnet_ok();
  inputs.motor_counts = motor_sensor_.counts();
  inputs.motor_encoder_ok = motor_sensor_.magnet_ok();
  inputs.motor_magnet = magnet_of(motor_sensor_.status());
  if (settings_.joint_as5600) inputs.joint_magnet = magnet_of(joint_sensor_.status());
  inputs.end_stop = switch_level_;
  inputs.driver_fault = temperature_ >= kShutdown;
  inputs.supply_volts = supply_;
  inputs.temperature_c = temperature_;
  return inputs;
}

double AxisPlant::mechanical_energy() const {
  const double play = settings_.drive.backlash / 2;
  const double lead = motor_.angle() / settings_.drive.gear_ratio - q_;
  const double pressed = lead - std::clamp(lead, -play, play);
  const double beyond = q_ - std::clamp(q_, lower_, upper_);
  return 0.5 * rotor_inertia_ * motor_.speed() * motor_.speed() + 0.5 * inertia_ * qd_ * qd_ +
         0.5 * stiffness_ * (pressed * pressed + beyond * beyond);
}

}  // namespace sinew::sim
