#pragma once

#include <expected>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sinew/model/robot_model.h"

namespace sinew::runtime {

/// The names of a simulated device's variants (`--profile`), its default first; none where it has
/// but one.
std::vector<std::string> profiles_of(const RobotModel& robot);
/// The names of the wires that a robot can be spoken to over (`--wire`), its file's first.
std::vector<std::string> wires_of(const RobotModel& robot);

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
