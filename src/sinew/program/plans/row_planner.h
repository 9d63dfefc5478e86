#pragma once

#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "sinew/driver/wire_target.h"
#include "sinew/planning/collision/cell_way.h"
#include "sinew/planning/motion_planner.h"
#include "sinew/planning/timing/path_follower.h"
#include "sinew/program/language/program_file.h"

namespace sinew::program {

/// A place where a move has to end and that the wire cannot say.
struct Unsayable {
  std::size_t joint = 0;
  double q = 0;                        ///< of that joint, rad
  std::optional<JointVector> nearest;  ///< that it can say; of an end only
};

/// Why a way cannot be gone, where, and what would work instead.
struct WayRefusal {
  planning::PathRefusal refusal;
  planning::MoveProposal proposal;
  std::optional<Unsayable> unsayable{};
  ToolState tool{};                    ///< what the gripper was like
  std::optional<double> jaws_first{};  ///< m; with these the same rows work
};

/// Why a program cannot run.
struct Refusal {
  int line = 0;
  Error error;
  std::optional<WayRefusal> way{};
  int file = 0;  ///< of Program::files
};

/// What a row asks for and its device cannot be told, so that it does not count.
struct Unheard {
  bool speed = false;         ///< speed=, of joints or tool, and time=: it has one pace of its own
  bool acceleration = false;  ///< accel=
  bool blend = false;         ///< blend=: it stops at each corner anyway
  bool beyond = false;        ///< more than the limits: heard, and not proven on such a device
};
Unheard unheard(const MotionOptions& how, const RobotModel& robot);

/// Why a motion stops at a corner where a blend was asked for.
enum class CornerStopReason : std::uint8_t {
  kNone,       ///< none was asked for, or nothing follows
  kCostsTime,  ///< with it the moves would take longer
  kNoWay,      ///< one of its two moves goes nowhere
  kNoFit,      ///< no blend of that size, nor a shorter one, keeps what was asked and the limits
};

/// A motion and the pieces in which its device takes it.
struct RowMotion {
  std::size_t rows = 0;                             ///< that it took
  CornerStopReason stop = CornerStopReason::kNone;  ///< at its end
  double stop_saves = 0;                            ///< s, of kCostsTime
  double time = 0;                                  ///< s that was asked for, and it takes
  JointVector q_end;
  /// One after another: timed segments of a streaming device, whole moves from rest to rest of
  /// another one. Empty where the robot stands there already.
  std::vector<JointMove> pieces;
  double arrival = 0;   ///< s, from the first piece's order until the joints are at the end
  double duration = 0;  ///< s, until the driver has told so
};

/// What somebody says of a motion that was planned: nothing, or why it must not be.
using WayLook = std::function<std::optional<Error>(const planning::CellWay&)>;

/// Plans the rows of a program that move the robot. A device that takes whole moves stops behind
/// each of them: rows do not blend there. Holds the planner's workspace.
class RowPlanner {
 public:
  /// A device that takes whole moves only is led along a tool's way by moves whose straight joints
  /// leave it by no more than this (m; of its turn, rad * kTurnRadius), from stop to stop.
  static constexpr double kWayTolerance = 0.5e-3;
  static constexpr double kChordMax = 20e-3;  ///< m
  /// Where joints that do not arrive together would hit something, each move is cut in two, so
  /// often at most: then they stop together more often.
  static constexpr int kHalvingsMax = 5;
  /// m; a target that is out of reach by less is the nearest place in reach.
  static constexpr double kReachTolerance = 0.1e-3;
  /// So many rows at most blend into one motion; then there is a stop.
  static constexpr std::size_t kRowsMax = 64;
  /// Pieces of one motion: what a plan holds of it stays below some 50 MB. At 20 ms they last for
  /// half an hour.
  static constexpr std::size_t kPiecesMax = 100'000;

  /// @param robot  outlives this.
  explicit RowPlanner(const RobotModel& robot);
  ~RowPlanner();
  RowPlanner(const RowPlanner&) = delete;
  RowPlanner& operator=(const RowPlanner&) = delete;

  /// Whether refusals come with what would go instead, as they do at first. That takes longer than
  /// the plan: who tries many rows does without.
  void propose(bool wanted);

  /// Shown each motion that plan() would give.
  void show_to(WayLook look);

  /// The motion of rows[0] and of those that blend into each other behind it. The wire can say each
  /// of its pieces: a chord's end that it cannot is left out, or moved to where it can.
  /// @param tool    what the gripper is like meanwhile
  /// @param rows    all of them motions
  /// @param around  what is beside the robot: kept clear of as of its own bodies
  /// @error  those of MotionPlanner, those of WireTarget with where the way is then, and
  ///         kSegmentTime: it would take longer than a wire can say, or a plan can hold, or cannot
  ///         take as long as its row says (limit: what it can)
  std::expected<RowMotion, Refusal> plan(const JointVector& q_start, const ToolState& tool,
                                         std::span<const Step> rows,
                                         std::span<const planning::Surrounding> around = {});

  /// The jaws' way at q, from `from` to a width (m). @error kJawsContact, kCollision
  Expected<void> check_jaws(const JointVector& q, const ToolState& from, double to,
                            std::span<const planning::Surrounding> around = {}) {
    planner_.surround(around);
    return planner_.check_jaws({q.data(), q.size()}, from, to);
  }

  /// What the last plan() made, and for which robot: with the limits that its rows ask for.
  const planning::PlannedMotion& motion() const;
  const RobotModel& robot() const;
  const planning::ToolSpace& space() const { return planner_.space(); }

 private:
  /// Of a robot with lower limits, as `velocity` and `acceleration` rows ask for.
  struct Limited;

  std::expected<RowMotion, Refusal> plan_alike(const JointVector& q_start, const ToolState& tool,
                                               std::span<const Step> rows);
  /// A width (m) with which rows work that are refused while nobody knows the jaws'.
  std::optional<double> jaws_first(const JointVector& q_start, std::span<const Step> rows);
  std::expected<RowMotion, Refusal> plan_limited(const JointVector& q_start, const ToolState& tool,
                                                 std::span<const Step> rows);
  /// Of rows with the same limits.
  std::expected<RowMotion, Refusal> plan_rows(const JointVector& q_start, const ToolState& tool,
                                              std::span<const Step> rows);
  std::expected<void, Refusal> make_moves(const planning::RobotPlace& start,
                                          std::span<const Step> rows);
  Refusal refusal(std::span<const Step> rows, const planning::PathRefusal& why);
  std::expected<void, Refusal> plan_moves(const planning::RobotPlace& start,
                                          std::span<const Step> rows);
  bool come_nearer(const WayRefusal& why);
  bool choose_attitude(std::span<const Step> rows, const Refusal& refusal);
  void keep_refusal(Refusal now, std::optional<Refusal>& kept) const;
  std::optional<Error> take_time(const RowMotion& out);
  std::optional<Error> slow_down(RowMotion& out) const;
  std::optional<Error> shown(const JointVector& q_start, const RowMotion& motion) const;
  void tell_stop(std::span<const Step> rows, RowMotion& out);
  std::expected<void, Refusal> cut_into_segments(std::span<const Step> rows,
                                                 const planning::RobotPlace& start,
                                                 RowMotion& out) const;
  void cut_into_chords(const planning::RobotPlace& start, std::span<const double> places,
                       RowMotion& out) const;
  std::expected<std::vector<double>, Refusal> chord_places(std::span<const Step> rows,
                                                           const planning::RobotPlace& start) const;
  std::expected<void, Refusal> cut_into_moves(std::span<const Step> rows,
                                              const planning::RobotPlace& start, RowMotion& out);
  std::optional<Refusal> driven_contact(std::span<const Step> rows,
                                        const planning::RobotPlace& start,
                                        std::span<const double> places, const RowMotion& out) const;
  JointVector joints_at(double s) const;
  double off_way(double begin, double end, const kinematics::PoseBT& X_near) const;
  Refusal unsayable(std::span<const Step> rows, const planning::RobotPlace& start, double s,
                    const JointVector& q, const Error& error) const;
  double piece_duration(const JointVector& from, const JointVector& to, const planning::Move& move,
                        double in_motion) const;
  double tool_acceleration(const JointVector& from, const JointVector& to, double share) const;

  const RobotModel& robot_;
  std::span<const planning::Surrounding> around_;  ///< of the plan at hand
  double tips_ahead_ = 0;                          ///< m, of those of open jaws
  MotionDelay delay_;
  WireTarget wire_;
  planning::MotionPlanner planner_;
  planning::PlannedMotion motion_;
  std::vector<planning::Move> moves_;
  /// Of a row that names no orientation and cannot keep the one at hand.
  struct Attitude {
    int tries = 0;
    std::optional<kinematics::PoseBT> X_BT;
    bool nearest = false;  ///< none reaches the target; this one comes nearest
  };
  std::vector<Attitude> attitudes_;                   ///< one per row of the plan at hand
  std::unique_ptr<planning::PathFollower> follower_;  ///< of motions with a time of their own
  WayLook look_;
  bool proposes_ = true;
  std::unique_ptr<Limited> limited_;
  bool limited_now_ = false;  ///< the last plan() was made with it
};

/// Where a joint row goes from `from`: joints that it does not name stay.
JointVector resolved(const JointStep& step, const JointVector& from);

/// How long a device takes for one move from rest to rest between known places, s: its joints go
/// together, or each is told by itself and then goes at its own pace.
double whole_move_duration(const JointVector& from, const JointVector& to, const RobotModel& robot,
                           double speed);

/// The profile of one move between two known places, straight in joint space; `speed`, a share of
/// the limits, counts where the device can be asked for it.
motion::RestToRest profile_between(const JointVector& from, const JointVector& to,
                                   const RobotModel& robot, double speed);

}  // namespace sinew::program
