#include "sinew/config/read_device.h"

#include <set>

#include "sinew/config/read_devices.h"
#include "sinew/config/read_joints.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"

namespace sinew {
namespace {

/// One wire: its name, whether it runs over a serial port, how many joints it drives (0: any), how
/// long a streamed segment may be, what it drives at the end of the arm, who reads the rest.
struct Protocol {
  std::string_view name;
  bool serial_port = false;
  std::size_t joints = 0;
  std::int64_t segment_ms_max = 0;  ///< of a streamed motion
  HandDrive hand = HandDrive::kNone;
  void (*read)(TableReader&, RobotModel&) = nullptr;
  void (*check)(TableReader&, const RobotModel&) = nullptr;
};

constexpr std::size_t kMaxArmJoints = 3;

/// The longest line of the ideal wire, and the pace at which a motion of such lines still streams.
constexpr double kIdealLineBits = 264 * 10;
constexpr std::int64_t kIdealBaudLeast = 57'600;

using enum HandDrive;
constexpr Named<Protocol> kProtocols[] = {
    {"ideal", {"ideal", true, 0, 0, kJaws}},
    {"bigrobotarm", {"bigrobotarm", true, kBigRobotArmJoints, 1000, kServo, read_bigrobotarm}},
    {"lsc", {"lsc", true, 0, 100, kJaws, read_lsc}},
    {"maxarm", {"maxarm", true, kMaxArmJoints, 1000, kSuction, read_maxarm}},
    {"icp", {"icp", true, kLegs, 1000, kNone, read_icp}},
    {"axis_registers",
     {"axis_registers", false, 0, 1000, kNone, read_axis_registers, check_step_rates}},
    {"axis_link", {"axis_link", false, 0, 100, kNone, read_axis_link, check_step_rates}},
};

}  // namespace

bool joints_are_sound(const RobotModel& model) {
  std::set<std::string_view> names;
  for (const Joint& joint : model.joints) names.insert(joint.name);
  return model.joints.size() == joints_moved_by(model.geometry) &&
         names.size() == model.joints.size() && !names.contains("");
}

void read_device(TableReader& root, RobotModel& model) {
  constexpr Named<MotionKind> kMotions[] = {{"stream", MotionKind::kStream},
                                            {"point_to_point", MotionKind::kPointToPoint}};
  constexpr Named<PositionFeedback> kFeedbacks[] = {{"measured", PositionFeedback::kMeasured},
                                                    {"commanded", PositionFeedback::kCommanded},
                                                    {"none", PositionFeedback::kNone}};
  std::optional<TableReader> reader = root.table("device", Presence::kOptional);
  if (!reader) return;
  Device& device = model.device = {};
  Protocol protocol{};
  if (!reader->choice("protocol", kProtocols, protocol)) {
    reader->ignore_rest();
    reader->finish();
    return;
  }
  device.protocol = protocol.name;
  if (protocol.name == "ideal") {  // what it can do is the same for each robot
    reader->needs_no_source();     // whoever writes the sketch chooses it
    reader->optional().integer("baud", kIdealBaudLeast, 4'000'000, device.baud);
    // Three quarters of the line for the segments, whatever its pace.
    const double line_s = kIdealLineBits / device.baud;
    device.capability.segment = std::max(device.capability.segment, from_seconds(line_s / 0.75));
    reader->finish();
    return;
  }
  device.capability = {.hand = protocol.hand};
  reader->choice("motion", kMotions, device.capability.motion);
  reader->choice("feedback", kFeedbacks, device.capability.feedback);
  if (protocol.serial_port) reader->integer("baud", 300, 4'000'000, device.baud);
  if (!joints_are_sound(model)) {
    reader->ignore_rest();
  } else if (protocol.joints != 0 && model.joints.size() != protocol.joints) {
    reader->complain("protocol", "this wire drives " + std::to_string(protocol.joints) +
                                     " joints, the robot has " +
                                     std::to_string(model.joints.size()));
    reader->ignore_rest();
  } else {
    if (device.capability.motion == MotionKind::kStream) {
      std::int64_t segment_ms = 0;
      reader->integer("segment_ms", 1, protocol.segment_ms_max, segment_ms);
      device.capability.segment = std::chrono::milliseconds(segment_ms);
    }
    if (protocol.name == "axis_link") device.capability.limits_share = 0.8;
    if (protocol.name == "axis_registers") device.capability.takes_speed = false;
    protocol.read(*reader, model);
  }
  reader->finish();
}

void check_device(TableReader& root, const RobotModel& model) {
  if (!root.clean()) return;
  for (const Named<Protocol>& one : kProtocols) {
    if (one.name == model.device.protocol && one.value.check != nullptr) {
      one.value.check(root, model);
    }
  }
}

}  // namespace sinew
