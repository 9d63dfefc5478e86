#pragma once

#include <expected>
#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/model/robot_model.h"
#include "sinew/program/procedures/procedures.h"

namespace sinew::cli {

/// What commissioning found, on top of the robot's file.
struct UsedSettings {
  std::string file;  ///< that counts; empty where none does
  std::string note;  ///< a sentence on what does not count; empty where there is nothing to say
};

/// @param settings  a file or "none"; where left out that of the state folder, if it is there
/// @param real      the robot is a real one; else only a file that was named counts
/// @error   a file that was named, or is there, cannot be used
std::expected<UsedSettings, Outcome> use_commissioning(RobotModel& robot,
                                                       const std::optional<std::string>& settings,
                                                       bool real);

/// Says which file counts, and what does not.
void tell_settings(const UsedSettings& settings, Outcome& outcome);

/// What a file of commissioning found, and a sentence on what of it does not count.
struct FileSettings {
  program::FoundSettings settings;
  std::string note;
};
/// @error  it cannot be read, or its list was never finished; a sentence
std::expected<FileSettings, std::string> read_settings_file(const RobotModel& robot,
                                                            const std::string& path);
/// The same, used. @error  it cannot be used, or its list was never finished; a sentence
std::expected<UsedSettings, std::string> use_settings_file(RobotModel& robot,
                                                           const std::string& path);

}  // namespace sinew::cli
