#include "sinew/devices/feetech/feetech_machine.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/split_mix.h"
#include "sinew/model/hand.h"

namespace sinew::sim {
namespace {

constexpr Duration kStep = std::chrono::milliseconds(1);
constexpr Duration kLoadStep = std::chrono::milliseconds(10);
constexpr double kNominalVolts = 7.4;
constexpr double kAmbient = 25;      // deg C
constexpr double kStalledHeat = 90;  // deg C above it, at full duty for long; assumed
constexpr double kHeatTime = 300;    // s; assumed
constexpr double kBeyond = 0.09;     // rad, of a joint's mechanical ends behind its limits; assumed
constexpr double kPushing = 0.9;     // of full duty
constexpr double kRest = 1e-3;       // rad/s

/// STS3215 at 7.4 V: 19.5 kg cm, 50 rpm (its maker). Stiffness, inertia and friction are those with
/// which it settles as users' step responses show; assumed.
ServoDrive drive_of(double lower, double upper) {
  ServoDrive drive;
  drive.stall_torque = 1.9;
  drive.no_load_speed = 5.2;
  drive.inertia = 4e-3;
  drive.friction = 0.06;
  drive.deadband = 0.0015;
  drive.full_drive_error = 0.08;
  drive.end_lower = lower;
  drive.end_upper = upper;
  return drive;
}

const SerialGeometry& serial(const RobotModel& model) {
  const auto* geometry = std::get_if<SerialGeometry>(&model.geometry);
  SINEW_ASSERT(geometry != nullptr);
  return *geometry;
}

std::vector<std::uint8_t> ids_of(const FeetechDevice& device, bool jaws) {
  std::vector<std::uint8_t> ids;
  for (const FeetechDevice::Servo& servo : device.servos) ids.push_back(servo.id);
  if (jaws) ids.push_back(device.gripper.id);
  return ids;
}

}  // namespace

FeetechMachine::FeetechMachine(const RobotModel& model, std::uint64_t seed, Instant boot)
    : device_(model.device.settings.get<FeetechDevice>()),
      joints_(model.joints.size()),
      bus_(device_.series, ids_of(device_, jaws_of(model) != nullptr), boot),
      load_(tool_at_tips(serial(model)), masses_of_servo_arm(model)),
      volts_(kNominalVolts),
      now_(boot),
      load_due_(boot) {
  SINEW_ASSERT(joints_ == device_.servos.size());
  constexpr double kPlayed = 0.1;  // rad either side of its home
  SplitMix64 random(seed);
  for (const Joint& joint : model.joints) {
    const double q = joint.home + random.uniform(-kPlayed, kPlayed);
    motors_.emplace_back(drive_of(joint.lower - kBeyond, joint.upper + kBeyond),
                         std::clamp(q, joint.lower, joint.upper));
  }
  if (const JawGripper* gripper = jaws_of(model)) {
    width_max_ = gripper->width_max;
    jaw_span_ = std::abs(device_.gripper.open - device_.gripper.closed) / device_.units_per_rad();
    motors_.emplace_back(drive_of(0, jaw_span_), random.uniform(0, jaw_span_));
  }
  heat_.fill(kAmbient);
  update_load();
  sense(volts_);
  for (std::size_t i = 0; i < motors_.size(); ++i) bus_.servo(i).hold();
}

double FeetechMachine::angle_of(std::size_t i, double units) const {
  if (!is_jaws(i)) return device_.q_of(i, units);
  const FeetechDevice::Gripper& jaws = device_.gripper;
  return (units - jaws.closed) / (jaws.open - jaws.closed) * jaw_span_;
}

double FeetechMachine::units_of(std::size_t i, double angle) const {
  if (!is_jaws(i)) return device_.units_of(i, angle);
  const FeetechDevice::Gripper& jaws = device_.gripper;
  return jaws.closed + angle / jaw_span_ * (jaws.open - jaws.closed);
}

void FeetechMachine::advance(Instant now) {
  SINEW_ASSERT(now >= now_);
  while (now_ < now) step(std::min(now, now_ + kStep));
}

void FeetechMachine::step(Instant to) {
  const double dt = to_seconds(to - now_);
  now_ = to;
  const bool awake = volts_ >= kBrownOutVolts;
  if (awake && !powered_) bus_.power_cycle(now_);
  powered_ = awake;
  if (now_ >= load_due_) update_load();
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    const FeetechServo::Command command = bus_.servo(i).command();
    const double load = is_jaws(i) ? 0 : load_.torque(i) + extra_load_[i];
    const bool driven = powered_ && bus_.plugged(i) && command.torque > 0;
    ServoMotor& motor = motors_[i];
    motor.set_supply_ratio(powered_ ? volts_ / kNominalVolts : 0);
    motor.set_drive(command.torque, command.stiffness);
    motor.advance(angle_of(i, command.units), driven, load, dt);
    const double heat = kAmbient + kStalledHeat * motor.effort() * motor.effort();
    heat_[i] += (heat - heat_[i]) * dt / kHeatTime;
    if (powered_) bus_.servo(i).advance(now_);
  }
  sense(volts_);
}

void FeetechMachine::sense(double volts) {
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    const ServoMotor& motor = motors_[i];
    const double per_rad = units_of(i, 1) - units_of(i, 0);
    bus_.servo(i).sense({.units = units_of(i, motor.angle()),
                         .speed = motor.speed() * per_rad,
                         .duty = bus_.servo(i).command().torque > 0 ? motor.effort() : 0,
                         .volts = volts,
                         .heat = heat_[i]});
  }
}

void FeetechMachine::update_load() {
  std::array<double, kMaxJoints> q{};
  for (std::size_t i = 0; i < joints_; ++i) q[i] = motors_[i].angle();
  load_.update(std::span(q).first(joints_));
  load_due_ = now_ + kLoadStep;
}

Truth FeetechMachine::truth() const {
  Truth truth;
  for (std::size_t i = 0; i < joints_; ++i) {
    const ServoMotor& motor = motors_[i];
    const bool on = bus_.servo(i).command().torque > 0;
    JointTruth joint;
    joint.q = joint.believed = motor.angle();
    joint.qd = motor.speed();
    joint.stalled = on && motor.effort() >= kPushing && std::abs(motor.speed()) < kRest;
    joint.at_end_stop = motor.at_end();
    truth.joints.push_back(joint);
    truth.moving = truth.moving || std::abs(motor.speed()) > kRest;
  }
  if (motors_.size() > joints_) {
    const ServoMotor& jaws = motors_.back();
    truth.moving = truth.moving || std::abs(jaws.speed()) > kRest;
    truth.tool = width_max_ * jaws.angle() / jaw_span_;
  }
  truth.supply_volts = volts_;
  truth.bytes_lost = bytes_lost_ + bus_.bytes_lost();
  return truth;
}

LastingState FeetechMachine::lasting_state() const {
  LastingState state;
  for (const ServoMotor& motor : motors_) state.bodies.push_back({motor.angle(), motor.speed()});
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    const FeetechServo::Settings& settings = bus_.servo(i).settings();
    state.memory.insert(state.memory.end(), settings.begin(), settings.end());
  }
  return state;
}

bool FeetechMachine::restore(const LastingState& state) {
  const std::size_t count = motors_.size();
  if (state.bodies.size() != count) return false;
  if (state.memory.size() != count * FeetechServo::kSettings) return false;
  for (std::size_t i = 0; i < count; ++i) {
    motors_[i].place(state.bodies[i].angle, state.bodies[i].speed);
    FeetechServo::Settings settings{};
    const auto from = state.memory.begin() + static_cast<std::ptrdiff_t>(i * settings.size());
    std::copy_n(from, settings.size(), settings.begin());
    bus_.servo(i).set_settings(settings);
  }
  bus_.power_cycle(now_);
  update_load();
  sense(volts_);
  return true;
}

void FeetechMachine::disturb(const Disturbance& what) {
  using Kind = Disturbance::Kind;
  if (what.kind == Kind::kSupply) volts_ = what.value;
  if (what.kind == Kind::kPayload) load_.set_payload(what.value);
  if (what.kind == Kind::kPayload) update_load();
  if (what.joint < 0 || static_cast<std::size_t>(what.joint) >= motors_.size()) return;
  const auto i = static_cast<std::size_t>(what.joint);
  ServoMotor& motor = motors_[i];
  if (what.kind == Kind::kUnblock) motor.unblock();
  if (what.kind == Kind::kLoad) extra_load_[i] = what.value;
  if (what.kind == Kind::kLead) bus_.plug(i, what.value != 0);
  if (what.kind != Kind::kBlock) return;
  if (is_jaws(i)) {
    motor.block_below(what.value / width_max_ * jaw_span_);
  } else if (motor.angle() <= what.value) {
    motor.block_above(what.value);
  } else {
    motor.block_below(what.value);
  }
}

void FeetechMachine::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  if (powered_) {
    bus_.receive(bytes, now);
  } else {
    bytes_lost_ += bytes.size();
  }
}

std::size_t FeetechMachine::take_output(std::span<std::uint8_t> out) {
  return powered_ ? bus_.take_output(out) : 0;
}

}  // namespace sinew::sim
