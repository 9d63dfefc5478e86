#pragma once

#include <expected>
#include <memory>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "sinew/program/home_return.h"
#include "sinew/program/program_file.h"
#include "sinew/program/row_planner.h"

namespace sinew::program {

/// What is known of the joints when a plan begins: nothing where a machine has to be homed, or
/// moves slowly for a first time.
using Start = std::optional<JointVector>;

/// A motion from rest to rest: one row, or several that blend into each other. Where the machine
/// turns out to stand somewhere else than planned (after homing), it is planned again.
struct MoveOrder {
  std::vector<Step> rows;
  Start q_start;
  JointVector q;        ///< where it ends
  double duration = 0;  ///< s, predicted, until the driver has told that it is done
  CornerStopReason stop = CornerStopReason::kNone;  ///< at its end
  double stop_saves = 0;                            ///< s, of kCostsTime
  bool first_move = false;  ///< nobody knows where it begins: slow, in one piece
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
  Duration duration{};
};
struct ToolOrder {
  ToolAction action;
  double duration = 0;  ///< s, predicted
};

struct Order {
  int line = 0;
  int last_line = 0;  ///< the same, but where rows blend into each other
  int round = 1;      ///< of its innermost loop
  int rounds = 1;
  std::variant<MoveOrder, HomeOrder, WaitOrder, ToolOrder> what;
};

/// More would be days of motion; a file of this many repeats is a slip or an attack.
inline constexpr std::size_t kOrdersMax = 100'000;

struct Plan {
  std::vector<Order> orders;
  double duration = 0;    ///< s of motion, waiting and tools, predicted; homing not counted
  double homing_max = 0;  ///< s, an upper bound of all homing
};

/// Seconds for a first move from nobody knows where: each joint's whole range at a tenth of its
/// top speed, 2 s at least.
double first_move_duration(const RobotModel& robot);

/// Unrolls a program and plans every move. A `home` ends at `home_deg` of the robot's file: where
/// the search leaves the joints is expected before it ran, and the way home from there planned
/// again when the machine has told.
///
/// @param homing  of this robot's joints, which are searched one after the other
///
/// @error kJointLimit (index), kToolNotFitted, kJawWidth, kToolAngle, kNoEndStops, kPositionUnknown
/// (a move of some joints, while the others are
///        nowhere known, or of the tool), kProgramTooLong, and those of RowPlanner::plan; nothing
///        of the program may run then.
std::expected<Plan, Refusal> make_plan(const Program& program, const RobotModel& robot,
                                       const Start& start, const Homing& homing = {});

/// Whether a motion's start is known and inside all limits. Elsewhere (nobody knows, or a limp arm
/// hangs beyond a limit) only a joint row goes on, slowly and in one piece.
bool plannable(const Start& q, const RobotModel& robot);
/// Where that one slow piece goes.
/// @error kPositionUnknown (a joint that the row does not name, or no joint row), kJointLimit,
///        kLegLength, or those of WireTarget
std::expected<JointVector, Refusal> first_target(const Step& row, const Start& q,
                                                 const RobotModel& robot);

}  // namespace sinew::program
