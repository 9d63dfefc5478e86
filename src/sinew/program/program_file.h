#pragma once

#include <cstddef>
#include <expected>
#include <string_view>
#include <variant>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/core/instant.h"
#include "sinew/driver/driver.h"
#include "sinew/model/robot_model.h"

/// Programs in Sinew's own format, `NAME.sinew`: one step a row, named arguments with units, for
/// every robot. docs/programs.md has the grammar.
///
///   joint base=30deg J2=-20deg speed=50%   | joints that are not named stay where they are
///   home                                   | find the zeros, on machines with end stops
///   jaws 20mm | gripper 40deg|off | suction on|release|off | nozzle 45deg time=1s
///   wait 0.5s
///   loop 3 ... end
namespace sinew::program {

/// Move some joints; those that are not `given` stay.
struct JointStep {
  JointVector q;           ///< rad or m; one per joint
  std::uint8_t given = 0;  ///< bit i: joint i
  double speed = 1;        ///< share of the joints' limits
};
struct HomeStep {};
struct WaitStep {
  Duration duration{};
};
struct ToolStep {
  ToolAction action;
};
struct LoopStep {
  int rounds = 1;
  std::size_t end = 0;  ///< place of its EndStep
};
struct EndStep {
  std::size_t loop = 0;  ///< place of its LoopStep
};

struct Step {
  int line = 0;  ///< of the file, from 1
  std::variant<JointStep, HomeStep, WaitStep, ToolStep, LoopStep, EndStep> what;
};

struct Program {
  std::vector<Step> steps;
};

/// Reads a program. All complaints come at once, up to some hundred; nothing else is checked than
/// what the text alone can tell: names, units, nesting. Limits are the plan's.
std::expected<Program, std::vector<Complaint>> parse(std::string_view text,
                                                     std::string_view file_name,
                                                     const RobotModel& robot);

}  // namespace sinew::program
