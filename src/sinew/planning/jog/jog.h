#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/planning/collision/collision.h"
#include "sinew/planning/jog/jog_joint.h"
#include "sinew/planning/jog/jog_resolver.h"
#include "sinew/planning/jog/jog_space.h"
#include "sinew/planning/jog/jog_stop.h"
#include "sinew/planning/jog/twist_ramp.h"

namespace sinew::planning {

/// How long a jog command holds where nobody says otherwise.
inline constexpr Duration kJogExpiry = std::chrono::milliseconds(150);
/// Of the run's own time: a simulated cell may run a thousand times as fast as whoever holds the
/// stick.
inline constexpr Duration kJogExpiryMax = std::chrono::seconds(1000);

/// A velocity that is wanted from now on, and for how long it counts.
struct JogCommand {
  JogFrame frame = JogFrame::kJoint;
  /// As many numbers as JogSpace::numbers() says; of a tool also its first three alone, which then
  /// keeps its attitude. rad/s and m/s.
  FixedVector<double, kMaxJoints> velocity;
  Duration expiry = kJogExpiry;
};

/// Why a jog is slower than it was asked to be, the most important first.
enum class JogReason : std::uint8_t {
  kNone,        ///< it is as fast as asked, or will be as soon as it has gathered speed
  kNoCommand,   ///< none was given, or it was to stand still
  kStopped,     ///< by stop()
  kExpired,     ///< nobody renewed the command
  kContact,     ///< the robot would touch itself or its table
  kOverlap,     ///< it stood nearer than its margin at the start; its joints go, slowly
  kPoseLimit,   ///< a hexapod's joints or condition, a palletizer's nozzle or elbow
  kJointLimit,  ///< joint `joint` is at its limit
  kSingular,    ///< a direction is lost
  kJointSpeed,  ///< joint `joint` would be too fast; all are slowed down together
  kWire,        ///< it cannot carry that much for all joints together
};

struct JogStatus {
  JogReason reason = JogReason::kNoCommand;
  std::int8_t joint = -1;
  double share = 0;     ///< of the velocity asked for that is driven along it; 1 is all
  double distance = 0;  ///< m between what is nearest where the reason is kOverlap; below 0 inside
  bool moving = false;
};

/// Jogging one robot: velocities come in whenever somebody moves a stick, setpoints go out each
/// cycle. Sans-IO: time is handed in.
///
/// Whatever is commanded and whenever, every joint keeps its limits of velocity, acceleration and
/// jerk, and can at every instant come to rest inside its limits of position. Joints that share a
/// wire divide what it carries as the command asks for; while some take over from others the sum
/// stays within 1 % of it where joints are driven, and within a quarter where the tool is, whose
/// direction counts more. Where the tool is driven, its direction is kept as the joints gather
/// speed, and where a joint's limit or a singularity takes a part of it away, the rest goes on
/// along the boundary; away from there it always goes. Places at which the robot would touch itself
/// or its table, and poses that its geometry cannot have, are kept out by looking at the way on
/// which the joints would come to rest: where that is not free, they come to rest before. From a
/// contact only another command leads on.
///
/// A robot that overlaps at the start may have no way out on which it does not overlap more at
/// first: until nothing does any more its joints can be driven in any direction, at kOverlapShare
/// of their speed, and whoever drives them has to look. Its tool goes only where all comes apart.
///
/// Source: Berscheid and Kroeger 2021 for retargeting by plans to a velocity; the ideas of MoveIt
/// Servo for the rest, whose known troubles (no way back out of a singularity or from a limit) are
/// what the boundaries here are made for; docs/jog.md.
/// @rt  all functions but the constructor: no allocation, no lock.
class Jog {
 public:
  /// A cycle longer than this is a gap: the robot comes to rest in it, and the command is gone.
  static constexpr Duration kGap = std::chrono::milliseconds(50);
  /// Cycles are cut into steps of at most this.
  static constexpr Duration kStep = std::chrono::milliseconds(10);
  /// Of the joints' speeds while the robot overlaps.
  static constexpr double kOverlapShare = 0.1;
  /// m: nearer than the margin by more than this is an overlap; less is what the way to rest before
  /// a contact may be off by.
  static constexpr double kOverlapDepth = 2e-3;
  /// Faster than any of these commands are mistakes: m/s, rad/s.
  static constexpr double kSpeedMax = 100;

  struct Options {
    bool avoid_contact = true;
  };
  /// @param model  outlives this. Its limits count times its device's limits_share.
  explicit Jog(const RobotModel& model) : Jog(model, Options{}) {}
  Jog(const RobotModel& model, const Options& options);
  Jog(const Jog&) = delete;
  Jog& operator=(const Jog&) = delete;

  std::size_t joints() const { return joints_.size(); }
  const JogSpace& space() const { return space_; }

  /// What is beside the robot from now on, at most CollisionModel::kSurroundMax; kept out like the
  /// robot's own bodies.
  void surround(std::span<const Surrounding> bodies) {
    if (collision_) collision_->surround(bodies);
  }

  /// What the gripper is like from now on, at rest.
  void fit(const ToolState& tool) {
    space_.fit(tool.jaws);
    if (collision_) collision_->fit(tool);
  }

  /// Where the robot is and how it moves; it then comes to rest until there is a command. A joint
  /// may stand outside of its limits of position.
  /// @param X_near  a hexapod's last pose, its home where absent.
  /// @error kMotionInput (index: a joint whose state is no number, or beyond its limits of velocity
  ///        or acceleration, or -1: their number), of ToolSpace::forward().
  std::optional<Error> start(std::span<const motion::AxisState> states, Instant now,
                             const PoseBT* X_near = nullptr);

  /// @error kTaskNotSupported (a frame or numbers that this robot does not have), kMoveInput
  ///        (index: which number is none, or is beyond kSpeedMax), kSegmentTime (an expiry that is
  ///        not above 0 and up to kJogExpiryMax; or `now` lies before what was said last). What was
  ///        commanded before then goes on.
  std::optional<Error> command(const JogCommand& command, Instant now);
  /// To rest along the direction in which the joints move, in the time that the slowest of them
  /// needs; the next command moves again. A command of zeros and one that expires do the same: to
  /// keep the tool's own direction would take joints near a singularity longer, and farther.
  void stop();

  /// Time goes on; setpoint() is where the joints shall be at `now`.
  /// @error kSegmentTime: time runs back. Nothing happens then.
  std::optional<Error> step(Instant now);

  const motion::AxisStates& setpoint() const { return setpoint_; }
  /// Where the tool is at the setpoint.
  const PoseBT& pose() const { return X_BT_; }
  bool at_rest() const;
  JogStatus status() const;
  /// m between what is nearest, below 0 inside each other, while it overlaps since the start.
  std::optional<double> overlap() const {
    return overlaps_ ? std::optional(distance_) : std::nullopt;
  }

 private:
  enum class Drive : std::uint8_t { kRest, kBrake, kJoints, kTool };
  using States = std::array<motion::AxisState, kMaxJoints>;

  bool driven() const { return drive_ == Drive::kJoints || drive_ == Drive::kTool; }
  std::optional<Error> refusal(const JogCommand& command, Instant now) const;
  void expire(Instant now);
  void advance(double dt);
  void brake(double dt);
  void drive_joints(double dt);
  bool drive_tool(double dt);
  void begin_ramp();
  double speed_share(const JointArray& full, const JointArray& turn);
  void slow_for_wire(const JointArray& full, double& share);
  void share_wire(JointArray& wanted) const;
  double ramp_limits(const JointArray& change, const JointArray& turn, double& jerk) const;
  void try_states(const States& next, double dt);
  void plan_stop(const States& states, JogStop& stop) const;
  bool may_be(const JogStop& stop);
  bool clear_to_rest(std::span<const JointArray> way) const;
  void look_at_overlap();
  void set_states(const States& next);

  JogSpace space_;
  FixedVector<JogJoint, kMaxJoints> joints_;
  double shared_velocity_;  ///< of all joints together
  std::unique_ptr<CollisionModel> collision_;
  JogResolver resolver_;
  TwistRamp ramp_;

  Drive drive_ = Drive::kRest;
  JogFrame frame_ = JogFrame::kJoint;
  TaskArray wanted_{};          ///< of the tool, scaled
  JointArray wanted_joints_{};  ///< of the joints, or the tool again
  Instant last_{};
  Instant expires_{};
  States states_{};
  motion::AxisStates setpoint_{};
  PoseBT X_BT_;
  double violation_ = 0;
  std::array<JogStop, 2> stops_;
  JogStop* stop_ = &stops_[0];   ///< from the state `stopping_` s ago; found to be free
  JogStop* tried_ = &stops_[1];  ///< workspace
  double stopping_ = 0;
  bool can_stop_ = false;  ///< stop_ begins here

  bool ramp_valid_ = false;
  JointArray reference_{};   ///< joints' velocities, of the last step
  JointArray along_ramp_{};  ///< the same without what leads out of singularities
  JointArray turn_{};        ///< how the reference changes while the tool's velocity does not
  unsigned held_ = 0;
  double step_ = 0;  ///< s, the last one

  bool overlaps_ = false;  ///< since the start
  double distance_ = 0;    ///< m, of what is nearest meanwhile

  JogReason refused_ = JogReason::kNone;  ///< why it comes to rest although there is a command
  JogReason idle_ = JogReason::kNoCommand;
  double speed_share_ = 1;
  bool wire_slows_ = false;
  std::int8_t slowest_ = -1;
};

}  // namespace sinew::planning
