#include "sinew/config/read_device.h"

#include <cmath>

namespace sinew {
namespace {

enum class Wire : std::uint8_t { kNone, kSerialPort, kBus, kBigRobotArm };

struct Protocol {
  std::string_view name;
  Wire wire;
};

/// The wires of the reference robots. Those that Sinew does not speak yet have a name and a speed
/// here, so that a robot can be planned and previewed before it can be driven.
constexpr Named<Protocol> kProtocols[] = {
    {"none", {"none", Wire::kNone}},     {"bigrobotarm", {"bigrobotarm", Wire::kBigRobotArm}},
    {"lsc", {"lsc", Wire::kSerialPort}}, {"maxarm", {"maxarm", Wire::kSerialPort}},
    {"icp", {"icp", Wire::kSerialPort}}, {"axis_registers", {"axis_registers", Wire::kBus}},
};

void read_bigrobotarm(TableReader& reader, const RobotModel& model, BigRobotArmDevice& device) {
  constexpr Named<BigRobotArmWire> kWires[] = {{"byte", BigRobotArmWire::kByte},
                                               {"text", BigRobotArmWire::kText}};
  constexpr std::int32_t kMaxMultiplier = 3000;  // the document's own user interface ends there
  constexpr Range kSteps = between(-1e6, 1e6);   // per rad
  constexpr double kFewestSteps = 1;             // per rad
  reader.choice("wire", kWires, device.wire);
  reader.integer("multiplier_max", 1, kMaxMultiplier, device.multiplier_max);
  reader.integer("gripper_max", 0, 255, device.gripper_max);
  std::optional<TableReader> joints = reader.table("joint");
  if (!joints) return;
  for (std::size_t i = 0; i < kBigRobotArmJoints; ++i) {
    if (model.joints[i].name.empty()) {  // complained about at the joint itself
      joints->ignore_rest();
      continue;
    }
    std::optional<TableReader> joint_reader = joints->table(model.joints[i].name);
    if (!joint_reader) continue;
    BigRobotArmJoint& joint = device.joints[i];
    if (joint_reader->quantity("steps_per_*", kPerAngle, kSteps, joint.steps_per_rad) &&
        std::abs(joint.steps_per_rad) < kFewestSteps) {
      joint_reader->complain("steps_per_*", "must be at least one step per radian, either sign");
    }
    joint_reader->number("steps_per_motor_rev", between(1, 1e6), joint.steps_per_motor_rev);
    joint_reader->integer("multiplier_boot", 1, device.multiplier_max, joint.multiplier_boot);
    joint_reader->finish();
  }
  joints->finish();
}

}  // namespace

void read_device(TableReader& root, RobotModel& model) {
  constexpr Named<MotionKind> kMotions[] = {{"stream", MotionKind::kStream},
                                            {"point_to_point", MotionKind::kPointToPoint}};
  constexpr Named<PositionFeedback> kFeedbacks[] = {{"measured", PositionFeedback::kMeasured},
                                                    {"commanded", PositionFeedback::kCommanded},
                                                    {"none", PositionFeedback::kNone}};
  std::optional<TableReader> reader = root.table("device");
  if (!reader) return;
  Device& device = model.device;
  reader->choice("motion", kMotions, device.capability.motion);
  reader->choice("feedback", kFeedbacks, device.capability.feedback);
  Protocol protocol{};
  if (!reader->choice("protocol", kProtocols, protocol)) {
    reader->ignore_rest();
    reader->finish();
    return;
  }
  device.protocol = protocol.name;
  if (protocol.wire == Wire::kSerialPort || protocol.wire == Wire::kBigRobotArm) {
    reader->integer("baud", 300, 4'000'000, device.baud);
  }
  if (protocol.wire == Wire::kBigRobotArm) {
    if (model.joints.size() == kBigRobotArmJoints) {
      read_bigrobotarm(*reader, model, device.settings.emplace<BigRobotArmDevice>());
    } else {
      reader->complain("protocol", "this firmware drives five joints, the robot has " +
                                       std::to_string(model.joints.size()));
      reader->ignore_rest();
    }
  }
  reader->finish();
}

}  // namespace sinew
