#include "sinew/kinematics/arm_dynamics.h"

#include <algorithm>

#include "sinew/core/assert.h"
#include "sinew/kinematics/inertia.h"

namespace sinew::kinematics {

ArmDynamics::ArmDynamics(const SerialGeometry& geometry, std::span<const LinkMass> links)
    : chain_(geometry), links_(links), payload_{0, geometry.X_FT.p} {
  SINEW_ASSERT(links_.empty() || links_.size() == chain_.size());
}

PlacedMasses ArmDynamics::at(std::span<const double> q) const {
  SINEW_ASSERT(q.size() == chain_.size());
  PlacedMasses placed;
  placed.size_ = chain_.size();
  PoseBF X;  // of the frame that the joint turns about, then of the link's own
  for (std::size_t i = 0; i < chain_.size(); ++i) {
    placed.axis_[i] = X.R.z;
    placed.origin_[i] = X.p;
    placed.slides_[i] = chain_.slides(i);
    X = relabel<frame::Base, frame::Base>(X) * chain_.link(i, q[i]);
    if (links_.empty()) continue;
    placed.bodies_.push_back({links_[i].mass, X * links_[i].p_JC, X.R, links_[i].inertia});
  }
  placed.bodies_.push_back({payload_.mass, X * payload_.p_FL, X.R, {}});
  return placed;
}

JointVector PlacedMasses::torque(const JointMotion& motion, double gravity) const {
  SINEW_ASSERT(motion.qd.size() == size_ && motion.qdd.size() == size_);
  // Outwards: link i turns with w and alpha, its joint's origin has the acceleration a. The base
  // that is pushed up at g feels what the base at rest feels by its weight.
  Vec3 w, alpha, a{0, 0, gravity};
  Vec3 origin;
  std::array<Vec3, kMaxJoints> force, moment_B;  // on the bodies of link i; about the base's origin
  for (std::size_t i = 0; i < size_; ++i) {
    const auto carried = [&](const Vec3& r) { return cross(alpha, r) + cross(w, cross(w, r)); };
    a = a + carried(origin_[i] - origin);
    origin = origin_[i];
    const Vec3 rate = motion.qd[i] * axis_[i];
    const Vec3 push = motion.qdd[i] * axis_[i] + cross(w, rate);
    if (slides_[i]) {
      a = a + push + cross(w, rate);  // both halves of Coriolis' acceleration
    } else {
      alpha = alpha + push;
      w = w + rate;
    }
    force[i] = moment_B[i] = Vec3{};
    const auto add = [&](const Body& body) {
      const Vec3 f = body.mass * (a + carried(body.p_BC - origin));
      force[i] = force[i] + f;
      moment_B[i] = moment_B[i] + cross(body.p_BC, f) +
                    inertia_times(body.R_BC, body.inertia, alpha) +
                    cross(w, inertia_times(body.R_BC, body.inertia, w));
    };
    if (bodies_.size() > size_) add(bodies_[i]);
    if (i + 1 == size_) add(bodies_.back());
  }
  // Inwards: joint i carries what all bodies behind it ask for.
  JointVector torque;
  torque.resize(size_);
  Vec3 f, n_B;
  for (std::size_t i = size_; i-- > 0;) {
    f = f + force[i];
    n_B = n_B + moment_B[i];
    torque[i] = dot(axis_[i], slides_[i] ? f : n_B - cross(origin_[i], f));
  }
  return torque;
}

double PlacedMasses::weight(std::size_t i) const {
  SINEW_ASSERT(i < size_);
  double moment = 0;
  for (std::size_t k = first_body(i); k < bodies_.size(); ++k) {
    moment += bodies_[k].mass * rate_of(i, bodies_[k].p_BC).z;
  }
  return kGravity * moment;
}

double PlacedMasses::inertia(std::size_t i, std::size_t j) const {
  SINEW_ASSERT(i < size_ && j < size_);
  double sum = 0;
  for (std::size_t k = first_body(std::max(i, j)); k < bodies_.size(); ++k) {
    const Body& body = bodies_[k];
    sum += body.mass * dot(rate_of(i, body.p_BC), rate_of(j, body.p_BC)) +
           dot(turn_of(i), inertia_times(body.R_BC, body.inertia, turn_of(j)));
  }
  return sum;
}

double PlacedMasses::potential_energy(double gravity) const {
  double moment = 0;
  for (const Body& body : bodies_) moment += body.mass * body.p_BC.z;
  return gravity * moment;
}

double PlacedMasses::kinetic_energy(std::span<const double> qd) const {
  SINEW_ASSERT(qd.size() == size_);
  double energy = 0;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Body& body = bodies_[k];
    Vec3 v, w;
    for (std::size_t i = 0; i < size_ && first_body(i) <= k; ++i) {
      v = v + qd[i] * rate_of(i, body.p_BC);
      w = w + qd[i] * turn_of(i);
    }
    energy += 0.5 * (body.mass * dot(v, v) + dot(w, inertia_times(body.R_BC, body.inertia, w)));
  }
  return energy;
}

}  // namespace sinew::kinematics
