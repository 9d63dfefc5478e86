#pragma once

#include <array>
#include <cstddef>
#include <expected>
#include <limits>
#include <memory>
#include <optional>
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
///   move x=200mm z=150mm blend=5deg        | the tool goes there, the joints straight
///   line y=-50mm speed=80mm/s blend=20mm   | the tool goes there along a straight line
///   arc via=200mm,0mm,180mm y=50mm         | along the circle through `via`
///   spline 200mm,0mm,150mm 210mm,20mm,150mm accel=500mm/s2
///   home                                   | find the zeros, on machines with end stops
///   jaws 20mm | gripper 40deg|off | suction on|release|off | nozzle 45deg time=1s
///   wait 0.5s
///   loop 3 ... end
namespace sinew::program {

/// How a motion is made: what a row says behind its target.
struct MotionOptions {
  double joint_share = 1;  ///< of the joints' velocity limits, (0, 1]
  double tool_speed = std::numeric_limits<double>::infinity();         ///< m/s
  double tool_acceleration = std::numeric_limits<double>::infinity();  ///< m/s^2
  double blend_radius = 0;  ///< m; with 0 for both the robot stops at the row's end
  double blend_joints = 0;  ///< rad

  bool blends() const { return blend_radius > 0 || blend_joints > 0; }
};

/// Move some joints; those that are not `given` stay.
struct JointStep {
  JointVector q;           ///< rad or m; one per joint
  std::uint8_t given = 0;  ///< bit i: joint i
  MotionOptions how;
};

/// Where a row sends the tool; what it does not name stays as it is.
struct ToolGoal {
  std::array<std::optional<double>, 3> p_BT;  ///< m
  std::optional<Rotation> R_BT;
  std::optional<double> pitch;  ///< rad, of arms with five joints
  std::optional<double> roll;   ///< rad
};

/// The tool goes somewhere.
struct ToolMoveStep {
  enum class Way : std::uint8_t { kJoints, kLine, kArc } way = Way::kJoints;
  ToolGoal to;
  Vec3 p_via_BT;  ///< m, of an arc
  MotionOptions how;
};
/// The tool goes through points with the attitude that it has.
struct SplineStep {
  std::shared_ptr<const std::vector<Vec3>> through;  ///< m, in base B; at least one
  MotionOptions how;
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
  std::variant<JointStep, ToolMoveStep, SplineStep, HomeStep, WaitStep, ToolStep, LoopStep, EndStep>
      what;
};

/// How a row moves the robot; nothing where it does not.
const MotionOptions* motion_of(const Step& step);

struct Program {
  std::vector<Step> steps;
};

/// Reads a program. All complaints come at once, up to some hundred; nothing else is checked than
/// what the text alone can tell: names, units, nesting. Limits are the plan's.
std::expected<Program, std::vector<Complaint>> parse(std::string_view text,
                                                     std::string_view file_name,
                                                     const RobotModel& robot);

}  // namespace sinew::program
