#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "sinew/kinematics/hexapod.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/kinematics/serial_arm.h"
#include "sinew/model/robot_model.h"
#include "sinew/planning/paths/joint_path.h"

namespace sinew::planning {

using kinematics::PoseBT;

/// What a robot's tool can be asked for; its joints do not give more.
enum class TaskSpace : std::uint8_t {
  kPose,       ///< position and orientation: six joints, a chain of another structure, a hexapod;
               ///< of a SCARA's orientation its turn about the vertical
  kPitchRoll,  ///< position, pitch, roll; the tool stays in the plane through the first axis
  kApproach,   ///< position and direction of the tool's z axis; the roll about it follows
  kPoint,      ///< position; the tool turns with the base
};

/// How far (rad) a typed orientation may be from what the robot can have before it is refused.
inline constexpr double kTaskTolerance = from_deg(0.01);

/// This much of a turn (m per rad) counts as a metre of the tool's way: a hand's radius. It makes
/// turns on the spot comparable with lines.
inline constexpr double kTurnRadius = 0.1;

/// One point of a robot's task space. `attitude` holds, as the TaskSpace says, a quaternion (w, x,
/// y, z; either sign), pitch and roll (rad, as in kinematics::PitchTarget), a unit vector in base
/// B, or nothing; what is left over is zero.
struct TaskPoint {
  Vec3 p_BT;  ///< m
  std::array<double, 4> attitude{};
};

/// How far apart two places of the tool are.
struct ToolOffset {
  double distance = 0;  ///< m
  double angle = 0;     ///< rad, of what the task space knows of the orientation
};

/// The nearest pose that the robot can have where one was asked for that it cannot.
struct NearestPose {
  PoseBT X_BT;
  TaskPoint point;  ///< the same in the robot's own terms: pitch and roll of a five-joint arm
  Error error;      ///< why not as asked; `measured` is how far it is turned away, rad
};

/// One face for all geometries: where the tool is at q, and which q continues a path to a point of
/// the task space. A hexapod's tool is its platform: X_BT is its X_BP. @rt
class ToolSpace {
 public:
  /// @param model      outlives this.
  /// @param jaw_width  m between a gripper's jaws; open where absent.
  explicit ToolSpace(const RobotModel& model, std::optional<double> jaw_width = {});

  TaskSpace task() const { return task_; }
  std::size_t size() const { return joints_.size(); }
  std::span<const Joint> joints() const { return joints_; }
  /// What the speeds of all joints together may be, m/s (rad/s); planning/paths/motion_limits.h.
  double shared_velocity() const { return shared_velocity_; }
  /// Nothing where the robot is another one.
  const kinematics::Hexapod* hexapod() const;
  const kinematics::SerialArm* serial() const;

  /// Its tool turns about the vertical alone: a SCARA; nothing of others.
  const kinematics::Scara* scara() const;

  /// A pose to start from where nobody knows a last one.
  PoseBT home() const { return X_home_; }

  /// Tool in base at q.
  /// @param X_near  a hexapod's last pose; others do not look at it.
  /// @error of Hexapod::forward(); none elsewhere.
  Expected<PoseBT> forward(std::span<const double> q, const PoseBT& X_near) const;

  /// What of a pose this robot can be asked for, and the rest left out.
  TaskPoint point(const PoseBT& X_BT) const;
  /// The pose at a point; of a kApproach the one whose x axis is nearest to that of `like`, of a
  /// kPoint the one that the base gives.
  PoseBT pose(const TaskPoint& at, const Rotation& like = {}) const;

  /// The pose itself where this robot can have its orientation (to kTaskTolerance), else the
  /// nearest one: for a five-joint arm first the approach axis turned into the plane, then the
  /// roll; with a rolling forearm the roll of the nearest branch inside the limits. Nothing is said
  /// of positions that are out of reach.
  /// @error of the position where no roll can be had at all.
  std::expected<TaskPoint, NearestPose> asked(const PoseBT& X_BT,
                                              std::span<const double> near) const;

  /// The joints that bring the tool to `at` and continue from `q_near`: the nearest of all
  /// branches by the largest joint move, without turning a joint over. Joint limits are not looked
  /// at (a path is held against them as a whole), except by chains without a closed form.
  /// @error of the robot's inverse; kShoulderSingular for a five-joint arm's tip on its first axis
  Expected<JointArray> inverse_near(const TaskPoint& at, const JointArray& q_near) const;

  /// All joints inside the limits that bring the tool to `at`, the nearest to `q_near` first.
  FixedVector<JointArray, 8> branches(const TaskPoint& at, const JointArray& q_near) const;

  /// From `want` to where the tool is.
  ToolOffset offset(const PoseBT& X_BT, const TaskPoint& want) const;

  /// Which singularity is near at q, with its measure: kShoulderSingular (m), kElbowSingular,
  /// kWristSingular (sines), else kSingular with the smallest singular value.
  Error singularity(std::span<const double> q, const PoseBT& X_BT) const;

 private:
  std::expected<TaskPoint, NearestPose> asked_with_roll(const PoseBT& X_BT,
                                                        std::span<const double> near) const;
  Expected<kinematics::IkBranches> solve(const kinematics::SerialArm& arm, const TaskPoint& at,
                                         std::span<const double> near) const;
  Expected<JointArray> nearest_branch(const kinematics::SerialArm& arm, const TaskPoint& at,
                                      const JointArray& q_near) const;

  std::span<const Joint> joints_;
  double shared_velocity_;
  std::vector<Joint> unlimited_;  ///< a palletizer's joints with limits that no angle breaks
  std::variant<kinematics::SerialArm, PalletizerGeometry, kinematics::Hexapod> robot_;
  TaskSpace task_ = TaskSpace::kPose;
  PoseBT X_home_;
};

/// Of the attitudes of two points, rad, without regard to their positions. @rt
double turn_between(TaskSpace task, const TaskPoint& a, const TaskPoint& b);

}  // namespace sinew::planning
