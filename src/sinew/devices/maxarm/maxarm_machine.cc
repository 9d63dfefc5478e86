#include "sinew/devices/maxarm/maxarm_machine.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/units.h"

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;

// All assumed: the maker gives no masses. Printed and cut plastic of this size weighs so.
constexpr double kUpperArmMass = 0.12;      // kg, centre half way
constexpr double kForearmMass = 0.10;       // kg, centre half way
constexpr double kToolMass = 0.08;          // kg: nozzle with its servo and hose
constexpr double kGravity = 9.81;           // m/s^2
constexpr double kSupplyNominal = 12;       // V
constexpr double kBoardStops = 5;           // V
constexpr double kEndBeyond = from_deg(5);  // rad of travel beyond the joint's limits
constexpr Duration kTick = 2ms;
constexpr std::uint8_t kPumpOn = 1;

ServoDrive drive_of(const Joint& joint) {
  ServoDrive drive;
  drive.end_lower = joint.lower - kEndBeyond;
  drive.end_upper = joint.upper + kEndBeyond;
  return drive;
}

const MaxArmDevice& settings_of(const RobotModel& robot) {
  const auto* settings = robot.device.settings.as<MaxArmDevice>();
  SINEW_ASSERT(settings != nullptr && robot.joints.size() == 3);
  return *settings;
}

MaxArmDevice with(MaxArmDevice device, MaxArmChecksum checksum, MaxArmVariant variant) {
  device.checksum = checksum;
  device.variant = variant;
  return device;
}

const PalletizerGeometry& geometry_of(const RobotModel& robot) {
  const auto* geometry = std::get_if<PalletizerGeometry>(&robot.geometry);
  SINEW_ASSERT(geometry != nullptr);
  return *geometry;
}

}  // namespace

MaxArmMachine::MaxArmMachine(const RobotModel& robot, MaxArmChecksum checksum,
                             MaxArmVariant variant, std::uint64_t seed, Instant boot)
    : geometry_(geometry_of(robot)),
      device_(with(settings_of(robot), checksum, variant)),
      firmware_(device_, geometry_, seed, boot),
      servos_{ServoMotor(drive_of(robot.joints[0]), robot.joints[0].home),
              ServoMotor(drive_of(robot.joints[1]), robot.joints[1].home),
              ServoMotor(drive_of(robot.joints[2]), robot.joints[2].home)},
      now_(boot),
      supply_volts_(kSupplyNominal) {
  for (const MaxArmServo& servo : device_.servos) SINEW_ASSERT(servo.pulses_per_rad != 0);
  sense();
}

bool MaxArmMachine::powered() const {
  return supply_volts_ >= kBoardStops;
}

double MaxArmMachine::carried() const {
  return firmware_.suction() == kPumpOn && powered() ? object_kg_ : 0;
}

double MaxArmMachine::angle_of(std::size_t joint, double pulse) const {
  return (pulse - device_.servos[joint].offset) / device_.servos[joint].pulses_per_rad;
}

/// Nm on the servo: minus the slope of the weight's energy over its angle, with
/// z = L0 + L2 sin a2 - L3 sin a3 at the wrist.
double MaxArmMachine::gravity(std::size_t joint) const {
  const double tip = kToolMass + carried();
  if (joint == 1) {
    const double lever = geometry_.upper_arm * (kUpperArmMass / 2 + kForearmMass + tip);
    return -kGravity * lever * std::cos(servos_[1].angle());
  }
  if (joint == 2) {
    const double lever = geometry_.forearm * (kForearmMass / 2 + tip);
    return kGravity * lever * std::cos(servos_[2].angle());
  }
  return 0;
}

void MaxArmMachine::sense() {
  MaxArmFirmware::Readings readings;
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (!sensor_ok_[i]) continue;
    const MaxArmServo& servo = device_.servos[i];
    readings[i] = static_cast<std::int16_t>(
        std::lround(servo.offset + servo.pulses_per_rad * servos_[i].angle()));
  }
  firmware_.sense(readings);
}

bool MaxArmMachine::rests() const {
  if (firmware_.ramping(now_)) return false;
  return std::ranges::all_of(servos_, [](const ServoMotor& s) { return s.speed() == 0; });
}

void MaxArmMachine::step_physics(Instant until) {
  if (until <= now_) return;
  const double dt = to_seconds(until - now_);
  const auto targets = firmware_.servo_targets(until);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const bool driven = powered() && firmware_.driven() && sensor_ok_[i];
    servos_[i].set_supply_ratio(supply_volts_ / kSupplyNominal);
    servos_[i].advance(angle_of(i, targets[i]), driven, gravity(i) + extra_load_[i], dt);
  }
  nozzle_ = (firmware_.nozzle_us(until) - 500) / 2000 * kPi;
  now_ = until;
  sense();
}

void MaxArmMachine::advance(Instant now) {
  SINEW_ASSERT(now >= now_);
  while (now_ < now) {
    Instant next = std::min(now, now_ + kTick);
    if (powered()) {
      if (const auto event = firmware_.next_event()) next = std::min(next, std::max(*event, now_));
    }
    step_physics(next);
    if (powered()) firmware_.advance(next);
    if (firmware_.suction() != kPumpOn && held_) object_kg_ = 0;
    held_ = carried() > 0;
  }
}

std::optional<Instant> MaxArmMachine::next_event() const {
  if (!powered()) return std::nullopt;
  return firmware_.next_event();
}

Truth MaxArmMachine::truth() const {
  Truth truth;
  const auto targets = firmware_.servo_targets(now_);
  for (std::size_t i = 0; i < kJoints; ++i) {
    truth.joints.push_back({.q = servos_[i].angle(),
                            .qd = servos_[i].speed(),
                            .believed = angle_of(i, targets[i]),
                            .stalled = false,
                            .at_end_stop = servos_[i].at_end()});
  }
  truth.supply_volts = supply_volts_;
  truth.moving = !rests();
  truth.tool = nozzle_;
  truth.suction = firmware_.suction() == kPumpOn && powered();
  truth.bytes_lost = firmware_.bytes_lost();
  return truth;
}

LastingState MaxArmMachine::lasting_state() const {
  LastingState state;
  for (const ServoMotor& servo : servos_) state.bodies.push_back({servo.angle(), servo.speed()});
  return state;
}

bool MaxArmMachine::restore(const LastingState& state) {
  if (state.bodies.size() != kJoints || !state.memory.empty()) return false;
  for (std::size_t i = 0; i < kJoints; ++i) {
    servos_[i].place(state.bodies[i].angle, state.bodies[i].speed);
  }
  sense();
  return true;
}

void MaxArmMachine::disturb(const Disturbance& what) {
  const auto joint = static_cast<std::size_t>(std::max<std::int8_t>(what.joint, 0));
  SINEW_ASSERT(joint < kJoints);
  ServoMotor& servo = servos_[joint];
  switch (what.kind) {
    case Disturbance::Kind::kSupply: {
      const bool was = powered();
      supply_volts_ = what.value;
      if (!was && powered()) firmware_.power_up(now_);
      break;
    }
    case Disturbance::Kind::kPayload:
      object_kg_ = what.value;
      break;
    case Disturbance::Kind::kBlock:
      if (what.value >= servo.angle()) {
        servo.block_above(what.value);
      } else {
        servo.block_below(what.value);
      }
      break;
    case Disturbance::Kind::kUnblock:
      servo.unblock();
      break;
    case Disturbance::Kind::kCoupling:
    case Disturbance::Kind::kLead:
    case Disturbance::Kind::kProbe:
      break;  // its servos have their sensors inside, and no stepper is there
    case Disturbance::Kind::kMagnet:
      sensor_ok_[joint] = what.value != 0;
      sense();
      break;
    case Disturbance::Kind::kLoad:
      extra_load_[joint] = what.value;
      break;
  }
}

void MaxArmMachine::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  if (powered()) firmware_.receive(bytes, now);
}

std::size_t MaxArmMachine::take_output(std::span<std::uint8_t> out) {
  return firmware_.take_output(out);
}

}  // namespace sinew::sim
