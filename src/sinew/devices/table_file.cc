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
  const auto slide = std::ranges::find(model.joints, JointKind::kPrismatic, &Joint::kind);
  const bool arm = std::holds_alternative<SerialGeometry>(model.geometry);
  if (arm && slide != model.joints.end() && !table.slides) {
    reader.complain("protocol", "this wire drives joints that turn, and " + slide->name +
                                    " slides; use grbl, or leave [device] out to simulate the arm");
    reader.ignore_rest();
    return false;
  }
  if (device.capability.motion == MotionKind::kStream) {
    std::int64_t segment_ms = 0;
    reader.integer("segment_ms", table.segment_ms_min, table.segment_ms_max, segment_ms);
    device.capability.segment = std::chrono::milliseconds(segment_ms);
  }
  return true;
}

void read_per_angle(TableReader& reader, std::string_view pattern, double& out) {
  read_per_way(reader, pattern, JointKind::kRevolute, out);
}

void read_per_way(TableReader& reader, std::string_view pattern, JointKind kind, double& out) {
  const bool slides = kind == JointKind::kPrismatic;
  const double most = slides ? 1e8 : 1e6;  // per m, per rad
  const double fewest = slides ? 1e3 : 1;
  const Dimension dimension = slides ? Dimension(kPerLength) : Dimension(kPerAngle);
  if (reader.quantity(pattern, dimension, between(-most, most), out) && std::abs(out) < fewest) {
    reader.complain(pattern, slides ? "must be at least one per mm, either sign"
                                    : "must be at least one per radian, either sign");
  }
}

bool joints_are_sound(const RobotModel& model) {
  std::set<std::string_view> names;
  for (const Joint& joint : model.joints) names.insert(joint.name);
  return model.joints.size() == joints_moved_by(model.geometry) &&
         names.size() == model.joints.size() && !names.contains("");
}

}  // namespace sinew
