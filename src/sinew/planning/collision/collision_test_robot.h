#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string>

#include "sinew/core/units.h"
#include "sinew/planning/collision/collision.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::planning {

inline constexpr std::array kCollisionRobots{"robot-arm-2", "bigrobotarm", "learm",
                                             "maxarm",      "puma560",     "hexapod"};

/// For INSTANTIATE_TEST_SUITE_P.
inline std::string test_name(const testing::TestParamInfo<const char*>& info) {
  std::string name = info.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

inline JointVector degrees(std::initializer_list<double> q_deg) {
  JointVector q;
  for (const double angle : q_deg) q.push_back(from_deg(angle));
  return q;
}

inline JointVector home_of(const RobotModel& model) {
  JointVector q;
  for (const Joint& joint : model.joints) q.push_back(joint.home);
  return q;
}

/// Anywhere inside the limits; of a hexapod, whose legs cannot be anywhere, beside its home.
inline JointVector random_joints(const RobotModel& model, test::Random& random) {
  constexpr double kLegs = 8e-3;  // m
  JointVector q;
  for (const Joint& joint : model.joints) {
    const bool leg = std::holds_alternative<HexapodGeometry>(model.geometry);
    q.push_back(leg ? joint.home + random.uniform(-kLegs, kLegs)
                    : random.uniform(joint.lower, joint.upper));
  }
  return q;
}

/// The same robot worn down to wires and thin plates, which are easily jumped over.
inline RobotModel worn_down(const RobotModel& model, double size) {
  RobotModel thin = model;
  const auto less = [&](double& value) { value = std::min(value, size); };
  for (CollisionShape& shape : thin.collision.shapes) {
    if (auto* capsule = std::get_if<Capsule>(&shape.form)) less(capsule->radius);
    if (auto* box = std::get_if<CollisionBox>(&shape.form)) less(box->half.z);
    if (auto* finger = std::get_if<JawFinger>(&shape.form)) less(finger->half.y);
  }
  return thin;
}

/// A hexapod whose base reaches up to 5 mm below its platform: its legs are nearest at their
/// anchors, whatever they do, but the plates can meet.
inline RobotModel built_up(const RobotModel& model) {
  RobotModel high = model;
  auto& base = std::get<CollisionBox>(high.collision.shapes.front().form);
  base.X_LX.p = {};
  base.half = {0.05, 0.05, 0.253};
  return high;
}

inline JointArray array_of(const JointVector& q) {
  JointArray values{};
  std::ranges::copy(q, values.begin());
  return values;
}

/// Some pieces of every kind, joined in position only: all that a collision check looks at.
inline JointPath random_path(const RobotModel& model, test::Random& random) {
  const std::size_t n = model.joints.size();
  JointPath path(n, 64);
  const auto rates = [&](JointArray& values, double size) {
    for (std::size_t k = 0; k < n; ++k) {
      values[k] = random.uniform(-size, size) * (model.joints[k].upper - model.joints[k].lower);
    }
  };
  JointVector q = random_joints(model, random);
  for (std::int64_t pieces = random.integer(1, 4); pieces > 0; --pieces) {
    const JointVector to = random_joints(model, random);
    const double length = random.uniform(0.05, 0.5);
    const std::int64_t kind = random.integer(0, 2);
    // Legs that swing far out have no pose.
    const double swing = model.joints[0].kind == JointKind::kPrismatic ? 0.02 : 0.5;
    PathPoint a, b;
    a.q = array_of(q);
    b.q = array_of(to);
    rates(a.dq, swing / length);
    rates(b.dq, swing / length);
    if (kind == 0) {
      path.append_line(q, to, length);
    } else if (kind == 1) {
      rates(a.ddq, swing / (length * length));
      rates(b.ddq, swing / (length * length));
      path.append_quintic(a, b, length);
    } else {
      const std::array knots{0.0, 0.4 * length, length};
      const std::array points{a.q, array_of(random_joints(model, random)), b.q};
      path.append_spline(knots, points, a.dq, b.dq);
    }
    q = to;
  }
  return path;
}

}  // namespace sinew::planning
