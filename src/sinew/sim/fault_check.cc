#include <algorithm>
#include <string>

#include "sinew/sim/fault_switches.h"
#include "sinew/sim/link_fault.h"

// Whether a plan of faults can befall a robot.

namespace sinew::sim {
namespace {

using Kind = Disturbance::Kind;

/// Whether a second encoder, on the joint itself, is coupled to it.
bool has_joint_encoder(const RobotModel& robot, std::size_t joint) {
  const auto& drives = robot.dynamics.drives;
  return !boards_of(robot.device).empty() && joint < drives.size() &&
         drives[joint].joint_encoder != JointEncoder::kNone;
}

std::expected<void, std::string> check_unit(const TimedDisturbance& timed, const Joint& joint,
                                            const std::string& name) {
  if (!timed.unit || *timed.unit == joint.kind) return {};
  const bool leg = joint.slides();
  const bool load = timed.what.kind == Kind::kLoad;
  std::string right;
  if (!load) {
    right = leg ? "its place is a length, as 12mm" : "its place is an angle, as 20deg";
  } else {
    right = leg ? "its load is a force, as 2N" : "its load is a torque, as 0.5Nm";
  }
  const std::string item(load ? "load" : place_item(timed.what.kind));
  return std::unexpected(item + "=" + name + ": " + joint.name +
                         (leg ? " is a leg; " : " is a joint that turns; ") + right);
}

/// What is undone must have been done, or it says nothing.
std::expected<void, std::string> check_undoing(const FaultPlan& plan, const TimedDisturbance& timed,
                                               const std::string& name) {
  const Kind kind = timed.what.kind;
  const FaultSwitch* part = switch_of(kind);
  const bool undoes = kind == Kind::kUnblock || (part != nullptr && timed.what.value != 0);
  if (!undoes) return {};
  const bool done = std::ranges::any_of(plan.disturbances, [&](const TimedDisturbance& other) {
    const bool counterpart = part != nullptr ? other.what.kind == kind && other.what.value == 0
                                             : other.what.kind == Kind::kBlock;
    return counterpart && other.what.joint == timed.what.joint && other.at < timed.at;
  });
  if (done) return {};
  if (part != nullptr) {
    const std::string item = std::string(part->name) + "=" + name + ":";
    return std::unexpected(item + std::string(part->good) + ": " + std::string(part->is_good) +
                           "; it goes with " + item + std::string(part->bad) + "@4s");
  }
  return std::unexpected("unblock=" + name + ": nothing blocks " + name +
                         " before; it goes with block=" + name + "@20deg@4s");
}

}  // namespace

std::expected<void, std::string> check_faults(const FaultPlan& plan, const RobotModel& robot) {
  for (const TimedDisturbance& timed : plan.disturbances) {
    if (timed.what.joint < 0) continue;
    const auto joint = static_cast<std::size_t>(timed.what.joint);
    const std::string name = "J" + std::to_string(joint + 1);
    if (joint >= robot.joints.size()) {
      return std::unexpected("the robot has no " + name + "; its joints are J1 to J" +
                             std::to_string(robot.joints.size()));
    }
    if (timed.what.kind == Kind::kMagnet && !robot.device.settings->has_magnets()) {
      return std::unexpected("magnet=" + name + ": " + robot.id +
                             " has no magnet that could fall off: no sensor looks at its joints");
    }
    if (timed.what.kind == Kind::kCoupling && !has_joint_encoder(robot, joint)) {
      return std::unexpected("coupling=" + name + ": " + robot.id +
                             " has no encoder of its own on that joint that could come loose");
    }
    if (timed.what.kind == Kind::kLead && !robot.device.settings->watches_leads()) {
      return std::unexpected("lead=" + name + ": " + robot.id +
                             " has no module that watches the leads of its motors");
    }
    if (timed.what.kind == Kind::kProbe && !robot.device.capability.probes) {
      return std::unexpected("probe=" + name + ": the device of " + robot.id +
                             " has no probe input");
    }
    if (auto fine = check_unit(timed, robot.joints[joint], name); !fine) return fine;
    if (auto fine = check_undoing(plan, timed, name); !fine) return fine;
  }
  return {};
}

}  // namespace sinew::sim
