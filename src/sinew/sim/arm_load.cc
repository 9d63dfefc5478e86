#include "sinew/sim/arm_load.h"

namespace sinew::sim {

ArmLoad::ArmLoad(const SerialGeometry& geometry, const Dynamics& dynamics)
    : arm_(geometry, dynamics.links) {}

void ArmLoad::update(std::span<const double> q) {
  const kinematics::PlacedMasses placed = arm_.at(q);
  potential_energy_ = placed.potential_energy();
  for (std::size_t i = 0; i < placed.size(); ++i) {
    torque_[i] = -placed.weight(i);
    inertia_[i] = placed.inertia(i, i);
  }
}

Dynamics masses_of_servo_arm(const RobotModel& model) {
  if (!model.dynamics.links.empty()) return model.dynamics;
  constexpr std::array<double, 5> kMasses{0.15, 0.11, 0.10, 0.07, 0.14};  // kg
  Dynamics dynamics;
  const auto& rows = std::get<SerialGeometry>(model.geometry).rows;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    LinkMass link;
    link.mass = kMasses[std::min(i, kMasses.size() - 1)];
    link.p_JC = {-rows[i].a / 2, 0, 0};
    link.inertia = {1e-4, 1e-4, 1e-4};
    dynamics.links.push_back(link);
  }
  return dynamics;
}

SerialGeometry tool_at_tips(SerialGeometry geometry) {
  if (geometry.gripper) {
    geometry.X_FT.p = geometry.X_FT.p + Vec3{0, 0, geometry.gripper->reach_closed};
  }
  return geometry;
}

}  // namespace sinew::sim
