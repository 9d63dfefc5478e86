#include "sinew/calibration/robot_tip.h"

#include <cmath>
#include <variant>

#include "sinew/core/units.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/kinematics/serial_arm.h"
#include "sinew/kinematics/serial_chain.h"
#include "sinew/model/joint_lookup.h"

namespace sinew::calibration {
namespace {

/// The branch nearest to `near` inside the limits.
std::optional<JointVector> inside(Expected<kinematics::IkBranches> branches,
                                  const JointVector& near) {
  if (!branches || branches->empty()) return std::nullopt;
  kinematics::sort_by_distance(*branches, near);
  if (!(*branches)[0].within_limits) return std::nullopt;
  return (*branches)[0].q;
}

std::optional<JointVector> serial_joints_for_tip(const RobotModel& model,
                                                 const SerialGeometry& geometry, double jaw_width,
                                                 const Vec3& p_BT, const Vec3& approach_B) {
  const kinematics::SerialArm arm(geometry, model.joints,
                                  kinematics::tool_pose(geometry, jaw_width));
  const JointVector near = home_joints(model);
  if (arm.solver() == kinematics::SerialArm::Solver::kFiveRPitch) {
    const auto pitched = arm.inverse_nearest_pitch(p_BT, geometry.pitch_preferred, near);
    return pitched ? inside(pitched->branches, near) : std::nullopt;
  }
  if (arm.solver() == kinematics::SerialArm::Solver::kFiveRRoll) {
    return inside(arm.inverse_along(p_BT, approach_B, near), near);
  }
  constexpr int kTurns = 24;
  const Vec3 aside = std::abs(approach_B.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  const Vec3 x = normalized(cross(aside, approach_B));
  const Rotation R{x, cross(approach_B, x), approach_B};
  for (int turn = 0; turn < kTurns; ++turn) {
    const Rotation R_BT = R * rotation_z(turn * 2 * kPi / kTurns);
    if (const auto q = inside(arm.inverse({R_BT, p_BT}, near), near)) return q;
  }
  return std::nullopt;
}

std::optional<JointVector> bare_joints(const RobotModel& model, const TouchTool& bare,
                                       const Vec3& p_BT, const Vec3& approach_B) {
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    return serial_joints_for_tip(model, *serial, bare.jaws, p_BT, approach_B);
  }
  const auto* palletizer = std::get_if<PalletizerGeometry>(&model.geometry);
  if (palletizer == nullptr) return std::nullopt;
  const auto q = kinematics::inverse(*palletizer, model.joints, p_BT);
  return q ? std::optional(*q) : std::nullopt;
}

}  // namespace

Vec3 tip_at(const RobotModel& model, const JointVector& q, const TouchTool& tool) {
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    const auto X_BT =
        kinematics::SerialChain(*serial).forward(q) * kinematics::tool_pose(*serial, tool.jaws);
    return X_BT.p + tool.pin * X_BT.R.z;
  }
  const Vec3 p = kinematics::forward(std::get<PalletizerGeometry>(model.geometry), q).p;
  return p - Vec3{0, 0, tool.pin};
}

std::optional<JointVector> joints_for_tip(const RobotModel& model, const TouchTool& tool,
                                          const Vec3& p_BT, const Vec3& approach_B) {
  const TouchTool bare{tool.jaws, 0};
  Vec3 p_tool = p_BT - tool.pin * approach_B;
  auto q = bare_joints(model, bare, p_tool, approach_B);
  // The pin leans as the tool does.
  constexpr int kRounds = 8;
  for (int i = 0; q && tool.pin > 0 && i < kRounds; ++i) {
    p_tool = p_BT - (tip_at(model, *q, tool) - tip_at(model, *q, bare));
    q = bare_joints(model, bare, p_tool, approach_B);
  }
  return q;
}

}  // namespace sinew::calibration
