#include "sinew/control/machine_identity.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <variant>

namespace sinew::control {
namespace {

struct GeometryWords {
  IdentityText& out;

  void add(const Vec3& p) const { out.add(p.x), out.add(p.y), out.add(p.z); }

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
      add(geometry.p_BA[leg]), add(geometry.p_PA[leg]);
    }
  }
};

}  // namespace

JournalOwner journal_owner(const RobotModel& robot) {
  IdentityText words;
  words.add(robot.device.protocol);
  for (const Joint& joint : robot.joints) {
    words.add(joint.name), words.add(joint.slides());
  }
  robot.device.settings->identify(words);
  std::visit(GeometryWords{words}, robot.geometry);
  return {journal_hash(robot.id), journal_hash(words.text())};
}

JournalSettings journal_settings(const RobotModel& robot) {
  constexpr double kBlockTime = 0.25;  // s at full speed: four syncs a second
  constexpr double kLeadTime = 0.08;   // s: the longest sync of an SD card that is not in trouble
  JournalSettings settings;
  settings.owner = journal_owner(robot);
  const std::optional<CountGrain> grain = robot.device.settings->count_grain();
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Joint& joint = robot.joints[j];
    JournalJoint own{.block = kBlockTime * joint.velocity_max,
                     .lead = kLeadTime * joint.velocity_max,
                     .slack = 0,
                     .lower = joint.lower,
                     .upper = joint.upper};
    if (grain) {
      own.block = grain->block;
      own.lead = grain->lead;
      own.slack = grain->slack;
    } else if (robot.device.capability.feedback == PositionFeedback::kMeasured) {
      // rad: what a sensor jitters by.
      own.slack = std::max(1e-3, robot.device.settings->resolution(j));
    }
    settings.joints.push_back(own);
  }
  return settings;
}

RecoverySettings recovery_settings(const RobotModel& robot) {
  RecoverySettings settings;
  settings.owner = journal_owner(robot);
  settings.joints = robot.joints.size();
  const DeviceSettings& device = *robot.device.settings;
  const bool shown = device.shows_power_loss();
  settings.power_may_have_failed = !shown;
  const std::optional<CountGrain> grain = device.count_grain();
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    settings.power_up_way.push_back(shown ? 0 : std::numeric_limits<double>::infinity());
    if (grain) settings.forgotten_way.push_back(grain->forgotten);
  }
  settings.can_home = device.searches_zeros() || !device.axis_boards().empty();
  return settings;
}

}  // namespace sinew::control
