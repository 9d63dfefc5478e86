#include "sinew/devices/lsc/lsc_machine.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/split_mix.h"

namespace sinew::sim {
namespace {

constexpr Duration kStep = std::chrono::milliseconds(2);       // some tenths of a servo's lag
constexpr Duration kLoadStep = std::chrono::milliseconds(10);  // weight changes with the pose only

constexpr double kNominalVolts = 7.4;   // two lithium cells, as the arm is sold
constexpr double kBatteryOhms = 0.12;   // assumed: battery, switch and cable
constexpr double kStallAmperes = 1.8;   // one servo at nominal voltage; data sheet of its class
constexpr double kBoardAmperes = 0.12;  // assumed
constexpr double kPwmUnitAngle = kPi / 2000;          // rad per us
constexpr double kBusUnitAngle = 4 * kPi / 3 / 1000;  // rad per unit
constexpr double kServoEnd = 1.75;  // rad either side: a 180 deg servo's stops, assumed
constexpr double kPushing = 0.9;    // of full effort

const SerialGeometry& serial(const RobotModel& model) {
  const auto* geometry = std::get_if<SerialGeometry>(&model.geometry);
  SINEW_ASSERT(geometry != nullptr);
  return *geometry;
}

const LscDevice& settings(const RobotModel& model) {
  const auto* device = model.device.settings.as<LscDevice>();
  SINEW_ASSERT(device != nullptr && device->servos.size() == model.joints.size());
  return *device;
}

}  // namespace

LscMachine::LscMachine(const RobotModel& model, LscProfile profile, std::uint64_t seed,
                       Instant boot)
    : device_(settings(model)),
      joints_(model.joints.size()),
      board_(profile, boot),
      load_(tool_at_tips(serial(model)), masses_of_servo_arm(model)),
      battery_volts_(kNominalVolts),
      supply_volts_(kNominalVolts),
      now_(boot),
      load_due_(boot) {
  SINEW_ASSERT(joints_ < kMaxJoints);
  device_.profile = profile;
  SplitMix64 random(seed);
  ServoDrive drive;
  drive.end_lower = -kServoEnd;
  drive.end_upper = kServoEnd;
  for (const Joint& joint : model.joints) {
    const double lower = std::max(joint.lower, -kServoEnd);
    const double upper = std::min(joint.upper, kServoEnd);
    servos_.emplace_back(drive, random.uniform(lower, upper));
  }
  const auto& gripper = serial(model).gripper;
  const double unit = profile == LscProfile::kBus ? kBusUnitAngle : kPwmUnitAngle;
  width_max_ = gripper ? gripper->width_max : 0;
  jaw_span_ = std::abs(device_.gripper.closed - device_.gripper.open) * unit;
  drive.end_lower = 0;
  drive.end_upper = jaw_span_;
  servos_.emplace_back(drive, random.uniform(0, jaw_span_));
  update_load();
  sense();
}

std::uint8_t LscMachine::id_of(std::size_t i) const {
  return is_jaws(i) ? device_.gripper.id : device_.servos[i].id;
}

double LscMachine::horn_of(std::size_t i, double units) const {
  if (is_jaws(i)) {
    const LscGripper& jaws = device_.gripper;
    return (units - jaws.open) / (jaws.closed - jaws.open) * jaw_span_;
  }
  const LscServo& servo = device_.servos[i];
  return (units - servo.centre - servo.trim) / servo.units_per_rad;
}

double LscMachine::units_of(std::size_t i, double horn) const {
  if (is_jaws(i)) {
    const LscGripper& jaws = device_.gripper;
    return jaws.open + horn / jaw_span_ * (jaws.closed - jaws.open);
  }
  const LscServo& servo = device_.servos[i];
  return servo.centre + servo.trim + servo.units_per_rad * horn;
}

void LscMachine::advance(Instant now) {
  SINEW_ASSERT(now >= now_);
  while (now_ < now) step(std::min(now, now_ + kStep));
}

void LscMachine::step(Instant to) {
  const double dt = to_seconds(to - now_);
  now_ = to;
  if (powered_) board_.advance(now_);
  if (now_ >= load_due_) update_load();
  double amperes = kBoardAmperes;
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    const LscBoard::Command command = board_.command(id_of(i));
    const double load = is_jaws(i) ? 0 : load_.torque(i) + extra_load_[i];
    servos_[i].set_supply_ratio(powered_ ? supply_volts_ / kNominalVolts : 0);
    servos_[i].advance(horn_of(i, command.units), powered_ && command.driven, load, dt);
    amperes += servos_[i].effort() * kStallAmperes;
  }
  supply_volts_ = std::max(0.0, battery_volts_ - kBatteryOhms * amperes);
  sense();
  if (powered_ && supply_volts_ < kBrownOutVolts) {
    powered_ = false;
  } else if (!powered_ && supply_volts_ > kPowerUpVolts) {
    powered_ = true;
    board_.power_cycle(now_);
  }
}

void LscMachine::sense() {
  board_.sense_supply(supply_volts_);
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    board_.sense_position(id_of(i), units_of(i, servos_[i].angle()));
  }
}

void LscMachine::update_load() {
  std::array<double, kMaxJoints> q{};
  for (std::size_t i = 0; i < joints_; ++i) q[i] = servos_[i].angle();
  load_.update(std::span(q).first(joints_));
  load_due_ = now_ + kLoadStep;
}

std::optional<Instant> LscMachine::next_event() const {
  if (!powered_) return std::nullopt;
  return board_.next_event();
}

Truth LscMachine::truth() const {
  Truth truth;
  for (std::size_t i = 0; i < joints_; ++i) {
    const LscBoard::Command command = board_.command(id_of(i));
    const ServoMotor& servo = servos_[i];
    JointTruth joint;
    joint.q = servo.angle();
    joint.qd = servo.speed();
    const bool measures = device_.profile == LscProfile::kBus;
    joint.believed = measures ? joint.q : horn_of(i, command.units);
    joint.stalled = command.driven && servo.effort() >= kPushing && std::abs(servo.speed()) < 1e-3;
    joint.at_end_stop = servo.at_end();
    truth.joints.push_back(joint);
    truth.moving = truth.moving || std::abs(servo.speed()) > 1e-3;
  }
  const ServoMotor& jaws = servos_.back();
  truth.moving = truth.moving || std::abs(jaws.speed()) > 1e-3 || board_.moving();
  truth.tool = jaw_span_ > 0 ? width_max_ * (1 - jaws.angle() / jaw_span_) : 0;
  truth.supply_volts = supply_volts_;
  truth.bytes_lost = bytes_lost_ + board_.bytes_lost();
  return truth;
}

LastingState LscMachine::lasting_state() const {
  LastingState state;
  for (const ServoMotor& servo : servos_) state.bodies.push_back({servo.angle(), servo.speed()});
  const LscBoard::Memory memory = board_.memory();
  state.memory.assign(memory.begin(), memory.end());
  return state;
}

bool LscMachine::restore(const LastingState& state) {
  if (state.bodies.size() != servos_.size() || !board_.set_memory(state.memory)) return false;
  for (std::size_t i = 0; i < servos_.size(); ++i) {
    servos_[i].place(state.bodies[i].angle, state.bodies[i].speed);
  }
  update_load();
  sense();
  return true;
}

void LscMachine::disturb(const Disturbance& what) {
  using Kind = Disturbance::Kind;
  if (what.kind == Kind::kSupply) battery_volts_ = what.value;
  if (what.kind == Kind::kPayload) load_.set_payload(what.value);
  if (what.kind == Kind::kPayload) update_load();
  if (what.joint < 0 || static_cast<std::size_t>(what.joint) >= servos_.size()) return;
  const auto i = static_cast<std::size_t>(what.joint);
  ServoMotor& servo = servos_[i];
  if (what.kind == Kind::kUnblock) servo.unblock();
  if (what.kind == Kind::kLoad) extra_load_[i] = what.value;
  if (what.kind != Kind::kBlock) return;
  if (is_jaws(i)) {
    servo.block_above((1 - what.value / width_max_) * jaw_span_);
  } else if (servo.angle() <= what.value) {
    servo.block_above(what.value);
  } else {
    servo.block_below(what.value);
  }
}

void LscMachine::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  if (powered_) {
    board_.receive(bytes, now);
  } else {
    bytes_lost_ += bytes.size();
  }
}

std::size_t LscMachine::take_output(std::span<std::uint8_t> out) {
  return powered_ ? board_.take_output(out) : 0;
}

}  // namespace sinew::sim
