#include "sinew/devices/icp/icp_machine.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/core/split_mix.h"
#include "sinew/core/units.h"
#include "sinew/devices/icp/icp_settings.h"

namespace sinew::sim {
namespace {

constexpr double kLead = 0.7e-3;         // m a turn, M4 coarse pitch; the document's insert
constexpr double kPlatformMass = 1.2;    // kg, assumed
constexpr double kGravity = 9.81;        // m/s^2
constexpr double kStopMargin = 1e-3;     // m beyond the limits, assumed
constexpr double kNominalCurrent = 566;  // mA, what the holding torque is given for
constexpr double kFrictionSpread = 0.3;  // of the friction, from leg to leg
constexpr double kBlocked = 100;         // times the holding torque
constexpr Duration kPiece{500'000};      // ns; a motor is looked at this often
constexpr double kMicrostepsPerTurn = 3200;

/// SM42051, a 1.8 degree motor of size 17: round numbers of its class, and a dry M4 spindle.
StepperDrive usual_drive() {
  StepperDrive drive;
  drive.holding_torque = 0.22;
  drive.gear_ratio = 2 * kPi / kLead;
  drive.rotor_inertia = 5e-6;
  drive.corner_speed = 30;
  drive.coulomb_friction = 45;  // N at the leg: 5 mNm at the motor
  return drive;
}

template <class Make, std::size_t... Index>
auto array_of(Make&& make, std::index_sequence<Index...>) {
  return std::array{make(Index)...};
}

std::array<Tmc222, kLegs> make_modules(const IcpDevice& device, std::uint64_t seed, Instant boot) {
  SplitMix64 random(seed);
  const auto make = [&](std::size_t leg) {
    const std::uint8_t address = device.legs[leg].address;
    const auto fallback = static_cast<std::uint8_t>(0x61 + leg);
    return Tmc222(address != 0 ? address : fallback, {}, random.uniform(7, 8), boot);
  };
  return array_of(make, std::make_index_sequence<kLegs>{});
}

StepperDrive drive_of(const RobotModel& model, std::size_t leg) {
  return leg < model.dynamics.drives.size() ? model.dynamics.drives[leg] : usual_drive();
}

std::array<StepperMotor, kLegs> make_motors(const RobotModel& model) {
  const auto make = [&](std::size_t leg) {
    const StepperDrive drive = drive_of(model, leg);
    return StepperMotor(drive, drive.rotor_inertia * drive.motors);
  };
  return array_of(make, std::make_index_sequence<kLegs>{});
}

const IcpDevice& device_of(const RobotModel& model) {
  const auto* device = model.device.settings.as<IcpDevice>();
  SINEW_ASSERT(device != nullptr && model.joints.size() == kLegs);
  return *device;
}

}  // namespace

IcpMachine::IcpMachine(const RobotModel& model, const IcpQuirks& quirks, std::uint64_t seed,
                       Instant boot)
    : now_(boot),
      modules_(make_modules(device_of(model), seed, boot)),
      controller_(quirks, modules_, boot),
      motors_(make_motors(model)) {
  SplitMix64 random(seed ^ 0x5EED);
  for (std::size_t i = 0; i < kLegs; ++i) {
    Leg& leg = legs_[i];
    leg.drive = drive_of(model, i);
    leg.start = leg.begin = model.joints[i].home;
    // Bit 0 lengthens a leg that is not inverted, whatever sign the firmware makes of it.
    leg.sense = (device_of(model).legs[i].invert ? -1.0 : 1.0) * (quirks.bit_one_is_plus ? -1 : 1);
    leg.end_lower = model.joints[i].lower - kStopMargin;
    leg.end_upper = model.joints[i].upper + kStopMargin;
    leg.friction = leg.drive.coulomb_friction / leg.drive.gear_ratio *
                   random.uniform(1 - kFrictionSpread, 1 + kFrictionSpread);
    leg.time = boot;
    motors_[i].set_power(false);
  }
}

double IcpMachine::length(std::size_t leg, double angle) const {
  return legs_[leg].start + legs_[leg].sense * angle / legs_[leg].drive.gear_ratio;
}

void IcpMachine::receive(std::span<const std::uint8_t> bytes, Instant now) {
  for (const std::uint8_t byte : bytes) {
    advance(now);
    controller_.receive(byte, now);
  }
  run_motors(now);
}

void IcpMachine::advance(Instant now) {
  while (true) {
    Instant next = now;
    if (const auto event = controller_.next_event()) next = std::min(next, *event);
    for (const Tmc222& module : modules_) {
      if (const auto event = module.next_event()) next = std::min(next, *event);
    }
    next = std::max(next, now_);
    run_motors(next);
    now_ = next;
    for (Tmc222& module : modules_) module.advance(next);
    controller_.advance(next);
    if (next == now) break;
  }
  run_motors(now);
}

void IcpMachine::run_motors(Instant now) {
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (legs_[i].loose && modules_[i].moving()) modules_[i].set_coil_fault(true, now_);
    const bool powered = modules_[i].powered();
    if (powered != motors_[i].powered()) {
      wake(i);
      motors_[i].set_power(powered);
      if (powered) {
        const double ratio = modules_[i].current() / kNominalCurrent;
        motors_[i].set_supply_ratio(std::min(1.0, volts_ / kNominalVolts) * ratio);
      }
    }
    if (modules_[i].field() != legs_[i].field) wake(i);
    if (!legs_[i].resting) run_motor(i, now);
  }
}

void IcpMachine::wake(std::size_t leg) {
  if (!legs_[leg].resting) return;
  legs_[leg].resting = false;
  legs_[leg].time = now_;
}

void IcpMachine::run_motor(std::size_t leg, Instant now) {
  Leg& it = legs_[leg];
  StepperMotor& motor = motors_[leg];
  const double weight = (kPlatformMass + payload_) * kGravity / kLegs;
  const double load = it.sense * (it.load - weight) / it.drive.gear_ratio;
  const double viscous = it.drive.viscous_friction / (it.drive.gear_ratio * it.drive.gear_ratio);
  while (it.time < now) {
    const Duration piece = std::min<Duration>(now - it.time, kPiece);
    const double turn =
        static_cast<double>(modules_[leg].field() - it.field) * 2 * kPi / kMicrostepsPerTurn;
    it.field = modules_[leg].field();
    const double q = length(leg, motor.angle());
    const double pulled = length(leg, motor.field() + turn) - q;
    const bool blocked = (q >= it.upper() && pulled > 0) || (q <= it.lower() && pulled < 0);
    const double friction = blocked ? kBlocked * it.drive.holding_torque : it.friction;
    motor.advance(turn, load, friction, viscous, to_seconds(piece));
    it.time += piece;
    if (turn == 0 && motor.settled(load, friction)) {
      it.resting = true;
      return;
    }
  }
}

Truth IcpMachine::truth() const {
  Truth truth;
  for (std::size_t i = 0; i < kLegs; ++i) {
    JointTruth joint;
    joint.q = length(i, motors_[i].angle());
    joint.qd =
        legs_[i].resting ? 0 : legs_[i].sense * motors_[i].speed() / legs_[i].drive.gear_ratio;
    const double turned = static_cast<double>(modules_[i].field()) * 2 * kPi / kMicrostepsPerTurn;
    joint.believed = legs_[i].begin + length(i, turned) - legs_[i].start;
    joint.lost_steps = motors_[i].slipped();
    joint.at_end_stop = joint.q <= legs_[i].lower() || joint.q >= legs_[i].upper();
    truth.joints.push_back(joint);
    truth.moving = truth.moving || modules_[i].moving() || joint.qd != 0;
  }
  truth.supply_volts = volts_;
  truth.bytes_lost = controller_.bytes_lost();
  return truth;
}

LastingState IcpMachine::lasting_state() const {
  LastingState state;
  for (const StepperMotor& motor : motors_) {
    state.bodies.push_back({motor.angle(), motor.speed()});
  }
  return state;
}

bool IcpMachine::restore(const LastingState& state) {
  if (state.bodies.size() != kLegs || !state.memory.empty()) return false;
  for (std::size_t i = 0; i < kLegs; ++i) {
    motors_[i].place(state.bodies[i].angle, state.bodies[i].speed);
    legs_[i].begin = length(i, state.bodies[i].angle);
    wake(i);
  }
  return true;
}

void IcpMachine::disturb(const Disturbance& what) {
  const bool one_leg = what.joint >= 0 && what.joint < static_cast<int>(kLegs);
  const auto leg = static_cast<std::size_t>(one_leg ? what.joint : 0);
  Leg& it = legs_[leg];
  const double q = length(leg, motors_[leg].angle());
  switch (what.kind) {
    case Disturbance::Kind::kSupply:
      return set_supply(what.value);
    case Disturbance::Kind::kPayload:
      payload_ = what.value;
      for (std::size_t i = 0; i < kLegs; ++i) wake(i);
      return;
    case Disturbance::Kind::kBlock:
      if (!one_leg) return;
      (what.value >= q ? it.block_upper : it.block_lower) = what.value;
      return wake(leg);
    case Disturbance::Kind::kUnblock:
      if (!one_leg) return;
      it.block_lower = kFree[0];
      it.block_upper = kFree[1];
      return wake(leg);
    case Disturbance::Kind::kLoad:
      if (!one_leg) return;
      it.load = what.value;
      return wake(leg);
    case Disturbance::Kind::kLead:
      if (!one_leg) return;
      it.loose = what.value == 0;
      if (!it.loose) modules_[leg].set_coil_fault(false, now_);
      return;
    case Disturbance::Kind::kCoupling:
    case Disturbance::Kind::kMagnet:
    case Disturbance::Kind::kProbe:
      return;  // no sensor anywhere
  }
}

void IcpMachine::set_supply(double volts) {
  const bool was_up = volts_ >= kControllerReset;
  volts_ = volts;
  for (std::size_t i = 0; i < kLegs; ++i) {
    modules_[i].set_supply(volts, now_);
    motors_[i].set_supply_ratio(std::min(1.0, volts / kNominalVolts) * modules_[i].current() /
                                kNominalCurrent);
    wake(i);
  }
  if (volts < kControllerReset) {
    controller_.power_off();
  } else if (!was_up) {
    controller_.power_cycle(now_);
  }
}

void IcpMachine::power_cycle() {
  const double volts = volts_;
  set_supply(0);
  set_supply(volts);
}

}  // namespace sinew::sim
