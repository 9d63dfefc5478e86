#pragma once

#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

/// What the user wrote after `sinew ik`; numbers still as text.
struct InverseRequest {
  std::string robot;
  std::optional<std::string> pose_mm_deg;
  std::optional<std::string> point_mm;
  std::optional<std::string> pitch_deg;
  std::optional<std::string> approach;
  std::optional<std::string> gripper_mm;
  std::optional<std::string> near_joints_deg;
  std::optional<std::string> near_pose_mm_deg;
};

/// `sinew ik`: the joints (or legs) that bring the tool (or platform) to a pose or point, all
/// branches with their verdicts, or a refusal with its numbers.
Outcome inverse(const InverseRequest& request);

void add_inverse(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
