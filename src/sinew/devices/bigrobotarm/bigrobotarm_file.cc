#include "sinew/devices/bigrobotarm/bigrobotarm_file.h"

#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/table_file.h"

namespace sinew {

void read_motor(TableReader& table, BigRobotArmJoint& joint) {
  read_per_angle(table, "steps_per_*", joint.steps_per_rad);
  table.number("steps_per_motor_rev", between(1, 1e6), joint.steps_per_motor_rev);
}

void read_nudge(TableReader& reader, RobotModel& model) {
  reader.quantity("nudge_*_max", kAngle, above_zero_to(BigRobotArmDevice::kNudgeMax),
                  model.device.capability.nudge_max);
}

void read_bigrobotarm(TableReader& reader, RobotModel& model) {
  struct Wire {
    BigRobotArmWire wire = BigRobotArmWire::kByte;
    BigRobotArmDialect dialect = BigRobotArmDialect::k2021;
    bool probe = false;
  };
  constexpr Named<Wire> kWires[] = {
      {"byte", {}},
      {"text", {BigRobotArmWire::kText}},
      {"text2026", {BigRobotArmWire::kText, BigRobotArmDialect::k2026}},
      {"probe", {BigRobotArmWire::kByte, BigRobotArmDialect::k2021, true}},
  };
  constexpr std::int32_t kMaxMultiplier = 3000;  // the document's own user interface ends there
  auto& device = model.device.settings.emplace<BigRobotArmDevice>();
  Wire wire;
  reader.choice("wire", kWires, wire);
  device.wire = wire.wire;
  device.dialect = wire.dialect;
  device.probe_wire = wire.probe;
  reader.integer("multiplier_max", 1, kMaxMultiplier, device.multiplier_max);
  reader.integer("gripper_max", 0, 255, device.gripper_max);
  read_nudge(reader, model);
  for_each_joint(reader, model, [&](std::size_t i, TableReader& table) {
    BigRobotArmJoint& joint = device.joints[i];
    read_motor(table, joint);
    table.integer("multiplier_boot", 1, device.multiplier_max, joint.multiplier_boot);
  });
}

}  // namespace sinew
