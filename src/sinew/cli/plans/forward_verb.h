#pragma once

#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

/// What the user wrote after `sinew fk`; numbers still as text.
struct ForwardRequest {
  std::string robot;
  std::optional<std::string> joints_deg;
  std::optional<std::string> legs_mm;
  std::optional<std::string> near_pose_mm_deg;
  std::optional<std::string> gripper_mm;
  bool frames = false;
};

/// `sinew fk`: where the tool (or platform) is at given joints (or legs).
Outcome forward(const ForwardRequest& request);

void add_forward(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
