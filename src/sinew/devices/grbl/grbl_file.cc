#include "sinew/devices/grbl/grbl_file.h"

#include "sinew/devices/grbl/grbl_settings.h"
#include "sinew/devices/table_file.h"

namespace sinew {

void read_grbl(TableReader& reader, RobotModel& model) {
  constexpr Named<bool> kYesNo[] = {{"yes", true}, {"no", false}};
  constexpr Named<bool> kEnds[] = {{"lower", true}, {"upper", false}};
  if (model.joints.size() > GrblDevice::kAxesMax ||
      !std::holds_alternative<SerialGeometry>(model.geometry)) {
    reader.complain("protocol", "this wire drives arms of up to 6 joints");
    return reader.ignore_rest();
  }
  auto& device = model.device.settings.emplace<GrblDevice>();
  device.axes.resize(model.joints.size());
  // The rest is for its planner, to catch up where a motion was slower than planned.
  model.device.capability.limits_share = 0.9;
  model.device.capability.nudge_max = GrblDevice::kNudgeMax;
  model.device.capability.nudge_slide_max = GrblDevice::kNudgeMaxSliding;
  model.device.capability.probes = true;
  reader.choice("homing", kYesNo, device.homes);
  for_each_joint(reader, model, [&](std::size_t i, TableReader& table) {
    GrblDevice::Axis& axis = device.axes[i];
    const bool slides = model.joints[i].slides();
    if (slides) axis.unit = from_mm(1);
    double steps = 0;  // per rad or m
    read_per_way(table, "steps_per_*", model.joints[i].kind, steps);
    axis.steps_per_unit = steps * axis.unit;
    const double farthest = slides ? 10 : from_deg(720);
    const Dimension place = slides ? Dimension(kLength) : Dimension(kAngle);
    table.optional().quantity("machine_zero_*", place, between(-farthest, farthest), axis.zero);
    table.optional().choice("homing_end", kEnds, axis.homes_down);
  });
}

}  // namespace sinew
