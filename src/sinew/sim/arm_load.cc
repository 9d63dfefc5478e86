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

}  // namespace sinew::sim
