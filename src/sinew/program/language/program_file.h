#pragma once

#include <array>
#include <cstddef>
#include <expected>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/core/instant.h"
#include "sinew/driver/driver.h"
#include "sinew/model/taught_points.h"
#include "sinew/program/language/table_top.h"
#include "sinew/vision/color_names.h"

/// Programs in Sinew's own format, `NAME.sinew`: one step a row, named arguments with units, for
/// every robot. docs/programs.md has the grammar.
///
///   joint base=30deg J2=-20deg speed=50%   | joints that are not named stay where they are
///   joint d.base=5deg | line dz=-10mm      | from where it is; with frame=tool along its own axes
///   joint to=NAME | line to=NAME dz=50mm   | a taught point, and beside it
///   move x=200mm z=150mm blend=5deg        | the tool goes there, the joints straight
///   line y=-50mm speed=80mm/s blend=20mm   | the tool goes there along a straight line
///   arc via=200mm,0mm,180mm y=50mm         | along the circle through `via`
///   spline 200mm,0mm,150mm 210mm,20mm,150mm accel=500mm/s2
///   joint base=30deg time=2s               | the whole motion takes so long, as any row's may
///   home                                   | find the zeros, on machines with end stops
///   jaws 20mm | jaws 20mm holds=25mm | gripper 40deg|off
///   suction on|release|off | nozzle 45deg time=1s
///   wait 0.5s | wait settled | wait until base>20deg for 5s
///   velocity base=50% shoulder=20% | acceleration base=50%   | limits of the motions behind it
///   loop 3 ... end | if z<100mm ... else ... end | call NAME
///   look | look CAMERA | pick | pick any | pick color=red | pick at=180mm,-20mm,25mm
///                                          | cubes that a camera sees; back where the row began
///   place NAME | place x=200mm z=30mm      | releases there from above, NAME being a taught point
///   or
///                                          | a basket of the cell; back where the row began
///   if seen color=blue ... end | repeat while seen ... end
namespace sinew::program {

/// Shares of the joints' limits in the robot's file, one a joint: above 0, and up to its
/// limit_reach().
struct JointShares {
  JointVector velocity;
  JointVector acceleration;
  friend bool operator==(const JointShares&, const JointShares&) = default;
};

/// How a motion is made: what a row says behind its target.
struct MotionOptions {
  double joint_share = 1;  ///< of the joints' velocity limits, (0, 1]
  double tool_speed = std::numeric_limits<double>::infinity();         ///< m/s
  double tool_acceleration = std::numeric_limits<double>::infinity();  ///< m/s^2
  double blend_radius = 0;  ///< m; with 0 for both the robot stops at the row's end
  double blend_joints = 0;  ///< rad
  double time = 0;          ///< s, of the whole motion; 0: as quick as the rest allows
  /// What `velocity` and `acceleration` rows before it say; null: the limits themselves.
  std::shared_ptr<const JointShares> limits{};

  bool blends() const { return blend_radius > 0 || blend_joints > 0; }
};

/// Move some joints; those that are not `given` stay.
struct JointStep {
  JointVector q;           ///< rad or m; one per joint
  std::uint8_t given = 0;  ///< bit i: joint i
  MotionOptions how;
  std::uint8_t relative = 0;  ///< bit i: q[i] is counted from where joint i is
};

/// What a row adds to the place that it names, or to where the tool is.
struct GoalOffset {
  Vec3 dp;               ///< m
  Vec3 turn;             ///< rad, about the frame's axes x, then y, then z, which stay
  double pitch = 0;      ///< rad, of arms with five joints
  double roll = 0;       ///< rad
  bool in_tool = false;  ///< dp and turn along the tool's axes as they are there, else the base's

  bool turns() const { return !(turn == Vec3{}) || pitch != 0 || roll != 0; }
  friend bool operator==(const GoalOffset&, const GoalOffset&) = default;
};

/// Where a row sends the tool; what it does not name stays as it is.
struct ToolGoal {
  std::array<std::optional<double>, 3> p_BT;  ///< m
  std::optional<Rotation> R_BT;
  std::optional<double> pitch;  ///< rad, of arms with five joints
  std::optional<double> roll;   ///< rad
  std::optional<GoalOffset> offset;
  bool of_joints = false;  ///< a place taught as joints: where they take the tips of open jaws
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
struct HomeStep {
  double time = 0;  ///< s, of machines without end stops; 0: as quick as it can
};

/// What an `if` or a `wait until` asks: one measured number against one that the row says.
struct Condition {
  enum class Subject : std::uint8_t { kJoint, kToolX, kToolY, kToolZ, kSupply, kJaws, kSeen };
  enum class Test : std::uint8_t { kAbove, kBelow };  ///< >= and <= mean the same as > and <
  Subject subject = Subject::kJoint;
  Test test = Test::kAbove;
  std::size_t joint = 0;                     ///< of kJoint
  double value = 0;                          ///< rad, m or V
  std::optional<vision::ColorName> color{};  ///< of kSeen: a cube that can be picked; any without

  bool of_position() const { return subject < Subject::kSupply; }
  bool holds(double measured) const {
    return test == Test::kAbove ? measured > value : measured < value;
  }
  friend bool operator==(const Condition&, const Condition&) = default;
};

struct WaitStep {
  enum class For : std::uint8_t { kTime, kCondition, kSettled };
  Duration duration{};  ///< of kTime; of the others the longest, behind which the run fails
  For what = For::kTime;
  Condition until{};
};
struct ToolStep {
  ToolAction action;
};
/// So many rounds at most has a `repeat while seen`.
inline constexpr int kSeenRoundsMax = 40;

struct LoopStep {
  int rounds = 1;
  std::size_t end = 0;                 ///< place of its EndStep
  std::optional<Condition> goes_on{};  ///< asked before each round
};
struct IfStep {
  Condition condition;
  std::size_t otherwise = 0;  ///< place of its ElseStep, or of its EndStep where it has none
  std::size_t end = 0;        ///< place of its EndStep
};
struct ElseStep {
  std::size_t begin = 0;  ///< place of its IfStep
};
struct EndStep {
  std::size_t loop = 0;  ///< place of its LoopStep or IfStep
};

/// A new picture is looked at.
struct LookStep {
  std::string camera{};  ///< empty: the first; rows behind it look with the same
};
/// A cube that is seen and that the tool can take, and back to where the row began.
struct PickCubeStep {
  std::optional<vision::ColorName> color;  ///< any without
  std::optional<Vec3> p_BT{};              ///< m, about the middle of its top; any without
  MotionOptions how{};
};
/// A basket of the cell: where it stands is looked up when the row is planned.
struct BasketGoal {
  std::string name;
  MotionOptions how{};
};
/// What is held is let go there, from above, and back to where the row began.
struct PlaceCubeStep {
  std::variant<JointStep, ToolMoveStep, BasketGoal> there;  ///< where the tool is then
};

struct Step {
  int line = 0;  ///< of the file, from 1
  std::variant<JointStep, ToolMoveStep, SplineStep, HomeStep, WaitStep, ToolStep, LoopStep, EndStep,
               IfStep, ElseStep, LookStep, PickCubeStep, PlaceCubeStep>
      what;
  int file = 0;  ///< of Program::files
};

/// How a row moves the robot; nothing where it does not.
const MotionOptions* motion_of(const Step& step);

/// A row of the program's own file that calls another program.
struct CallRow {
  int line = 0;
  std::size_t first = 0;  ///< place of the first step that it stands for
};

/// What goes otherwise here than where the program's text comes from.
struct ProgramNote {
  int line = 0;
  std::string sentence;
};

struct Program {
  std::vector<Step> steps;         ///< those of called programs where they are called
  std::vector<std::string> files;  ///< the program's own name, then of those that it calls
  std::vector<CallRow> calls{};
  std::vector<ProgramNote> notes{};
  std::shared_ptr<const TableTop> table{};  ///< of its cell; null: read without one
};

/// Whether a row of it picks, places or looks.
bool handles_cubes(const Program& program);
/// Whether a row of it places into a basket.
bool uses_baskets(const Program& program);

/// A called program's text and how complaints shall name it.
struct CalledFile {
  std::string name;
  std::string text;
};

/// What lies beside a program in its folder.
struct Surroundings {
  const TaughtPoints* points = nullptr;     ///< null: no such file
  std::shared_ptr<const TableTop> table{};  ///< of the cell; null: it is not known
  /// Reads the program of this name (is_point_name() holds). @error  a sentence
  std::function<std::expected<CalledFile, std::string>(std::string_view name)> load;
};

/// Rows of a program with all that it calls; more is a slip or an attack.
inline constexpr std::size_t kStepsMax = 100'000;

/// Reads a program. All complaints come at once, up to some hundred; nothing else is checked than
/// what the text alone can tell: names, units, nesting. Limits are the plan's.
std::expected<Program, std::vector<Complaint>> parse(std::string_view text,
                                                     std::string_view file_name,
                                                     const RobotModel& robot,
                                                     const Surroundings& around = {});

}  // namespace sinew::program
