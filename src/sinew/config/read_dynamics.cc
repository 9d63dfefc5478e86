#include "sinew/config/read_dynamics.h"

#include "sinew/config/read_devices.h"

namespace sinew {
namespace {

void read_drive(TableReader& table, StepperDrive& drive) {
  table.quantity("holding_torque_*", kTorque, above_zero_to(1000), drive.holding_torque);
  table.integer("motors", 1, 4, drive.motors);
  table.number("gear_ratio", above_zero_to(10'000), drive.gear_ratio);
  table.number("gear_efficiency", above_zero_to(1), drive.gear_efficiency);
  table.number("full_steps_per_rev", between(4, 10'000), drive.steps_per_turn);
  table.number("microsteps", between(1, 256), drive.microsteps);
  table.quantity("rotor_inertia_*", kInertia, above_zero_to(1), drive.rotor_inertia);
  table.quantity("corner_speed_*", kTurnRate, above_zero_to(10'000), drive.corner_speed);
  table.quantity("coulomb_friction_*", kTorque, between(0, 1000), drive.coulomb_friction);
  table.quantity("viscous_friction_*", kTorquePerRate, between(0, 1000), drive.viscous_friction);
  table.quantity("backlash_*", kAngle, between(0, from_deg(10)), drive.backlash);
}

void read_link(TableReader& table, LinkMass& link) {
  constexpr Range kOffset = between(-10, 10);  // m
  table.quantity("mass_*", kMass, between(0, 1000), link.mass);
  table.vector("centre_*", kLength, kOffset, link.p_JC);
  table.vector("inertia_*", kInertia, between(0, 1000), link.inertia);
}

template <class Item, class Read>
void read_per_joint(TableReader& root, std::string_view key, const RobotModel& model,
                    FixedVector<Item, kMaxJoints>& items, Read&& read) {
  std::optional<TableReader> tables = root.table(key, Presence::kOptional);
  if (!tables || !joints_are_sound(model)) return;
  items.resize(model.joints.size());
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    std::optional<TableReader> table = tables->table(model.joints[i].name);
    if (!table) continue;
    read(*table, items[i]);
    table->finish();
  }
  tables->finish();
}

}  // namespace

void read_dynamics(TableReader& root, RobotModel& model) {
  read_per_joint(root, "drive", model, model.dynamics.drives, read_drive);
  read_per_joint(root, "link", model, model.dynamics.links, read_link);
}

}  // namespace sinew
