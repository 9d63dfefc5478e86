#include "sinew/cli/output/truth_text.h"

#include <fmt/format.h>

#include <cmath>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/core/units.h"

namespace sinew::cli {
namespace {

/// Nobody cares for less: a thousandth of a degree, a micrometre.
bool differ(const sim::JointTruth& joint, bool leg) {
  return std::abs(joint.q - joint.believed) > (leg ? 1e-6 : from_deg(1e-3));
}

}  // namespace

Json truth_json(const sim::Truth& truth, const RobotModel& model) {
  Json joints = Json::array();
  for (std::size_t i = 0; i < truth.joints.size(); ++i) {
    const sim::JointTruth& joint = truth.joints[i];
    const double factor = shown_value(1, model.joints[i]);
    const std::string unit = std::string("_") + shown_unit(model.joints[i]);
    joints.push_back({{"joint", model.joints[i].name},
                      {"q" + unit, joint.q * factor},
                      {"believed" + unit, joint.believed * factor},
                      {"qd" + unit + "_s", joint.qd * factor},
                      {"stalled", joint.stalled},
                      {"lost_steps_since_power_up", joint.lost_steps},
                      {"at_end_stop", joint.at_end_stop}});
  }
  return {{"joints", joints},         {"moving", truth.moving},
          {"deaf", truth.deaf},       {"supply_v", truth.supply_volts},
          {"suction", truth.suction}, {"bytes_lost", truth.bytes_lost}};
}

std::string truth_line(const sim::Truth& truth, const RobotModel& model) {
  std::string line;
  for (std::size_t i = 0; i < truth.joints.size(); ++i) {
    const sim::JointTruth& joint = truth.joints[i];
    const bool leg = model.joints[i].slides();
    const double factor = shown_value(1, model.joints[i]);
    const int digits = leg ? 4 : 3;
    line += fmt::format("{}{} {:.{}f} {}", line.empty() ? "" : ", ", model.joints[i].name,
                        joint.q * factor + 0.0, digits, shown_unit(model.joints[i]));
    if (differ(joint, leg)) {
      line += fmt::format(" (believes {:.{}f})", joint.believed * factor + 0.0, digits);
    }
    if (joint.stalled) line += " STALLED";
    // Of the past, and nothing takes it back.
    if (joint.lost_steps) line += " (lost steps since power-up)";
    if (joint.at_end_stop) line += " AT ITS END";
  }
  line +=
      fmt::format("; supply {:.1f} V; {}", truth.supply_volts, truth.moving ? "moving" : "at rest");
  if (truth.deaf && !truth.moving) line += ", and deaf: it waits for a motion of its own to end";
  if (truth.suction) line += "; suction on";
  if (truth.bytes_lost > 0) line += fmt::format("; {} bytes lost", truth.bytes_lost);
  return line;
}

}  // namespace sinew::cli
