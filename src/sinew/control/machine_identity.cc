#include "sinew/control/machine_identity.h"

#include <array>
#include <bit>
#include <limits>
#include <string>
#include <variant>

#include "sinew/driver/icp_leg.h"

namespace sinew::control {
namespace {

/// Everything in one text, whose hash is taken. Numbers as they are, to the last bit.
class Description {
 public:
  void add(double number) {
    const auto bytes = std::bit_cast<std::array<char, sizeof number>>(number);
    text_.append(bytes.data(), bytes.size());
  }
  void add(bool flag) { text_ += flag ? "1;" : "0;"; }
  void add(std::string_view word) {
    text_ += word;
    text_ += ';';
  }
  void add(const Vec3& p) { add(p.x), add(p.y), add(p.z); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

struct DeviceWords {
  Description& out;

  void operator()(const IdealDevice& /*device*/) const { out.add(std::string_view("ideal")); }
  void operator()(const BigRobotArmDevice& device) const {
    for (const BigRobotArmJoint& joint : device.joints) out.add(joint.steps_per_rad);
  }
  void operator()(const AxisRegistersDevice& device) const {
    for (const AxisBoard& board : device.boards) out.add(board.zero);
  }
  void operator()(const AxisLinkDevice& device) const {
    for (const AxisBoard& board : device.boards) out.add(board.zero);
  }
  void operator()(const LscDevice& device) const {
    for (const LscServo& servo : device.servos) {
      out.add(static_cast<double>(servo.id)), out.add(servo.centre), out.add(servo.units_per_rad),
          out.add(servo.trim);
    }
  }
  void operator()(const MaxArmDevice& device) const {
    for (const MaxArmServo& servo : device.servos) {
      out.add(servo.offset), out.add(servo.pulses_per_rad);
    }
  }
  void operator()(const IcpDevice& device) const {
    out.add(device.units_per_m), out.add(device.units_per_down);
    for (const IcpLeg& leg : device.legs) out.add(leg.invert);
  }
};

struct GeometryWords {
  Description& out;

  void operator()(const SerialGeometry& geometry) const {
    for (const DhRow& row : geometry.rows) {
      out.add(row.d), out.add(row.a), out.add(row.alpha), out.add(row.theta_offset);
    }
  }
  void operator()(const PalletizerGeometry& geometry) const {
    for (const double length : {geometry.base_height, geometry.shoulder_offset, geometry.upper_arm,
                                geometry.forearm, geometry.tool_offset, geometry.base_front}) {
      out.add(length);
    }
  }
  void operator()(const HexapodGeometry& geometry) const {
    for (std::size_t leg = 0; leg < kLegs; ++leg) {
      out.add(geometry.p_BA[leg]), out.add(geometry.p_PA[leg]);
    }
  }
};

/// The device itself shows at opening whether it kept its power: counts, modules' target positions,
/// the homed flag of boards that fill their status.
bool shows_power_loss(const Device& device) {
  const auto* boards = std::get_if<AxisRegistersDevice>(&device.settings);
  if (boards != nullptr) return boards->reports_status;
  return std::holds_alternative<IcpDevice>(device.settings) ||
         std::holds_alternative<BigRobotArmDevice>(device.settings);
}

}  // namespace

JournalOwner journal_owner(const RobotModel& robot) {
  Description words;
  words.add(robot.device.protocol);
  for (const Joint& joint : robot.joints) {
    words.add(joint.name), words.add(joint.kind == JointKind::kPrismatic);
  }
  std::visit(DeviceWords{words}, robot.device.settings);
  std::visit(GeometryWords{words}, robot.geometry);
  return {journal_hash(robot.id), journal_hash(words.text())};
}

JournalSettings journal_settings(const RobotModel& robot) {
  constexpr double kBlockTime = 0.25;  // s at full speed: four syncs a second
  constexpr double kLeadTime = 0.08;   // s: the longest sync of an SD card that is not in trouble
  JournalSettings settings;
  settings.owner = journal_owner(robot);
  const auto* icp = std::get_if<IcpDevice>(&robot.device.settings);
  for (const Joint& joint : robot.joints) {
    JournalJoint own{.block = kBlockTime * joint.velocity_max,
                     .lead = kLeadTime * joint.velocity_max,
                     .slack = 0,
                     .lower = joint.lower,
                     .upper = joint.upper};
    if (icp != nullptr) {
      own.block = 64 / icp->units_per_m;
      own.lead = 16 / icp->units_per_m;
      // Noise on the wire may be a step that nobody sent.
      own.slack = 1 / icp->units_per_m;
    } else if (robot.device.capability.feedback == PositionFeedback::kMeasured) {
      own.slack = 1e-3;  // rad: what a sensor jitters by
    }
    settings.joints.push_back(own);
  }
  return settings;
}

RecoverySettings recovery_settings(const RobotModel& robot) {
  RecoverySettings settings;
  settings.owner = journal_owner(robot);
  settings.joints = robot.joints.size();
  const bool shown = shows_power_loss(robot.device);
  settings.power_may_have_failed = !shown;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    settings.power_up_way.push_back(shown ? 0 : std::numeric_limits<double>::infinity());
    if (const auto* icp = std::get_if<IcpDevice>(&robot.device.settings)) {
      settings.forgotten_way.push_back(IcpLegClaim::kPowerCutUnits / icp->units_per_m);
    }
  }
  settings.can_home = std::holds_alternative<AxisRegistersDevice>(robot.device.settings) ||
                      std::holds_alternative<AxisLinkDevice>(robot.device.settings);
  return settings;
}

}  // namespace sinew::control
