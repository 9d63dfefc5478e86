#pragma once

#include <expected>
#include <memory>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "sinew/program/language/program_file.h"
#include "sinew/program/plans/home_return.h"
#include "sinew/program/plans/row_planner.h"

namespace sinew::program {

/// What is known of the joints when a plan begins: nothing where a machine has to be homed, or
/// moves slowly for a first time.
using Start = std::optional<JointVector>;

/// What is known of a machine before a program begins.
struct Standing {
  Standing() = default;
  Standing(std::nullopt_t) {}
  Standing(Start joints, const ToolState& gripper = {}) : q(std::move(joints)), tool(gripper) {}
  Standing(const JointVector& joints) : q(joints) {}

  Start q;                         ///< where its joints are
  ToolState tool;                  ///< of a gripper
  std::optional<double> at_cup{};  ///< m, edge of the cube that a suction cup holds; if known
};

/// A motion from rest to rest: one row, or several that blend into each other. Where the machine
/// turns out to stand somewhere else than planned (after homing, behind another branch), it is
/// planned again. Behind an `if` it may begin at several places; all of them were planned from.
struct MoveOrder {
  std::vector<Step> rows;
  Start q_start;
  JointVector q;        ///< where it ends
  ToolState tool;       ///< what the gripper is like meanwhile
  double duration = 0;  ///< s, predicted, until the driver has told that it is done
  CornerStopReason stop = CornerStopReason::kNone;  ///< at its end
  double stop_saves = 0;                            ///< s, of kCostsTime
  bool first_move = false;  ///< nobody knows where it begins: slow, in one piece
  /// More than one where branches end at different places; then q_start .. stop are of the first
  /// one, and `duration` of the slowest.
  std::size_t starts = 1;
};
struct HomeOrder {
  double duration_max = 0;  ///< s, an upper bound, the way home included; 0 where nobody knows one
  /// Behind the search, from where homing is expected to leave the joints; null where nobody knows.
  std::shared_ptr<const HomeReturn> back;
};
/// What is known of homing before it runs.
struct Homing {
  FixedVector<double, kMaxJoints> times;  ///< s, of each joint's search, at most; may be empty
  Start rest;                             ///< where the joints rest behind it
};
struct WaitOrder {
  Duration duration{};  ///< of the other kinds than kTime the longest
  WaitStep::For what = WaitStep::For::kTime;
  Condition until{};
};
/// Which rows follow is decided when the run comes here.
struct BranchOrder {
  Condition condition;
  std::size_t otherwise = 0;  ///< the order that is next where the condition does not hold
};
/// The end of a branch that has another one behind it.
struct JumpOrder {
  std::size_t to = 0;  ///< the order that is next
};
struct ToolOrder {
  ToolAction action;
  double duration = 0;  ///< s, predicted
};

struct LookOrder {
  std::string camera{};  ///< empty: the first
  double duration = 0;   ///< s, about
};
/// Which cube, and how, is decided when the run comes here; it ends where it begins.
struct PickOrder {
  PickCubeStep row;
  double duration = 0;  ///< s, about
};
/// It ends where it begins.
struct PlaceOrder {
  PlaceCubeStep row;
  double duration = 0;  ///< s, predicted
};

struct Order {
  int line = 0;
  int last_line = 0;  ///< the same, but where rows blend into each other
  int round = 1;      ///< of its innermost loop
  int rounds = 1;
  std::variant<MoveOrder, HomeOrder, WaitOrder, ToolOrder, BranchOrder, JumpOrder, LookOrder,
               PickOrder, PlaceOrder>
      what;
  int file = 0;  ///< of Program::files
  /// Whether it counts in what is predicted: a round for which no cube is seen now does not.
  bool expected = true;
};

/// More would be days of motion; a file of this many repeats is a slip or an attack.
inline constexpr std::size_t kOrdersMax = 100'000;

/// So many places at most from which rows behind `if`s are planned.
inline constexpr std::size_t kPlacesMax = 64;

/// Both branches of an `if` stand in it, one behind the other; jumps lead only forward.
struct Plan {
  std::vector<Order> orders;
  double duration = 0;      ///< s of motion, waiting and tools, predicted; homing not counted
  double homing_max = 0;    ///< s, an upper bound of all homing
  double duration_min = 0;  ///< s; less than `duration` where branches or waits differ
  /// What holds its motions back; of each order from the first place where it may begin.
  planning::LimitTimes limits{};
};

/// Seconds for a first move from nobody knows where: each joint's whole range at a tenth of its
/// top speed, 2 s at least.
double first_move_duration(const RobotModel& robot);

/// Unrolls a program and plans every move. A `home` ends at `home_deg` of the robot's file: where
/// the search leaves the joints is expected before it ran, and the way home from there planned
/// again when the machine has told.
///
/// Both branches of an `if` are planned, each from where the `if` stands, whether its condition
/// holds there or not: what will be measured nobody knows yet. What follows is planned from
/// wherever a branch may end.
///
/// @param look    is shown each motion, and may refuse it
/// @param homing  of this robot's joints, which are searched one after the other
///
/// @error kJointLimit (index), kToolNotFitted, kJawWidth, kToolAngle, kNoEndStops, kPositionUnknown
/// (a move of some joints, while the others are
///        nowhere known, or of the tool; a condition on it), kTooManyPlaces, kProgramTooLong, and
///        those of RowPlanner::plan; nothing of the program may run then.
std::expected<Plan, Refusal> make_plan(const Program& program, const RobotModel& robot,
                                       const Standing& start, const Homing& homing = {},
                                       const WayLook& look = {});

/// Whether a motion's start is known, inside of the limits or outside: from there rows that are
/// straight in joints lead back in. Where nobody knows it, or it has no pose (a platform's legs
/// that are beyond what they can be together), only a joint row goes on, slowly and in one piece.
bool plannable(const Start& q, const RobotModel& robot);
/// Where an arm goes that hangs outside its limits, limp on its table, and whose way by the model
/// hits something, so that it is refused: it really is there, so a joint row leads out, slowly, in
/// one piece. Nothing where another refusal, or a start inside the limits, has to stand.
std::optional<JointVector> slow_way_back(const Step& row, const JointVector& q, const Refusal& why,
                                         const RobotModel& robot);
/// Where that one slow piece goes.
/// @error kPositionUnknown (a joint that the row does not name, or no joint row), kJointLimit,
///        kLegLength, or those of WireTarget
std::expected<JointVector, Refusal> first_target(const Step& row, const Start& q,
                                                 const RobotModel& robot);

}  // namespace sinew::program
