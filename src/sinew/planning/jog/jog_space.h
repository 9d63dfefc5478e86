#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/planning/jog/task_solver.h"
#include "sinew/planning/paths/tool_space.h"

namespace sinew::planning {

/// What a jog's numbers are counted in.
enum class JogFrame : std::uint8_t {
  kJoint,     ///< one number a joint or leg
  kBase,      ///< of the tool, along and about the base's axes
  kTool,      ///< of the tool, along and about its own axes
  kPlatform,  ///< of a hexapod's platform, along and about its own axes
};

/// What a robot's tool does while its joints move, in the numbers that a jog is asked for: by task
/// space
///   kPose       v (m/s), w (rad/s) of the tool's tip
///   kApproach   the same; the turn about the tool's z axis is left out of w, that arm has none
///   kPitchRoll  v, the tool's pitch as the second joint counts it, its roll about its z axis; the
///               tool turns with the arm's plane
///   kPoint      v
/// A SCARA is a kPose with v and its turn about the vertical; in the tool's frame that about its z.
/// Inside a jog these numbers are scaled: v in lengths of the arm per second, turns by half of
/// that, as a tool's tip at half of the arm's length would move. @rt
class JogSpace {
 public:
  /// @param model  outlives this.
  explicit JogSpace(const RobotModel& model);
  /// The jaws are so far apart from now on, m; open where absent.
  void fit(std::optional<double> jaw_width) { tool_ = ToolSpace(*model_, jaw_width); }

  const RobotModel& model() const { return *model_; }
  const ToolSpace& tool() const { return tool_; }
  std::size_t joints() const { return tool_.size(); }
  std::span<const Joint> limits() const { return tool_.joints(); }
  bool has(JogFrame frame) const;
  /// How many numbers a command has in that frame.
  std::size_t numbers(JogFrame frame) const;
  /// What a number of a tool's command is multiplied with.
  double scale(std::size_t number) const { return number < 3 ? linear_ : angular_; }

  /// The tool at q, and what each joint does to it there. Not for a hexapod.
  PoseBT look(JogFrame frame, const JointArray& q, TaskJacobian& J) const;
  /// The tool at q. @param X_near  a hexapod's last pose. @error of ToolSpace::forward().
  Expected<PoseBT> place(const JointArray& q, const PoseBT& X_near) const;

  /// By how much q leaves what the robot can do, beside its joints' limits: 0 where it does not. A
  /// hexapod's ball joints, cardans and condition number, a palletizer's nozzle near its base and
  /// its elbow turned over; a number that only tells more from less.
  double violation(const JointArray& q, const PoseBT& X_near) const;
  /// There is something that violation() could tell.
  bool has_more_limits() const { return tool_.serial() == nullptr; }
  /// Distance (m) that a palletizer's nozzle may still come nearer to its first axis, and the
  /// direction away from it; infinite elsewhere.
  double room_to_axis(const PoseBT& X_BT, Vec3& away) const;

 private:
  PoseBT look_serial(const kinematics::SerialArm& arm, JogFrame frame, const JointArray& q,
                     TaskJacobian& J) const;

  const RobotModel* model_;
  ToolSpace tool_;
  const PalletizerGeometry* palletizer_;
  double linear_ = 1;
  double angular_ = 1;
};

}  // namespace sinew::planning
