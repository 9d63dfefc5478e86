#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sinew/cli/outcome.h"

namespace sinew::cli {

struct DeviceRequest {
  std::string robot;
  std::string action;  ///< hexapod: status, wake, kill, jog; robot-arm-2: release
  std::string port;
  std::optional<std::string> wire;
  std::optional<std::string> profile;
  std::optional<std::string> journal;   ///< name of the position journal, as of run
  std::optional<std::string> settings;  ///< what commissioning found, as of run
  std::optional<std::int64_t> leg;      ///< jog: from 1
  std::optional<std::int64_t> steps;    ///< jog: positive is longer
  double time_scale = 1;
};

/// `sinew device`: what only one kind of device knows, asked for by a person and by nothing else.
/// The hexapod's controller can be waked and killed, and the twelve status bytes of each motor
/// read. Its legs can be jogged while their position is unknown, and the boards of robot-arm-2
/// released from a latched emergency stop. All through the controller, recorded in the journal.
Outcome run_device_action(const DeviceRequest& request);

}  // namespace sinew::cli
