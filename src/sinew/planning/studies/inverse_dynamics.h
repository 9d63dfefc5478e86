#pragma once

#include <array>
#include <optional>
#include <variant>

#include "sinew/core/error.h"
#include "sinew/kinematics/arm_dynamics.h"
#include "sinew/kinematics/hexapod_dynamics.h"
#include "sinew/kinematics/palletizer_dynamics.h"
#include "sinew/model/robot_model.h"

namespace sinew::planning {

/// Torque on the joints of any robot, one face for the three kinds of geometry. Nm, or N for legs;
/// positive where a joint has to push its q up. Rotors and friction are the drive's
/// (planning/studies/drive_train.h). @rt apart from construction.
class InverseDynamics {
 public:
  /// Without masses in the robot's file only the payload weighs. It sits at the tool point, between
  /// closed jaws where there are some; a hexapod's at the platform's origin.
  explicit InverseDynamics(const RobotModel& model, double payload = 0);

  void set_payload(double mass);  ///< kg, >= 0

  std::size_t size() const { return size_; }

  /// @error  those of Hexapod::forward(), and kSingular; arms have none.
  Expected<JointVector> torque(std::span<const double> q, const kinematics::JointMotion& motion,
                               double gravity = kinematics::kGravity) const;

  /// Torque at q is weight + inertia qdd + what comes with speed.
  struct Parts {
    JointVector weight;
    std::array<JointVector, kMaxJoints> inertia;  ///< rows of the mass matrix
  };
  /// @error  as torque()
  Expected<Parts> parts(std::span<const double> q) const;

  /// Torques on a joint that speed alone brings: the largest that pushes its q up, and the largest
  /// that pushes it down; both >= 0.
  struct SpeedTorque {
    double up = 0;
    double down = 0;
  };
  /// Of joint i at q, over all ways in which the joints can turn with the speeds of `qd`.
  /// @param way  one of those ways only, a bit a joint; nothing for all
  SpeedTorque torque_by_speed(std::span<const double> q, const JointVector& qd, std::size_t i,
                              std::optional<std::size_t> way) const;

  /// Where the payload is, in base B.
  /// @error  those of Hexapod::forward()
  Expected<Vec3> payload_point(std::span<const double> q) const;

 private:
  struct Palletizer {
    PalletizerGeometry geometry;
    kinematics::PalletizerDynamics dynamics;
  };
  struct Platform {
    kinematics::Hexapod hexapod;
    kinematics::PoseBP X_BP_home;
    kinematics::PlatformMass mass;
    Expected<kinematics::PoseBP> pose(std::span<const double> legs) const;
  };
  using Body = std::variant<kinematics::ArmDynamics, Palletizer, Platform>;
  static Body body_of(const RobotModel& model);

  std::size_t size_;
  Body body_;
};

}  // namespace sinew::planning
