#include "sinew/devices/arm_link/arm_link_file.h"

#include "sinew/core/units.h"
#include "sinew/devices/arm_link/arm_link_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_file.h"
#include "sinew/devices/table_file.h"

namespace sinew {

void read_arm_link(TableReader& reader, RobotModel& model) {
  auto& device = model.device.settings.emplace<ArmLinkDevice>();
  std::int64_t deadline_ms = device.deadline / std::chrono::milliseconds(1);
  reader.integer("deadline_ms", 20, 500, deadline_ms);
  device.deadline = std::chrono::milliseconds(deadline_ms);
  reader.integer("gripper_max", 0, 180, device.arm.gripper_max);
  read_nudge(reader, model);
  for_each_joint(reader, model, [&](std::size_t i, TableReader& table) {
    read_motor(table, device.arm.joints[i]);
  });
}

}  // namespace sinew
