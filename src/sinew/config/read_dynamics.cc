#include "sinew/config/read_dynamics.h"

#include "sinew/devices/table_file.h"

namespace sinew {
namespace {

/// A leg's spindle has a lead instead of a ratio, and N where a joint has Nm.
void read_gear(TableReader& table, JointKind kind, StepperDrive& drive) {
  const bool leg = kind == JointKind::kPrismatic;
  const Range friction = between(0, 1000);
  if (leg) {
    double lead = 0;  // m a turn
    if (table.quantity("lead_*", kLength, above_zero_to(1), lead))
      drive.gear_ratio = 2 * kPi / lead;
    table.quantity("backlash_*", kLength, between(0, 0.01), drive.backlash);
  } else {
    table.number("gear_ratio", above_zero_to(10'000), drive.gear_ratio);
    table.quantity("backlash_*", kAngle, between(0, from_deg(10)), drive.backlash);
  }
  table.quantity("coulomb_friction_*", leg ? Dimension(kForce) : Dimension(kTorque), friction,
                 drive.coulomb_friction);
  table.quantity("viscous_friction_*", leg ? Dimension(kForcePerRate) : Dimension(kTorquePerRate),
                 friction, drive.viscous_friction);
}

void read_drive(TableReader& table, const Joint& joint, StepperDrive& drive) {
  constexpr Named<JointEncoder> kEncoders[] = {{"none", JointEncoder::kNone},
                                               {"quadrature_600", JointEncoder::kQuadrature},
                                               {"as5600", JointEncoder::kAs5600}};
  table.quantity("holding_torque_*", kTorque, above_zero_to(1000), drive.holding_torque);
  table.integer("motors", 1, 4, drive.motors);
  table.number("gear_efficiency", above_zero_to(1), drive.gear_efficiency);
  table.number("full_steps_per_rev", between(4, 10'000), drive.steps_per_turn);
  table.number("microsteps", between(1, 256), drive.microsteps);
  table.quantity("rotor_inertia_*", kInertia, above_zero_to(1), drive.rotor_inertia);
  table.quantity("corner_speed_*", kTurnRate, above_zero_to(10'000), drive.corner_speed);
  read_gear(table, joint.kind, drive);
  table.choice("joint_encoder", kEncoders, drive.joint_encoder);
}

void read_servo(TableReader& table, const Joint&, ServoRating& servo) {
  table.quantity("stall_torque_*", kTorque, above_zero_to(1000), servo.stall_torque);
  table.quantity("no_load_speed_*", kTurnRate, above_zero_to(1000), servo.no_load_speed);
  table.quantity("friction_*", kTorque, between(0, 1000), servo.friction);
}

void read_link(TableReader& table, LinkMass& link) {
  constexpr Range kOffset = between(-10, 10);  // m
  table.quantity("mass_*", kMass, between(0, 1000), link.mass);
  table.vector("centre_*", kLength, kOffset, link.p_JC);
  table.vector("inertia_*", kInertia, between(0, 1000), link.inertia);
}

/// Bounds: what 1 kHz and the encoders' lag could ever bear, and a velocity error answered in full.
void read_gains(TableReader& table, const Joint&, AxisGains& gains) {
  table.quantity("position_gain_*", kPerTime, above_zero_to(100), gains.position_gain);
  table.number("velocity_gain", between(0, 1), gains.velocity_gain);
  table.quantity("integral_gain_*", kPerTime, between(0, 100), gains.integral_gain);
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
    read(*table, model.joints[i], items[i]);
    table->finish();
  }
  tables->finish();
}

/// Of a hexapod only the platform weighs.
void read_platform(TableReader& root, RobotModel& model) {
  std::optional<TableReader> tables = root.table("link", Presence::kOptional);
  if (!tables) return;
  if (std::optional<TableReader> table = tables->table("platform")) {
    LinkMass platform;
    read_link(*table, platform);
    table->finish();
    model.dynamics.links.push_back(platform);
  }
  tables->finish();
}

}  // namespace

void read_dynamics(TableReader& root, RobotModel& model) {
  read_per_joint(root, "drive", model, model.dynamics.drives, read_drive);
  read_per_joint(root, "servo", model, model.dynamics.servos, read_servo);
  if (!model.dynamics.drives.empty() && !model.dynamics.servos.empty()) {
    root.complain("servo", "a robot has [drive] or [servo], not both");
  }
  if (std::holds_alternative<HexapodGeometry>(model.geometry)) {
    read_platform(root, model);
  } else {
    read_per_joint(
        root, "link", model, model.dynamics.links,
        [](TableReader& table, const Joint&, LinkMass& link) { read_link(table, link); });
  }
  read_per_joint(root, "control", model, model.dynamics.gains, read_gains);
}

}  // namespace sinew
