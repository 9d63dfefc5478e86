#pragma once

#include <expected>
#include <map>
#include <string>

#include "sinew/io/file.h"
#include "sinew/model/robot_model.h"
#include "sinew/program/procedures/procedures.h"

namespace sinew::runtime {

/// What commissioning left of a robot: answers, to go on with, and settings, to run with. Beside
/// the robot's file, which nobody changes.
struct CommissioningFile {
  using Answers = std::map<std::string, program::StepResult>;  ///< by the step's id

  bool finished = false;  ///< a list has come to its end; only then the settings count
  Answers answers;        ///< of that one
  program::FoundSettings settings;
  /// Of one that was broken off, to go on with; what was finished before stays as it is.
  Answers under_way;
};

/// $XDG_STATE_HOME/sinew/commissioning, or where the home has it.
io::IoResult<std::string> commissioning_folder();
/// NAME.json there.
io::IoResult<std::string> commissioning_path(const std::string& name);
/// @error  unreadable, no settings file, or of another robot; a sentence
std::expected<CommissioningFile, std::string> read_commissioning(const std::string& path,
                                                                 const RobotModel& robot);
/// Whether results may be kept there, before anything moves: it makes the folder.
/// @error  a folder, no permission
io::IoResult<void> check_commissioning_place(const std::string& path);
/// What a procedure leaves in its robot's file: its answers, and what it found once it has come to
/// its end and that fits the robot.
struct CommissioningResults {
  CommissioningFile file;
  std::string misfit;  ///< why what was found does not fit; a sentence, empty where it does
};
/// @param before  what the file had
CommissioningResults results_of(const program::Procedure& procedure, CommissioningFile before);
/// @error  the folder or the file cannot be written
io::IoResult<void> write_commissioning(const std::string& path, const RobotModel& robot,
                                       const CommissioningFile& file);

}  // namespace sinew::runtime
