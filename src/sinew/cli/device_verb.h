#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sinew/cli/outcome.h"

namespace sinew::cli {

struct DeviceRequest {
  std::string robot;
  std::string action;  ///< status, wake, kill, jog
  std::string port;
  std::optional<std::int64_t> leg;    ///< jog: from 1
  std::optional<std::int64_t> steps;  ///< jog: positive is longer
  double time_scale = 1;
};

/// `sinew device`: what only one kind of device knows, asked for by a person and by nothing else.
/// The hexapod's controller can be waked and killed, its legs jogged while nobody knows where they
/// are, and the twelve status bytes of each motor read.
Outcome run_device_action(const DeviceRequest& request);

}  // namespace sinew::cli
