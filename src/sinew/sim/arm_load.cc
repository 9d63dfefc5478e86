#include "sinew/sim/arm_load.h"

#include "sinew/core/assert.h"

namespace sinew::sim {
namespace {

constexpr double kGravity = 9.80665;  // m/s^2, standard; along -z of the base

}  // namespace

ArmLoad::ArmLoad(const SerialGeometry& geometry, const Dynamics& dynamics)
    : chain_(geometry), links_(dynamics.links), p_FT_(geometry.X_FT.p) {
  SINEW_ASSERT(links_.empty() || links_.size() == chain_.size());
}

void ArmLoad::place(std::span<const double> q) {
  kinematics::PoseBF X;  // of the frame that the joint turns about, then of the link's own
  bodies_.clear();
  for (std::size_t i = 0; i < chain_.size(); ++i) {
    axis_[i] = X.R.z;
    origin_[i] = X.p;
    X = relabel<frame::Base, frame::Base>(X) * chain_.link(i, q[i]);
    if (links_.empty()) continue;
    bodies_.push_back({links_[i].mass, X * links_[i].p_JC, X.R, links_[i].inertia});
  }
  bodies_.push_back({payload_, X * p_FT_, X.R, {}});
}

void ArmLoad::update(std::span<const double> q) {
  SINEW_ASSERT(q.size() == chain_.size());
  place(q);
  potential_energy_ = 0;
  for (const Body& body : bodies_) potential_energy_ += body.mass * kGravity * body.p_BC.z;
  for (std::size_t i = 0; i < chain_.size(); ++i) {
    const Vec3& z = axis_[i];
    double torque = 0;
    double inertia = 0;
    // The payload is the body behind the last link, with or without links.
    for (std::size_t k = links_.empty() ? 0 : i; k < bodies_.size(); ++k) {
      const Body& body = bodies_[k];
      const Vec3 lever = cross(z, body.p_BC - origin_[i]);
      torque -= body.mass * kGravity * lever.z;
      const Vec3 z_C = transposed_times(body.R_BC, z);
      inertia += body.mass * dot(lever, lever) + body.inertia.x * z_C.x * z_C.x +
                 body.inertia.y * z_C.y * z_C.y + body.inertia.z * z_C.z * z_C.z;
    }
    torque_[i] = torque;
    inertia_[i] = inertia;
  }
}

Dynamics robot_arm_2_dynamics() {
  const auto drive = [](double torque, int motors, double rotor_inertia, double corner_speed) {
    StepperDrive made;
    made.holding_torque = torque;
    made.motors = motors;
    made.gear_ratio = 17;
    made.gear_efficiency = 0.7;
    made.rotor_inertia = rotor_inertia;
    made.corner_speed = corner_speed;
    // ASSUMED: dry friction 3 % of what the joint can do, viscous friction another 3 % at 100
    // deg/s; printed planetary and belt stages are reported between 2 and 10 %.
    const double joint_torque = torque * motors * made.gear_ratio * made.gear_efficiency;
    made.coulomb_friction = 0.03 * joint_torque;
    made.viscous_friction = 0.03 * joint_torque / from_deg(100);
    made.backlash = from_deg(0.2);  // ASSUMED: usual for printed gears
    return made;
  };
  // Rotor inertias as data sheets of that length and torque have them: NEMA 23 of 56 mm 300 g cm^2,
  // of 76 mm 480 g cm^2, NEMA 17 of 40 mm 54 g cm^2. Corner speeds ASSUMED: supply / (current x
  // inductance) / 50 pole pairs at 24 V with 2.8 A and 2.5 mH, 2.8 A and 3.2 mH, 1.7 A and 2.8 mH.
  constexpr double kNema23 = 3.0e-5, kNema23Long = 4.8e-5, kNema17 = 5.4e-6;  // kg m^2
  Dynamics dynamics;
  dynamics.drives = {drive(1.26, 1, kNema23, 68),  drive(1.89, 2, kNema23Long, 54),
                     drive(1.26, 2, kNema23, 68),  drive(1.26, 1, kNema23, 68),
                     drive(0.40, 2, kNema17, 100), drive(0.40, 1, kNema17, 100)};
  // ASSUMED masses: each motor of a joint rides on the link before it (1.0 and 0.7 kg a NEMA 23,
  // 0.28 kg a NEMA 17), the rest is printed shell and bearings. Inertias of boxes of that size.
  dynamics.links = {
      {4.2, {0, -0.07, 0}, {0.020, 0.018, 0.020}},    // turret with the shoulder's two motors
      {3.0, {-0.14, 0, 0}, {0.006, 0.030, 0.030}},    // upper arm with the elbow's two
      {1.7, {0, 0, 0.03}, {0.006, 0.006, 0.003}},     // elbow with the forearm roll's
      {1.3, {0, 0.14, 0}, {0.008, 0.002, 0.008}},     // forearm with the wrist bend's two
      {0.5, {0, 0, 0.03}, {0.0006, 0.0006, 0.0004}},  // wrist with the flange roll's
      {0.15, {0, 0, -0.03}, {1e-4, 1e-4, 1.5e-4}},    // flange
  };
  return dynamics;
}

}  // namespace sinew::sim
