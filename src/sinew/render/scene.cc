#include "sinew/render/scene.h"

#include <cmath>

#include "sinew/core/units.h"
#include "sinew/vision/srgb.h"

namespace sinew::render {

Rgb from_srgb(unsigned hex) {
  const auto linear = [&](unsigned shift) { return vision::linear_light()[(hex >> shift) & 255U]; };
  return {linear(16), linear(8), linear(0)};
}

Polyhedron box(const Vec3& half, double bevel) {
  return {{{{1, 0, 0}, half.x},
           {{-1, 0, 0}, half.x},
           {{0, 1, 0}, half.y},
           {{0, -1, 0}, half.y},
           {{0, 0, 1}, half.z},
           {{0, 0, -1}, half.z}},
          norm(half),
          bevel};
}

Polyhedron prism(int sides, double radius, double half_height, double bevel) {
  Polyhedron made{{{{0, 0, 1}, half_height}, {{0, 0, -1}, half_height}},
                  std::hypot(radius, half_height),
                  bevel};
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * kPi * i / sides;
    made.faces.push_back({{std::cos(angle), std::sin(angle), 0}, radius * std::cos(kPi / sides)});
  }
  return made;
}

}  // namespace sinew::render
