#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "sinew/core/split_mix.h"
#include "sinew/render/scene.h"

namespace sinew::render {

struct Ray {
  Vec3 from;    ///< m, in W
  Vec3 toward;  ///< of length 1
};

struct Hit {
  double distance = 0;    ///< m
  Vec3 p_S;               ///< m, in the solid's frame
  Vec3 normal_W;          ///< of length 1, out of the solid
  std::size_t solid = 0;  ///< which of the scene's
  int face = 0;           ///< of a polyhedron; 0 round a cylinder, 1 and 2 its ends
};

/// Light that leaves a surface towards a camera, in the parts that it is made of.
struct Shade {
  Rgb arrives;   ///< light on the surface: noisy where shadows are soft, else it changes slowly
  Rgb color;     ///< share of it that the surface gives back
  Rgb mirrored;  ///< light that it mirrors

  Rgb light() const { return arrives * color + mirrored; }
};

/// Follows rays through a scene, which has to outlive it.
///
/// Direct light of lamps with soft shadows, a lobe of their reflections, light from the room where
/// it is not blocked, and one bounce: what makes real pictures hard. Not physically exact.
class Tracer {
 public:
  explicit Tracer(const Scene& scene);

  /// @param reach  m
  std::optional<Hit> nearest(const Ray& ray,
                             double reach = std::numeric_limits<double>::infinity()) const;
  /// Where a ray meets one solid, whatever stands before it: m, in the solid's frame.
  std::optional<Vec3> crossing_of(std::size_t solid, const Ray& ray) const;
  /// Whether anything stands within `reach` m along the ray.
  bool is_blocked(const Ray& ray, double reach) const;
  /// Light that comes back along a ray from where it hits.
  Shade shade(const Ray& ray, const Hit& hit, SplitMix64& random) const;
  /// Light from where there is nothing.
  Rgb light_of_room(const Vec3& toward) const;

 private:
  /// A solid, or two halves of those that are left.
  struct Node {
    Vec3 low;
    Vec3 high;
    std::uint32_t begin = 0;  ///< in order_
    std::uint32_t end = 0;    ///< 0: the next node, and the one at `begin`
  };
  void build(std::uint32_t begin, std::uint32_t end);
  template <class Visit>
  void visit(const Ray& ray, double& reach, const Visit& visit) const;

  const Scene& scene_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
  std::vector<std::uint32_t> endless_;
};

/// Colour of a solid's surface at a point of it.
Rgb color_at(const Solid& solid, const Vec3& p_S);

}  // namespace sinew::render
