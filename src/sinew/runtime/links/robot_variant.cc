#include "sinew/runtime/links/robot_variant.h"

#include <algorithm>

#include "sinew/core/spelling.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"

namespace sinew::runtime {
namespace {

using Names = std::vector<std::string>;

std::string list_of(const Names& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

std::expected<void, std::string> check(const char* option, const std::optional<std::string>& name,
                                       const Names& known, const RobotModel& robot) {
  if (!name || std::ranges::find(known, *name) != known.end()) return {};
  const std::string what = std::string(option) + ": '" + printable(*name) + "' ";
  if (known.empty()) return std::unexpected(what + "is unknown: " + robot.id + " has but one");
  return std::unexpected(what + "is none of " + list_of(known));
}

std::expected<void, std::string> leave_out(RobotModel& robot, std::span<const std::string> names) {
  AxisBoards* boards = robot.device.settings->own_boards();
  if (boards == nullptr) {
    return std::unexpected("--without: " + robot.id +
                           " has one controller for all joints; no joint can be left out");
  }
  for (const std::string& name : names) {
    const auto joint = joint_named(robot, name);
    if (!joint) {
      Names known;
      for (const Joint& one : robot.joints) known.push_back(one.name);
      return std::unexpected("--without: '" + printable(name) + "' is no joint of " + robot.id +
                             "; its joints: " + list_of(known) + ", or J1 to J" +
                             std::to_string(known.size()));
    }
    (*boards)[*joint].homing_place = kLeftOut;
  }
  const bool none = std::ranges::all_of(
      *boards, [](const AxisBoard& board) { return board.homing_place == kLeftOut; });
  if (none) return std::unexpected("--without: all joints are left out; at least one must stay");
  return {};
}

}  // namespace

std::expected<RobotModel, std::string> variant_of(const RobotModel& robot,
                                                  const std::optional<std::string>& profile,
                                                  const std::optional<std::string>& wire,
                                                  std::span<const std::string> without) {
  if (const auto fine = check("--wire", wire, robot.device.settings->wires(), robot); !fine) {
    return std::unexpected(fine.error());
  }
  RobotModel variant = robot;
  Device& device = variant.device;
  if (wire) device.settings->use_wire(*wire, device);
  if (const auto fine = check("--profile", profile, device.settings->profiles(), variant); !fine) {
    return std::unexpected(fine.error());
  }
  if (profile) device.settings->use_profile(*profile, device);
  if (!without.empty()) {
    if (const auto fine = leave_out(variant, without); !fine) return std::unexpected(fine.error());
  }
  return variant;
}

}  // namespace sinew::runtime
