#pragma once

#include <expected>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sinew/cli/output/outcome.h"
#include "sinew/program/formats/recorded_way.h"

namespace sinew::cli {

/// The joints in a status of the API, or in a message of a record; nothing where one is not known.
/// @param joints  objects with position_rad or position_m, in the robot's order or by their names
std::optional<JointVector> known_joints(const Json& joints, const RobotModel& robot);

/// The way in a record NAME.mcap.
/// @error  it cannot be read, or is of another robot
std::expected<std::vector<program::WaySample>, Outcome> way_of_record(const std::string& file,
                                                                      const RobotModel& robot);

/// A way that has become a program.
struct TaughtProgram {
  std::string text;  ///< laid out; the notes stand in it as remarks
  /// What whoever runs it should know: places that had to be moved, a row that is refused.
  std::vector<std::string> notes{};
};

/// @error  nothing moved
std::expected<TaughtProgram, Outcome> program_of_way(std::span<const program::WaySample> way,
                                                     const RobotModel& robot);

}  // namespace sinew::cli
