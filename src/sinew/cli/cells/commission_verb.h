#pragma once

#include <optional>
#include <string>

#include "sinew/cli/cells/local_cell.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

/// A procedure on a robot that nobody else steers: commissioning, homing, recovery.
struct CommissionRequest {
  RobotOptions robot;
  std::string procedure = "commission";
  std::optional<std::string> answers;  ///< a file; else somebody types
  std::optional<std::string> save;     ///< where its results go; the state folder where left out
  bool anew = false;                   ///< without what was answered before
  bool json = false;
};

Outcome commission(CommissionRequest request);

void add_commission(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
