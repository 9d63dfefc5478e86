#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sinew/cli/cells/local_cell.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

struct DeviceRequest {
  RobotOptions robot;  ///< with a port
  std::string action;  ///< hexapod: status, wake, kill, jog; robot-arm-2: release, test
  std::optional<std::int64_t> leg;    ///< jog: from 1
  std::optional<std::int64_t> steps;  ///< jog: positive is longer
};

/// `sinew device`: what only one kind of device knows, asked for by a person and by nothing else.
/// The hexapod's controller can be waked and killed, and the twelve status bytes of each motor
/// read. Its legs can be jogged while their position is unknown, and the boards of robot-arm-2
/// released from a latched emergency stop. All through the controller, recorded in the journal.
Outcome run_device_action(const DeviceRequest& request);

void add_device(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
