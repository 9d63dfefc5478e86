#pragma once

#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

/// What the command line asked for; texts as they were typed.
struct TorqueRequest {
  std::string robot;
  std::optional<std::string> payload_kg;
  std::optional<std::string> program;  ///< a .sinew file
  std::optional<std::string> axis;     ///< the one to look at closely; the weakest where absent
};

/// `sinew torque`: what each joint needs over the workspace and over a program against what its
/// motors give, and which gear ratio would do. docs/torque.md.
Outcome torque(const TorqueRequest& request);

void add_torque(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
