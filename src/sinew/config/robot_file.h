#pragma once

#include <expected>
#include <string_view>
#include <vector>

#include "sinew/model/robot_model.h"
#include "sinew/toml/findings.h"

namespace sinew {

/// A robot and where each of its numbers comes from.
struct RobotFile {
  RobotModel model;
  std::vector<Provenance> sources;  ///< one per number, in the order they were read
};

/// Reads a robot's file strictly and keeps every promise that model/robot_model.h makes: limits in
/// order, maxima above zero, home inside the limits, axes of length 1, joint names unique, as many
/// joints as the geometry moves. The schema: robots/README.md.
///
/// Never throws, never crashes, whatever the bytes are.
///
/// @param toml       the file's text, UTF-8; lengths and angles in the unit that each key names
/// @param file_name  as complaints shall show it
/// @error            all complaints in the order of the file (a file that is not TOML has one:
/// where
///                   the parser gave up)
std::expected<RobotFile, std::vector<Complaint>> read_robot_file(std::string_view toml,
                                                                 std::string_view file_name);

/// The same without the sources.
std::expected<RobotModel, std::vector<Complaint>> read_robot(std::string_view toml,
                                                             std::string_view file_name);

}  // namespace sinew
