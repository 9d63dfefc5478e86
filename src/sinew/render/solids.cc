#include "sinew/render/solids.h"

#include <cmath>

namespace sinew::render {

Pose<frame::World, frame::Solid> upright(double x, double y, double z, double turn) {
  return {rotation_z(turn), {x, y, z}};
}

Pose<frame::World, frame::Solid> along(const Vec3& from, const Vec3& to) {
  const Vec3 z = normalized(to - from);
  const Vec3 x =
      normalized(std::abs(z.z) < 0.9 ? cross(Vec3{0, 0, 1}, z) : cross(Vec3{1, 0, 0}, z));
  return {{x, cross(z, x), z}, 0.5 * (from + to)};
}

void add_rod(Scene& scene, const Vec3& from, const Vec3& to, double radius,
             const Material& material) {
  const double length = norm(to - from);
  if (length > 0) {
    scene.solids.push_back({Cylinder{radius, length / 2}, along(from, to), material});
    scene.solids.push_back({Ball{radius}, {Rotation{}, from}, material});
  }
  scene.solids.push_back({Ball{radius}, {Rotation{}, to}, material});
}

}  // namespace sinew::render
