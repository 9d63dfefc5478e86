#pragma once

#include <cstddef>
#include <optional>

#include "sinew/config/table_reader.h"
#include "sinew/model/robot_model.h"

/// One reader for each wire: the rest of [device], with its [device.joint.<name>] tables. The model
/// has its joints by then, as many as the wire needs.
namespace sinew {

void read_bigrobotarm(TableReader& reader, RobotModel& model);
void read_axis_registers(TableReader& reader, RobotModel& model);
void read_axis_link(TableReader& reader, RobotModel& model);
void read_lsc(TableReader& reader, RobotModel& model);
void read_maxarm(TableReader& reader, RobotModel& model);
void read_icp(TableReader& reader, RobotModel& model);

/// No joint is faster than its board makes steps, as far as its drive is known.
void check_step_rates(TableReader& root, const RobotModel& model);

/// Steps or pulses of a device for an angle, either sign, never next to nothing.
void read_per_angle(TableReader& reader, std::string_view pattern, double& out);

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
