#include "sinew/planning/collision/collision_reach.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/fixed_vector.h"

namespace sinew::planning {
namespace {

/// The corners of a shape in its link's frame, and what is around them.
struct Hull {
  FixedVector<Vec3, 8> corners;
  double radius = 0;
};

Hull hull_of(const CollisionShape& shape) {
  Hull hull;
  if (const auto* capsule = std::get_if<Capsule>(&shape.form)) {
    hull.corners = {capsule->p_LA, capsule->p_LB};
    hull.radius = capsule->radius;
  } else if (const auto* box = std::get_if<CollisionBox>(&shape.form)) {
    for (unsigned signs = 0; signs < 8; ++signs) {
      const auto side = [&](unsigned axis, double half) {
        return (signs >> axis & 1U) != 0 ? half : -half;
      };
      hull.corners.push_back(
          box->X_LX * Vec3{side(0, box->half.x), side(1, box->half.y), side(2, box->half.z)});
    }
  }
  return hull;
}

/// Farthest that the shape reaches, by a distance that grows outwards.
template <class Distance>
double farthest(const Hull& hull, Distance&& distance) {
  double far = 0;
  for (const Vec3& p : hull.corners) far = std::max(far, distance(p));
  return far + hull.radius;
}
double farthest_from(const Hull& hull, const Vec3& point) {
  return farthest(hull, [&](const Vec3& p) { return norm(p - point); });
}
double farthest_from_z(const Hull& hull) {
  return farthest(hull, [](const Vec3& p) { return std::hypot(p.x, p.y); });
}
double farthest_from_x(const Hull& hull) {
  return farthest(hull, [](const Vec3& p) { return std::hypot(p.y, p.z); });
}

/// A chain with its limits; links and joints counted from 1.
struct Chain {
  const SerialGeometry& geometry;
  std::span<const Joint> joints;

  const DhRow& row(std::size_t m) const { return geometry.rows[m - 1]; }
  bool slides(std::size_t m) const { return row(m).kind == JointKind::kPrismatic; }
  /// The least and the largest d of a row.
  std::array<double, 2> d(std::size_t m) const {
    const double d = row(m).d;
    if (!slides(m)) return {d, d};
    return {d + joints[m - 1].lower, d + joints[m - 1].upper};
  }
  double length(std::size_t m) const {
    const auto [least, largest] = d(m);
    return std::hypot(std::max(std::abs(least), std::abs(largest)), row(m).a);
  }
};

/// m per m, and a hair for rounding: motions are walked until the bound is used up.
constexpr double kSlide = 1 + 1e-9;

/// How far joint k moves a shape that it carries, on link j >= k, per rad or m: its lever arm,
/// or 1.
double outer_reach(const Chain& chain, const Hull& hull, std::size_t k, std::size_t j) {
  if (chain.slides(k)) return kSlide;
  const DhRow& row = chain.row(j);
  const double sin_alpha = std::sin(row.alpha), cos_alpha = std::cos(row.alpha);
  if (k == j) {
    // Its axis stands still in the link's own frame.
    const Vec3 axis{0, sin_alpha, cos_alpha};
    return farthest(hull, [&](const Vec3& p) { return norm(cross(p + Vec3{row.a, 0, 0}, axis)); });
  }
  double sum = 0;
  for (const double d : chain.d(j)) {
    const Vec3 origin_before{-row.a, -d * sin_alpha, -d * cos_alpha};
    sum = std::max(sum, std::abs(chain.row(k).a) + farthest_from(hull, origin_before));
  }
  for (std::size_t m = k + 1; m < j; ++m) sum += chain.length(m);
  return sum;
}

/// The same of a shape before it, on link i < k.
double inner_reach(const Chain& chain, const Hull& hull, std::size_t k, std::size_t i) {
  if (chain.slides(k)) return kSlide;
  if (k == i + 1) return farthest_from_z(hull);
  double sum = farthest_from(hull, {});
  for (std::size_t m = i + 1; m < k; ++m) sum += chain.length(m);
  return sum;
}

JointReach serial_reach(const Chain& chain, const CollisionShape& first,
                        const CollisionShape* second) {
  JointReach reach{};
  if (second == nullptr) {
    // What turns about the table's normal comes no nearer to it: the first joint, and all of a
    // SCARA.
    bool upright = true;
    for (std::size_t k = 1; k <= first.link; ++k) {
      if (!upright || chain.slides(k)) {
        reach[k - 1] = outer_reach(chain, hull_of(first), k, first.link);
      }
      upright = upright && std::abs(std::sin(chain.row(k).alpha)) < 1e-12;
    }
    return reach;
  }
  const bool ordered = first.link < second->link;
  const CollisionShape& inner = ordered ? first : *second;
  const CollisionShape& outer = ordered ? *second : first;
  for (std::size_t k = inner.link + 1U; k <= outer.link; ++k) {
    reach[k - 1] = std::min(inner_reach(chain, hull_of(inner), k, inner.link),
                            outer_reach(chain, hull_of(outer), k, outer.link));
  }
  return reach;
}

constexpr std::size_t kColumn = 1, kUpperArm = 2, kForearm = 3;

/// How a shape moves against the column that carries it, and against the stand. One reach per
/// joint.
JointReach palletizer_own(const PalletizerGeometry& geometry, const CollisionShape& shape) {
  const Hull hull = hull_of(shape);
  const std::size_t link = shape.link;
  JointReach own{};
  if (link == 0) return own;
  double to_axis = std::abs(geometry.shoulder_offset);
  if (link > kUpperArm) to_axis += geometry.upper_arm;
  if (link > kForearm) to_axis += geometry.forearm + std::abs(geometry.tool_offset);
  own[0] = link == kColumn ? farthest_from_z(hull) : to_axis + farthest_from(hull, {});
  if (link == kUpperArm) own[1] = farthest_from_x(hull);
  if (link > kUpperArm) own[1] = geometry.upper_arm;
  if (link == kForearm) own[2] = farthest_from_x(hull);
  if (link > kForearm) own[2] = geometry.forearm;
  return own;
}

JointReach palletizer_reach(const PalletizerGeometry& geometry, const CollisionShape& first,
                            const CollisionShape* second) {
  JointReach reach = palletizer_own(geometry, first);
  if (second == nullptr) {
    reach[0] = 0;
    return reach;
  }
  const JointReach other = palletizer_own(geometry, *second);
  for (std::size_t k = 1; k < reach.size(); ++k) reach[k] += other[k];
  // The base carries everything but the stand.
  if (first.link == 0) reach[0] = std::min(other[0], farthest_from_z(hull_of(first)));
  if (second->link == 0) reach[0] = std::min(reach[0], farthest_from_z(hull_of(*second)));
  if (first.link != 0 && second->link != 0) reach[0] = 0;
  return reach;
}

/// m that a shape moves at most per m of the legs' norm. With rotations scaled by the platform's
/// radius the Jacobian's largest singular value is at least 1 (its rows are longer than that), so
/// the smallest is at least 1 / condition_max.
double hexapod_own(const HexapodGeometry& geometry, const CollisionShape& shape) {
  if (shape.link == 0) return 0;
  const double lever = shape.link <= kLegs ? norm(geometry.p_PA[shape.link - 1U])
                                           : farthest_from(hull_of(shape), {});
  return geometry.condition_max * std::hypot(1, lever / geometry.platform_radius);
}

}  // namespace

JointReach joint_reach(const RobotModel& model, const CollisionShape& first,
                       const CollisionShape* second) {
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    return serial_reach({*serial, model.joints}, first, second);
  }
  if (const auto* palletizer = std::get_if<PalletizerGeometry>(&model.geometry)) {
    return palletizer_reach(*palletizer, first, second);
  }
  const auto& hexapod = std::get<HexapodGeometry>(model.geometry);
  JointReach reach{};
  reach[0] = hexapod_own(hexapod, first);
  if (second != nullptr) reach[0] += hexapod_own(hexapod, *second);
  return reach;
}

JointReach own_reach(const RobotModel& model, const CollisionShape& shape) {
  JointReach reach{};
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    for (std::size_t k = 1; k <= shape.link; ++k) {
      reach[k - 1] = outer_reach({*serial, model.joints}, hull_of(shape), k, shape.link);
    }
    return reach;
  }
  if (const auto* palletizer = std::get_if<PalletizerGeometry>(&model.geometry)) {
    return palletizer_own(*palletizer, shape);
  }
  reach[0] = hexapod_own(std::get<HexapodGeometry>(model.geometry), shape);
  return reach;
}

Capsule reach_ball(const RobotModel& model, const CollisionShape& shape) {
  const Hull hull = hull_of(shape);
  Vec3 centre;
  double radius = farthest_from(hull, {});
  if (const auto* serial = std::get_if<SerialGeometry>(&model.geometry)) {
    const Chain chain{*serial, model.joints};
    const auto [least, largest] = chain.d(1);
    centre.z = (least + largest) / 2;
    radius += std::abs(serial->rows[0].a) + (largest - least) / 2;
    for (std::size_t m = 2; m <= shape.link; ++m) radius += chain.length(m);
  } else if (const auto* palletizer = std::get_if<PalletizerGeometry>(&model.geometry)) {
    centre.z = palletizer->base_height;
    radius += std::abs(palletizer->shoulder_offset);
    if (shape.link > kUpperArm) radius += palletizer->upper_arm;
    if (shape.link > kForearm) radius += palletizer->forearm + std::abs(palletizer->tool_offset);
    if (shape.link == kColumn) radius += palletizer->base_height;
  } else {
    const auto& hexapod = std::get<HexapodGeometry>(model.geometry);
    double far = 0, back = 0;
    for (std::size_t leg = 0; leg < kLegs; ++leg) {
      far = std::max(far, norm(hexapod.p_BA[leg]) + model.joints[leg].upper);
      back = std::max(back, norm(hexapod.p_PA[leg]));
    }
    if (const auto* leg = std::get_if<LegCapsule>(&shape.form)) {
      radius = far + leg->radius;
    } else {
      radius += far + back;
    }
  }
  return {centre, centre, radius};
}

}  // namespace sinew::planning
