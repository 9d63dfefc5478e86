#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/pose.h"
#include "sinew/core/units.h"
#include "sinew/core/vec3.h"
#include "sinew/model/collision.h"
#include "sinew/model/device.h"
#include "sinew/model/dynamics.h"

namespace sinew {

/// One number per joint or leg, in the order of the robot's file: rad, or m for a leg.
using JointVector = FixedVector<double, kMaxJoints>;

enum class JointKind : std::uint8_t { kRevolute, kPrismatic };

/// One joint as its file describes it; rad (m for prismatic), per second powers. lower < upper and
/// all maxima > 0 are guaranteed by whoever built the model.
struct Joint {
  std::string name;
  JointKind kind = JointKind::kRevolute;
  double lower = 0;
  double upper = 0;
  double velocity_max = 0;
  double acceleration_max = 0;
  double jerk_max = 0;
  double home = 0;

  bool slides() const { return kind == JointKind::kPrismatic; }
};

/// One row of a standard Denavit-Hartenberg table:
/// X_{i-1,i} = Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha). m and rad.
struct DhRow {
  double d = 0;  ///< of a prismatic joint at q = 0: the joint adds q
  double a = 0;
  double alpha = 0;
  double theta_offset = 0;  ///< of a revolute joint at q = 0: the joint adds q
  JointKind kind = JointKind::kRevolute;
};

/// A gripper with two parallel jaws whose finger tips move along the approach axis as they close.
struct JawGripper {
  double width_max = 0;     ///< m, jaws open
  double reach_open = 0;    ///< m from the flange to the finger tips at width_max
  double reach_closed = 0;  ///< m, at width 0
};

/// Open chain.
struct SerialGeometry {
  FixedVector<DhRow, kMaxJoints> rows;
  Pose<frame::Flange, frame::Tool> X_FT;  ///< without the gripper's reach
  std::optional<JawGripper> gripper;
  /// Angle of the approach axis from vertical (0 up, pi down) that is tried first where a 5R arm
  /// is asked for a point and no pitch; rad.
  double pitch_preferred = 0;
};

/// Four-bar palletizer: the tool keeps its attitude, turned by the base alone. Angles as the
/// maker's firmware counts them; docs/kinematics/maxarm.md draws them.
struct PalletizerGeometry {
  double base_height = 0;      ///< L0, m: table to shoulder axis
  double shoulder_offset = 0;  ///< L1, m: base axis to shoulder axis
  double upper_arm = 0;        ///< L2, m
  double forearm = 0;          ///< L3, m
  double tool_offset = 0;      ///< L4, m: forearm end to nozzle, horizontal
  double base_front = 0;       ///< rad: base angle at which the arm points to -y
  double radius_min = 0;       ///< m: the firmware ignores targets nearer to the base axis
};

inline constexpr std::size_t kLegs = 6;

/// 6-UPS platform. Leg i goes from base anchor i to platform anchor i.
struct HexapodGeometry {
  std::array<Vec3, kLegs> p_BA;           ///< base anchors in base B, m
  std::array<Vec3, kLegs> p_PA;           ///< platform anchors in platform P, m
  std::array<Vec3, kLegs> motor_axis_B;   ///< unit; the cardan bends away from it
  std::array<Vec3, kLegs> skewer_axis_P;  ///< unit; the ball joint tilts towards it
  double cardan_angle_max = 0;            ///< rad
  double ball_angle_max = 0;              ///< rad: |leg . skewer| <= sin(ball_angle_max)
  double condition_max = 0;
  double platform_radius = 0;  ///< m; scales rotations in the condition number
  Pose<frame::Base, frame::Platform> X_BP_home;
};

using Geometry = std::variant<SerialGeometry, PalletizerGeometry, HexapodGeometry>;

/// A robot, validated: whoever holds one may rely on every promise of the comments above.
struct RobotModel {
  std::string id;
  std::string title;
  Geometry geometry;
  std::vector<Joint> joints;  ///< at most kMaxJoints; six legs for a hexapod
  Dynamics dynamics;          ///< what moves it and what it weighs; empty where nobody said
  Collision collision;        ///< what it must not hit itself and its table with
  Device device;
};

/// Limits are inclusive, with this much for rounding: a target that sits on a limit is inside.
inline constexpr double kJointLimitTolerance = 1e-9 * kPi / 180;

/// @rt
inline bool within_limits(const Joint& joint, double q) {
  return q >= joint.lower - kJointLimitTolerance && q <= joint.upper + kJointLimitTolerance;
}

}  // namespace sinew
