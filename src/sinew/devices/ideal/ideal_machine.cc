#include "sinew/devices/ideal/ideal_machine.h"

#include <algorithm>

namespace sinew::sim {
namespace {

constexpr double kSupplyNominal = 12;  // V, of a machine that does not exist
constexpr double kSupplyMin = 6;       // V; its brakes hold below

std::optional<JawGripper> gripper_of(const RobotModel& robot) {
  const auto* geometry = std::get_if<SerialGeometry>(&robot.geometry);
  return geometry != nullptr ? geometry->gripper : std::nullopt;
}

}  // namespace

IdealMachine::IdealMachine(const RobotModel& robot, Instant boot)
    : device_(robot.joints, gripper_of(robot), boot), supply_volts_(kSupplyNominal) {}

bool IdealMachine::powered() const {
  return supply_volts_ >= kSupplyMin;
}

void IdealMachine::advance(Instant now) {
  device_.advance(now);
}

Truth IdealMachine::truth() const {
  Truth truth;
  for (std::size_t i = 0; i < device_.q().size(); ++i) {
    JointTruth joint;
    joint.q = joint.believed = device_.q()[i];
    joint.qd = device_.qd()[i];
    joint.stalled = device_.blocked_joint() == static_cast<int>(i);
    truth.joints.push_back(joint);
  }
  truth.supply_volts = supply_volts_;
  truth.moving = device_.moving();
  truth.tool = device_.jaws();
  truth.bytes_lost = bytes_lost_;
  return truth;
}

void IdealMachine::disturb(const Disturbance& what) {
  const auto joint = static_cast<std::size_t>(std::max<std::int8_t>(what.joint, 0));
  SINEW_ASSERT(joint <= device_.q().size());
  const bool is_jaws = joint == device_.q().size();
  switch (what.kind) {
    case Disturbance::Kind::kSupply:
      supply_volts_ = what.value;
      if (!powered()) device_.lose_power();
      break;
    case Disturbance::Kind::kBlock:
      is_jaws ? device_.block_jaws(what.value) : device_.block(joint, what.value);
      break;
    case Disturbance::Kind::kUnblock:
      is_jaws ? device_.unblock_jaws() : device_.unblock(joint);
      break;
    default:
      break;
  }
}

LastingState IdealMachine::lasting_state() const {
  LastingState state;
  for (const double q : device_.q()) state.bodies.push_back({q, 0});
  return state;
}

bool IdealMachine::restore(const LastingState& state) {
  if (state.bodies.size() != device_.q().size() || !state.memory.empty()) return false;
  JointVector q;
  for (const LastingState::Body& body : state.bodies) q.push_back(body.angle);
  device_.place({q.data(), q.size()});
  return true;
}

void IdealMachine::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  if (!powered()) return;
  for (const std::uint8_t byte : bytes) {
    if (decoder_.push(byte) != ideal::LineDecoder::Result::kLine) continue;
    const auto request = ideal::decode_request(decoder_.words());
    ideal::Numbered<ideal::Reply> reply{0, ideal::Refusal{ideal::Why::kForm}};
    if (request) reply = {request->number, device_.answer(request->what, now)};
    const ideal::Line line = ideal::encode(reply);
    if (output_.size() + line.size() > output_.capacity()) {
      bytes_lost_ += line.size();
      continue;
    }
    for (const std::uint8_t one : line) output_.push_back(one);
  }
}

}  // namespace sinew::sim
