#include "sinew/devices/table_file.h"

#include <cmath>
#include <set>
#include <string>

#include "sinew/model/joints_moved.h"

namespace sinew {

bool read_capability(TableReader& reader, const DeviceTable& table, RobotModel& model) {
  constexpr Named<MotionKind> kMotions[] = {{"stream", MotionKind::kStream},
                                            {"point_to_point", MotionKind::kPointToPoint}};
  constexpr Named<PositionFeedback> kFeedbacks[] = {{"measured", PositionFeedback::kMeasured},
                                                    {"commanded", PositionFeedback::kCommanded},
                                                    {"none", PositionFeedback::kNone}};
  Device& device = model.device;
  device.capability = {.hand = table.hand};
  reader.choice("motion", kMotions, device.capability.motion);
  reader.choice("feedback", kFeedbacks, device.capability.feedback);
  if (table.serial_port) reader.integer("baud", 300, 4'000'000, device.baud);
  if (!joints_are_sound(model)) {
    reader.ignore_rest();
    return false;
  }
  if (table.joints != 0 && model.joints.size() != table.joints) {
    reader.complain("protocol", "this wire drives " + std::to_string(table.joints) +
                                    " joints, the robot has " +
                                    std::to_string(model.joints.size()));
    reader.ignore_rest();
    return false;
  }
  if (device.capability.motion == MotionKind::kStream) {
    std::int64_t segment_ms = 0;
    reader.integer("segment_ms", 1, table.segment_ms_max, segment_ms);
    device.capability.segment = std::chrono::milliseconds(segment_ms);
  }
  return true;
}

void read_per_angle(TableReader& reader, std::string_view pattern, double& out) {
  constexpr Range kUnits = between(-1e6, 1e6);  // per rad
  constexpr double kFewest = 1;                 // per rad
  if (reader.quantity(pattern, kPerAngle, kUnits, out) && std::abs(out) < kFewest) {
    reader.complain(pattern, "must be at least one per radian, either sign");
  }
}

bool joints_are_sound(const RobotModel& model) {
  std::set<std::string_view> names;
  for (const Joint& joint : model.joints) names.insert(joint.name);
  return model.joints.size() == joints_moved_by(model.geometry) &&
         names.size() == model.joints.size() && !names.contains("");
}

}  // namespace sinew
