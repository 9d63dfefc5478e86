#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "sinew/model/device_table.h"
#include "sinew/model/robot_model.h"
#include "sinew/toml/table_reader.h"

/// The table [device] of a robot's file: what the readers of all kinds have in common.
namespace sinew {

/// `motion`, `feedback`, `baud` and `segment_ms`. False: the rest is not looked at, since the robot
/// has joints that this device cannot drive; complained about.
bool read_capability(TableReader& reader, const DeviceTable& table, RobotModel& model);

/// Steps or pulses of a device for an angle, either sign, never next to nothing.
void read_per_angle(TableReader& reader, std::string_view pattern, double& out);
/// The same for a way of a joint of this kind. @param out  per rad, or per m
void read_per_way(TableReader& reader, std::string_view pattern, JointKind kind, double& out);

/// Every joint has a name of its own and moves something; where not, that has been complained
/// about, and tables that go by these names are not looked at.
bool joints_are_sound(const RobotModel& model);

/// Calls `read(i, table)` for the [device.joint.<name>] of every joint, and closes it.
template <class Read>
void for_each_joint(TableReader& reader, const RobotModel& model, Read&& read) {
  std::optional<TableReader> joints = reader.table("joint");
  if (!joints) return;
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    std::optional<TableReader> joint = joints->table(model.joints[i].name);
    if (!joint) continue;
    read(i, *joint);
    joint->finish();
  }
  joints->finish();
}

}  // namespace sinew
