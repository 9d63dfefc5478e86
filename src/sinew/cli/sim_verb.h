#pragma once

#include <optional>
#include <string>

#include "sinew/cli/outcome.h"

namespace sinew::cli {

struct SimRequest {
  std::string robot;
  std::optional<std::string> link;
  std::optional<std::string> log;
  double time_scale = 1;
  bool json = false;
};

/// `sinew sim`: the robot's device on a pseudo-terminal, until Ctrl-C. The first line on stdout is
/// the port's path; with --json {"port": ..}, and {"truth": ..} on the last, a document a line.
Outcome simulate(const SimRequest& request);

}  // namespace sinew::cli
