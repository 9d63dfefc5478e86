#pragma once

#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

/// What the user wrote after `sinew axis`; numbers still as text.
struct AxisRequest {
  std::string robot;
  std::optional<std::string> axis;        ///< J1.. or its name; all where left out
  std::optional<std::string> step;        ///< "10deg"
  std::optional<std::string> track;       ///< "40deg": length of the move
  std::optional<std::string> joints_deg;  ///< where the arm stands
  std::optional<std::string> payload;     ///< "0.5", "0.5kg"
  std::optional<std::string> plot;        ///< SVG file
};

/// `sinew axis`: how the control loop of each axis answers a jump of its reference, and how closely
/// it follows a move, with the arm's weight and inertia, in simulation.
Outcome try_axis(const AxisRequest& request);

void add_axis(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
