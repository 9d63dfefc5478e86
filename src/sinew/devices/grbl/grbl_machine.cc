#include "sinew/devices/grbl/grbl_machine.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"

namespace sinew::sim {
namespace {

constexpr double kSupplyNominal = 24;  // V
constexpr double kSupplyMin = 8;       // V; below it its processor starts anew
constexpr Duration kTick = std::chrono::milliseconds(1);
constexpr double kSwitchBeyond = 1;  // units
constexpr double kPullOff = 2;       // units
constexpr double kAnywhere = 1e9;
/// A motor whose steps end at once turns on for about so long.
constexpr double kSkid = 2e-3;  // s

double switch_of(const Joint& joint, const sinew::GrblDevice::Axis& axis) {
  const double beyond = kSwitchBeyond * axis.unit;
  return axis.homes_down ? joint.lower - beyond : joint.upper + beyond;
}

/// Set up for this robot.
grbl::BoardSettings settings_of(const RobotModel& robot) {
  const auto& device = robot.device.settings.get<sinew::GrblDevice>();
  grbl::BoardSettings settings;
  settings.firmware = static_cast<grbl::Firmware>(device.firmware);
  settings.homing = device.homes;
  settings.pull_off = kPullOff;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    const sinew::GrblDevice::Axis& own = device.axes[i];
    const double back = device.from_units(i, kPullOff) * (own.homes_down ? 1 : -1);
    const double homed = switch_of(joint, own) + back;
    settings.axes.push_back(
        {device.steps_per_unit(i),
         {device.to_units(i, joint.velocity_max), device.to_units(i, joint.acceleration_max)},
         device.to_units(i, joint.upper - joint.lower),
         own.homes_down == (device.sign(i) > 0),
         device.sign(i) * device.to_units(i, homed - own.zero)});
  }
  return settings;
}

}  // namespace

GrblMachine::GrblMachine(const RobotModel& robot, Instant boot)
    : joints_(robot.joints),
      device_(robot.device.settings.get<sinew::GrblDevice>()),
      board_(settings_of(robot), boot),
      supply_volts_(kSupplyNominal),
      now_(boot) {
  for (const Joint& joint : joints_) {
    bodies_.push_back({joint.home, joint.home, 0, -kAnywhere, kAnywhere, kAnywhere, true});
    speeds_.push_back(0);
  }
}

void GrblMachine::advance(Instant now) {
  while (now_ < now) {
    const Instant next = board_.next_event() ? std::min(now, now_ + kTick) : now;
    now_ = next;
    board_.advance(now_);
    follow();
  }
}

/// The joints go where the motors turn them.
void GrblMachine::follow() {
  skid();
  grbl::AxisMask closed = 0;
  bool touches = false;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Body& body = bodies_[i];
    const sinew::GrblDevice::Axis& axis = device_.axes[i];
    const double wanted = body.base + device_.sign(i) * device_.from_units(i, board_.turned(i));
    body.q = std::clamp(wanted, body.lower, body.upper);
    body.base += body.q - wanted;
    body.lost += body.q - wanted;
    const double at = switch_of(joints_[i], axis);
    if (axis.homes_down ? body.q <= at : body.q >= at) closed |= grbl::AxisMask(1U << i);
    touches |= body.touches_above ? body.q >= body.touches : body.q <= body.touches;
  }
  board_.set_switches(closed);
  board_.set_probe(touches);
  const bool found = homing_ && board_.state() == grbl::State::kIdle;
  homing_ = board_.state() == grbl::State::kHome;
  if (found) forget_lost();
}

/// It counts anew.
void GrblMachine::forget_lost() {
  for (Body& body : bodies_) body.lost = 0;
}

/// Steps that end at once leave their motors a little further on.
void GrblMachine::skid() {
  const bool cut = board_.state() == grbl::State::kAlarm && !board_.moving();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Body& body = bodies_[i];
    if (cut) body.base += speeds_[i] * kSkid, body.lost += speeds_[i] * kSkid;
    speeds_[i] = device_.sign(i) * device_.from_units(i, board_.velocity(i));
  }
}

Truth GrblMachine::truth() const {
  Truth truth;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    JointTruth joint;
    joint.q = body.q;
    joint.qd = speeds_[i];
    joint.believed = body.q - body.lost;
    joint.lost_steps = body.lost != 0;
    joint.at_end_stop = body.q <= body.lower || body.q >= body.upper;
    truth.joints.push_back(joint);
  }
  truth.supply_volts = supply_volts_;
  truth.moving = board_.moving();
  truth.deaf = !board_.powered();
  truth.bytes_lost = board_.bytes_lost();
  return truth;
}

void GrblMachine::disturb(const Disturbance& what) {
  const auto joint = static_cast<std::size_t>(std::max<std::int8_t>(what.joint, 0));
  switch (what.kind) {
    case Disturbance::Kind::kSupply:
      supply_volts_ = what.value;
      if (board_.powered() && supply_volts_ < kSupplyMin) {
        board_.lose_power();
      } else if (!board_.powered() && supply_volts_ >= kSupplyMin) {
        board_.power_up(now_);
        forget_lost();
      }
      break;
    case Disturbance::Kind::kBlock: {
      SINEW_ASSERT(joint < bodies_.size());
      Body& body = bodies_[joint];
      (what.value >= body.q ? body.upper : body.lower) = what.value;
      break;
    }
    case Disturbance::Kind::kProbe: {
      SINEW_ASSERT(joint < bodies_.size());
      Body& body = bodies_[joint];
      body.touches = what.value;
      body.touches_above = what.value >= body.q;
      break;
    }
    case Disturbance::Kind::kUnblock:
      SINEW_ASSERT(joint < bodies_.size());
      bodies_[joint].lower = -kAnywhere;
      bodies_[joint].upper = kAnywhere;
      break;
    default:
      break;
  }
}

LastingState GrblMachine::lasting_state() const {
  LastingState state;
  for (const Body& body : bodies_) state.bodies.push_back({body.q, 0});
  return state;
}

bool GrblMachine::restore(const LastingState& state) {
  if (state.bodies.size() != bodies_.size() || !state.memory.empty()) return false;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Body& body = bodies_[i];
    body.base += state.bodies[i].angle - body.q;
    body.q = state.bodies[i].angle;
  }
  return true;
}

void GrblMachine::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  for (const std::uint8_t byte : bytes) board_.receive(byte, now);
  follow();
}

}  // namespace sinew::sim
