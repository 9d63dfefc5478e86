#pragma once

#include <expected>
#include <optional>
#include <span>
#include <string>

#include "sinew/model/robot_model.h"

namespace sinew::runtime {

/// Turns the model's device into the variant that somebody asked for: settings that belong to a
/// profile or wire follow (units of servos, clock, motion kind). What only a simulated device
/// knows stays in the profile's name.
/// @param without  joints that are left out, by name or number as J3: model/left_out.h
/// @error  a sentence: an unknown name, with those that are known; or joints that cannot be left
/// out
std::expected<RobotModel, std::string> variant_of(const RobotModel& robot,
                                                  const std::optional<std::string>& profile,
                                                  const std::optional<std::string>& wire,
                                                  std::span<const std::string> without = {});

}  // namespace sinew::runtime
