#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/planning/paths/tool_space.h"
#include "sinew/program/language/program_file.h"
#include "sinew/program/language/row_reader.h"

namespace sinew::program {

/// The rows of a program that move the robot: joint, move, line, arc, spline.
class MotionRows {
 public:
  /// @param robot, row, around  outlive this
  MotionRows(const RobotModel& robot, RowReader& row, const Surroundings& around);

  static bool known(std::string_view name);
  /// The row at hand as a step; nothing where something was complained about.
  std::optional<Step> read();
  /// A `place` row's target, as that of `move`; a word alone is the name of a taught point or a
  /// basket.
  std::optional<std::variant<JointStep, ToolMoveStep, BasketGoal>> read_place();
  /// A `velocity` or `acceleration` row: the joints' limits of the motions behind it in this file.
  void take_limits();
  /// A word `time=2s`, s; complains where it is none.
  std::optional<double> motion_time(const Word& word);

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
    bool time = false;
  };

  /// rx, ry, rz as far as they were given.
  using Rotations = std::array<std::optional<double>, 3>;
  /// What a joint row collects besides its step: a difference a joint.
  using Differences = std::array<std::optional<double>, kMaxJoints>;
  /// What a row of the tool collects besides its step.
  struct Collected {
    Rotations rotations;
    const TaughtPoint* point = nullptr;
    std::array<std::optional<double>, 8> offset;  ///< in the order of kOffsets
    bool frame = false;                           ///< was named
    bool in_tool = false;
    bool via = false;
  };

  /// The name of a basket that a `place` row may mean; nothing where it means another place.
  std::optional<std::string_view> basket_word() const;
  std::optional<BasketGoal> basket_row(std::string_view name);
  bool has_point(std::string_view name) const;
  bool knows_basket(const Word& word, std::string_view name);
  std::optional<Step> joint_row();
  std::optional<Step> tool_row(ToolMoveStep::Way way);
  std::optional<Step> spline_row();
  std::optional<Argument> argument(const Word& word, std::string_view example);
  /// speed=, accel=, blend= and time=; nothing where it is another one.
  std::optional<bool> option(const Argument& argument, MotionOptions& how, Given& given);
  bool take_speed(const Argument& argument, MotionOptions& how, Given& given);
  bool take_blend(const Argument& argument, MotionOptions& how);
  bool takes_share(const Word& word, std::size_t joint, bool velocity, double share);
  bool take_joint(const Argument& argument, JointStep& step, Differences& differences);
  bool take_joint_point(const Argument& argument, JointStep& step);
  bool take_goal(const Argument& argument, ToolMoveStep& step, Collected& collected);
  bool take_via(const Argument& argument, ToolMoveStep& step, Collected& collected);
  bool take_offset(const Argument& argument, std::size_t which, Collected& collected);
  bool take_frame(const Argument& argument, Collected& collected);
  bool goal_is_whole(const ToolMoveStep& step, const Collected& collected);
  std::optional<Step> finished(ToolMoveStep step, const Collected& collected);
  bool take_angle(const Argument& argument, std::optional<double>& angle);
  bool take_length(const Argument& argument, std::optional<double>& length);
  /// The taught point of that name, for this robot; complains where there is none.
  const TaughtPoint* named_point(const Word& word, std::string_view name);
  /// Its place for the tool; complains where its joints give none.
  std::optional<ToolGoal> tool_goal(const Word& word, const TaughtPoint& point);
  /// "X,Y,Z" or a taught point.
  std::optional<Vec3> position(const Word& word, std::string_view text);
  void unknown(const Argument& argument, const std::vector<std::string>& names,
               std::string_view what);
  std::vector<std::string> goal_names(bool arc) const;

  const RobotModel& robot_;
  RowReader& row_;
  const TaughtPoints* points_;
  const TableTop* table_;  ///< null: not known
  planning::ToolSpace space_;
  planning::TaskSpace task_;
  std::vector<std::string> names_;
  std::shared_ptr<const JointShares> limits_;  ///< null: those of the robot's file
};

}  // namespace sinew::program
