#include "sinew/kinematics/palletizer_dynamics.h"

#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/kinematics/inertia.h"

namespace sinew::kinematics {
namespace {

constexpr Vec3 kSideways{0, 1, 0};  // what shoulder and forearm turn about, in (r, s, z)
constexpr Vec3 kUp{0, 0, 1};

/// Axes of a link along (r, 0, z) of length 1: x along it, y upwards, in (r, s, z).
Rotation link_axes(double r, double z) {
  return {{r, 0, z}, {-z, 0, r}, {0, -1, 0}};
}

}  // namespace

PalletizerDynamics::PalletizerDynamics(const PalletizerGeometry& geometry,
                                       std::span<const LinkMass> links)
    : geometry_(geometry), links_(links) {
  SINEW_ASSERT(links_.empty() || links_.size() == kPalletizerJoints);
}

std::array<PalletizerDynamics::Body, 4> PalletizerDynamics::bodies(
    std::span<const double> q) const {
  SINEW_ASSERT(q.size() == kPalletizerJoints);
  const Rotation upper = link_axes(-std::cos(q[1]), std::sin(q[1]));
  const Rotation fore = link_axes(std::cos(q[2]), -std::sin(q[2]));
  const Vec3 shoulder{geometry_.shoulder_offset, 0, geometry_.base_height};
  const Vec3 to_elbow = geometry_.upper_arm * upper.x;
  const Vec3 to_wrist = geometry_.forearm * fore.x;
  std::array<Body, 4> bodies;
  if (!links_.empty()) {
    // The base's own frame points along -y; seen from (r, s, z) its axes are:
    const Rotation base{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}};
    bodies[0] = {links_[0].mass, links_[0].inertia, base, base * links_[0].p_JC, {}, {}, 0};
    bodies[1] = {links_[1].mass,
                 links_[1].inertia,
                 upper,
                 shoulder,
                 to_elbow + upper * links_[1].p_JC,
                 {},
                 1};
    bodies[2] = {links_[2].mass,
                 links_[2].inertia,
                 fore,
                 shoulder,
                 to_elbow,
                 to_wrist + fore * links_[2].p_JC,
                 2};
  }
  const Vec3 level{geometry_.tool_offset, 0, 0};
  bodies[3] = {payload_, {}, {}, shoulder + level, to_elbow, to_wrist, 0};
  return bodies;
}

JointVector PalletizerDynamics::torque(std::span<const double> q, const JointMotion& motion,
                                       double gravity) const {
  SINEW_ASSERT(motion.qd.size() == kPalletizerJoints && motion.qdd.size() == kPalletizerJoints);
  // The base turns about -z: R_BT = Rz(base_front - q0).
  const Vec3 spin = -motion.qd[0] * kUp;
  const Vec3 spin_rate = -motion.qdd[0] * kUp;
  JointVector torque{0, 0, 0};
  for (const Body& body : bodies(q)) {
    // What turns with a tilting joint changes by kSideways x it, and a second time by minus it in
    // the plane of the arm.
    const Vec3 by_shoulder = cross(kSideways, body.upper);
    const Vec3 by_forearm = cross(kSideways, body.fore);
    const auto bent = [&](const Vec3& v) { return cross(kSideways, cross(kSideways, v)); };
    const double qd1 = motion.qd[1], qd2 = motion.qd[2];
    const Vec3 p = body.centre();
    const Vec3 v = qd1 * by_shoulder + qd2 * by_forearm;  // in the turning frame
    const Vec3 a = motion.qdd[1] * by_shoulder + motion.qdd[2] * by_forearm +
                   qd1 * qd1 * bent(body.upper) + qd2 * qd2 * bent(body.fore) + 2 * cross(spin, v) +
                   cross(spin_rate, p) + cross(spin, cross(spin, p)) + gravity * kUp;
    const Vec3 force = body.mass * a;
    torque[0] += dot(force, cross(-kUp, p));
    torque[1] += dot(force, by_shoulder);
    torque[2] += dot(force, by_forearm);

    const std::size_t tilt = body.tilts_with;
    const Vec3 tilt_rate = tilt == 0 ? Vec3{} : motion.qd[tilt] * kSideways;
    const Vec3 w = spin + tilt_rate;
    const Vec3 alpha =
        spin_rate + (tilt == 0 ? Vec3{} : motion.qdd[tilt] * kSideways) + cross(spin, tilt_rate);
    const Vec3 moment = inertia_times(body.R, body.inertia, alpha) +
                        cross(w, inertia_times(body.R, body.inertia, w));
    torque[0] -= dot(moment, kUp);
    if (tilt != 0) torque[tilt] += dot(moment, kSideways);
  }
  return torque;
}

double PalletizerDynamics::potential_energy(std::span<const double> q, double gravity) const {
  double moment = 0;
  for (const Body& body : bodies(q)) moment += body.mass * body.centre().z;
  return gravity * moment;
}

}  // namespace sinew::kinematics
