#pragma once

#include <cstddef>
#include <memory>
#include <variant>
#include <vector>

#include "sinew/core/pose.h"
#include "sinew/vision/camera_model.h"

namespace sinew::frame {
struct Solid;  ///< of one solid of a scene
}

namespace sinew::render {

/// Light, or the share of it that a surface gives back: red, green, blue, linear.
struct Rgb {
  float r = 0;
  float g = 0;
  float b = 0;

  friend constexpr Rgb operator+(Rgb p, Rgb q) { return {p.r + q.r, p.g + q.g, p.b + q.b}; }
  friend constexpr Rgb operator*(Rgb p, Rgb q) { return {p.r * q.r, p.g * q.g, p.b * q.b}; }
  friend constexpr Rgb operator*(float k, Rgb p) { return {k * p.r, k * p.g, k * p.b}; }
};

/// What an sRGB colour gives back of white light. @param hex  0xRRGGBB
Rgb from_srgb(unsigned hex);

/// A picture on a surface: it multiplies the surface's colour, and repeats itself unless it is
/// `single`.
struct Print {
  std::shared_ptr<const vision::Picture> picture;
  double width = 0.1;   ///< m, of the picture on the surface
  double height = 0.1;  ///< m
  bool single = false;  ///< once, in the middle; the plain colour around it
};

struct Material {
  Rgb color{0.8F, 0.8F, 0.8F};
  float gloss = 0.03F;      ///< of the light that comes straight from above, 0 to 1
  float roughness = 0.35F;  ///< width of a lamp's reflection, about rad
  Print print = {};
};

/// Points of the solid's frame S with normal . p <= distance for all faces, at most 1.5 `radius`
/// from its origin. Boxes, prisms and wedges.
struct Polyhedron {
  struct Face {
    Vec3 normal;          ///< of length 1, out of the solid
    double distance = 0;  ///< m
  };
  std::vector<Face> faces;
  double radius = 0;  ///< m, of a ball around the origin that holds it
  double bevel = 0;   ///< m, up to which edges look rounded; the outline stays sharp
};
/// Around the z axis of S, from -half to half.
struct Cylinder {
  double radius = 0;  ///< m
  double half = 0;    ///< m
};
struct Ball {
  double radius = 0;  ///< m
};
/// z <= 0 of S, all of it. Once in a scene is enough.
struct Ground {};

struct Solid {
  std::variant<Polyhedron, Cylinder, Ball, Ground> form;
  Pose<frame::World, frame::Solid> X_WS;
  Material material;
};

Polyhedron box(const Vec3& half, double bevel = 0);
/// An upright prism with `sides` equal sides. @param radius  m, of its corners
Polyhedron prism(int sides, double radius, double half_height, double bevel = 0);

/// Light from a ball in the room.
struct Lamp {
  Vec3 p_W;           ///< m
  double radius = 0;  ///< m; the larger the softer its shadows
  Rgb power;          ///< on a surface that faces it 1 m away
};

/// What stands in front of a camera, and how it is lit.
struct Scene {
  std::vector<Solid> solids;
  std::vector<Lamp> lamps;
  Rgb above{0.3F, 0.3F, 0.3F};  ///< light from all of the room above, and what mirrors show
  Rgb below{0.1F, 0.1F, 0.1F};  ///< and below the horizon
};

}  // namespace sinew::render
