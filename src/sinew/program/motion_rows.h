#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/planning/tool_space.h"
#include "sinew/program/program_file.h"
#include "sinew/program/row_reader.h"

namespace sinew::program {

/// The rows of a program that move the robot: joint, move, line, arc, spline.
class MotionRows {
 public:
  /// @param robot, row  outlive this.
  MotionRows(const RobotModel& robot, RowReader& row);

  static bool known(std::string_view name);
  /// The row at hand as a step; nothing where something was complained about.
  std::optional<Step> read();

 private:
  struct Argument {
    Word word;
    std::string_view name;
    std::string_view value;
  };
  /// What may stand once in a row, and what did.
  struct Given {
    bool speed = false;
    bool tool_speed = false;
    bool acceleration = false;
    bool blend = false;
  };

  /// rx, ry, rz as far as they were given.
  using Rotations = std::array<std::optional<double>, 3>;

  std::optional<Step> joint_row();
  std::optional<Step> tool_row(ToolMoveStep::Way way);
  std::optional<Step> spline_row();
  std::optional<Argument> argument(const Word& word, std::string_view example);
  /// speed=, accel= and blend=; nothing where it is another one.
  std::optional<bool> option(const Argument& argument, MotionOptions& how, Given& given);
  bool take_speed(const Argument& argument, MotionOptions& how, Given& given);
  bool take_blend(const Argument& argument, MotionOptions& how);
  bool take_joint(const Argument& argument, JointStep& step);
  bool take_goal(const Argument& argument, ToolMoveStep& step, Rotations& rotations);
  bool goal_is_whole(const ToolMoveStep& step, const Rotations& rotations, bool via);
  bool take_angle(const Argument& argument, std::optional<double>& angle);
  void unknown(const Argument& argument, const std::vector<std::string>& names,
               std::string_view what);
  std::vector<std::string> goal_names(bool arc) const;

  const RobotModel& robot_;
  RowReader& row_;
  planning::TaskSpace task_;
  std::vector<std::string> names_;
};

}  // namespace sinew::program
