#include "sinew/planning/studies/inverse_dynamics.h"

#include <algorithm>

#include "sinew/core/assert.h"
#include "sinew/kinematics/serial_arm.h"

namespace sinew::planning {

using kinematics::ArmDynamics;

InverseDynamics::Body InverseDynamics::body_of(const RobotModel& model) {
  const auto& links = model.dynamics.links;
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    ArmDynamics arm(*serial, links);
    arm.set_payload({0, kinematics::tool_pose(*serial, 0.0).p});
    return arm;
  }
  if (const auto* palletizer = std::get_if<PalletizerGeometry>(&model.geometry)) {
    return Palletizer{*palletizer, {*palletizer, links}};
  }
  const auto& geometry = std::get<HexapodGeometry>(model.geometry);
  return Platform{kinematics::Hexapod(geometry),
                  geometry.X_BP_home,
                  {links.empty() ? LinkMass{} : links[0], 0}};
}

InverseDynamics::InverseDynamics(const RobotModel& model, double payload)
    : size_(model.joints.size()), body_(body_of(model)) {
  set_payload(payload);
}

void InverseDynamics::set_payload(double mass) {
  SINEW_ASSERT(mass >= 0);
  if (auto* arm = std::get_if<ArmDynamics>(&body_)) {
    arm->set_payload(mass);
  } else if (auto* palletizer = std::get_if<Palletizer>(&body_)) {
    palletizer->dynamics.set_payload(mass);
  } else {
    std::get<Platform>(body_).mass.payload = mass;
  }
}

Expected<kinematics::PoseBP> InverseDynamics::Platform::pose(std::span<const double> legs) const {
  const auto solution = hexapod.forward(JointVector(legs), X_BP_home);
  if (!solution) return std::unexpected(solution.error());
  return solution->X_BP;
}

Expected<JointVector> InverseDynamics::torque(std::span<const double> q,
                                              const kinematics::JointMotion& motion,
                                              double gravity) const {
  SINEW_ASSERT(q.size() == size_);
  if (const auto* arm = std::get_if<ArmDynamics>(&body_)) return arm->at(q).torque(motion, gravity);
  if (const auto* palletizer = std::get_if<Palletizer>(&body_)) {
    return palletizer->dynamics.torque(q, motion, gravity);
  }
  const auto& platform = std::get<Platform>(body_);
  const auto X_BP = platform.pose(q);
  if (!X_BP) return std::unexpected(X_BP.error());
  return kinematics::leg_forces(platform.hexapod, *X_BP, platform.mass, JointVector(motion.qdd),
                                gravity);
}

Expected<InverseDynamics::Parts> InverseDynamics::parts(std::span<const double> q) const {
  Parts parts;
  for (std::size_t i = 0; i < size_; ++i) parts.inertia[i].resize(size_);
  if (const auto* arm = std::get_if<ArmDynamics>(&body_)) {
    const kinematics::PlacedMasses placed = arm->at(q);
    for (std::size_t i = 0; i < size_; ++i) {
      parts.weight.push_back(placed.weight(i));
      for (std::size_t j = 0; j <= i; ++j) {
        parts.inertia[i][j] = parts.inertia[j][i] = placed.inertia(i, j);
      }
    }
    return parts;
  }
  JointVector still;
  still.resize(size_);
  const auto weight = torque(q, {still, still});
  if (!weight) return std::unexpected(weight.error());
  parts.weight = *weight;
  for (std::size_t j = 0; j < size_; ++j) {
    JointVector unit = still;
    unit[j] = 1;
    const auto column = torque(q, {still, unit}, 0);
    if (!column) return std::unexpected(column.error());
    for (std::size_t i = 0; i < size_; ++i) parts.inertia[i][j] = (*column)[i];
  }
  return parts;
}

InverseDynamics::SpeedTorque InverseDynamics::torque_by_speed(
    std::span<const double> q, const JointVector& qd, std::size_t i,
    std::optional<std::size_t> way) const {
  if (std::holds_alternative<Platform>(body_)) return {};
  std::optional<kinematics::PlacedMasses> placed;
  if (const auto* arm = std::get_if<ArmDynamics>(&body_)) placed = arm->at(q);
  JointVector still;
  still.resize(size_);
  // All joints the other way round have the same torque, so the last one keeps its way.
  const std::size_t ways = std::size_t{1} << (size_ - 1);
  SpeedTorque most;
  for (std::size_t k = way ? *way % ways : 0; k < ways; ++k) {
    JointVector turned = qd;
    for (std::size_t j = 0; j < size_; ++j) turned[j] = (k >> j & 1) != 0 ? -qd[j] : qd[j];
    const kinematics::JointMotion motion{turned, still};
    const double torque = placed ? placed->torque(motion, 0)[i]
                                 : std::get<Palletizer>(body_).dynamics.torque(q, motion, 0)[i];
    most = {std::max(most.up, -torque), std::max(most.down, torque)};
    if (way) break;
  }
  return most;
}

Expected<Vec3> InverseDynamics::payload_point(std::span<const double> q) const {
  SINEW_ASSERT(q.size() == size_);
  if (const auto* arm = std::get_if<ArmDynamics>(&body_)) {
    return arm->chain().forward(q) * arm->payload().p_FL;
  }
  if (const auto* palletizer = std::get_if<Palletizer>(&body_)) {
    return kinematics::forward(palletizer->geometry, q).p;
  }
  const auto X_BP = std::get<Platform>(body_).pose(q);
  if (!X_BP) return std::unexpected(X_BP.error());
  return X_BP->p;
}

}  // namespace sinew::planning
