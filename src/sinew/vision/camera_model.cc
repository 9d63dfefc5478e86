#include "sinew/vision/camera_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew::vision {
namespace {

/// Of a point on the plane z = 1, and how the radius grows there.
struct Bent {
  Pixel p;
  double growth = 0;  ///< d(bent radius) / d(radius), of the radial part
};

Bent bend(const std::array<double, 5>& lens, Pixel p) {
  const auto& [k1, k2, p1, p2, k3] = lens;
  const double r2 = dot(p, p);
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {{p.x * radial + 2 * p1 * p.x * p.y + p2 * (r2 + 2 * p.x * p.x),
           p.y * radial + p1 * (r2 + 2 * p.y * p.y) + 2 * p2 * p.x * p.y},
          1 + r2 * (3 * k1 + r2 * (5 * k2 + r2 * 7 * k3))};
}

}  // namespace

std::optional<Pixel> CameraModel::project(const Vec3& p_CQ) const {
  constexpr double kNearest = 1e-6;  // m
  if (p_CQ.z < kNearest) return std::nullopt;
  const Bent bent = bend(lens, {p_CQ.x / p_CQ.z, p_CQ.y / p_CQ.z});
  if (bent.growth <= 0) return std::nullopt;
  return Pixel{center.x + fx * bent.p.x, center.y + fy * bent.p.y};
}

Vec3 CameraModel::direction(Pixel p) const {
  const Pixel wanted{(p.x - center.x) / fx, (p.y - center.y) / fy};
  // Newton's method with the slope of the radial part; the tangential one is small. Where the lens
  // model folds back before it gets there, the nearest that was found.
  Pixel straight = wanted;
  Pixel best = wanted;
  double least = std::numeric_limits<double>::infinity();
  constexpr int kRounds = 30;
  for (int round = 0; round < kRounds && least > 1e-24; ++round) {
    const Bent bent = bend(lens, straight);
    const Pixel off = wanted - bent.p;
    const double squared = off.x * off.x + off.y * off.y;
    if (!(squared < 4 * least)) break;
    if (squared < least) {
      least = squared;
      best = straight;
    }
    straight = straight + (1 / std::max(bent.growth, 0.3)) * off;
  }
  return normalized({best.x, best.y, 1});
}

CameraModel CameraModel::shrunk(int longest) const {
  CameraModel small = *this;
  const double scale = 1.0 * longest / std::max(width, height);
  small.width = std::max(1, static_cast<int>(std::lround(width * scale)));
  small.height = std::max(1, static_cast<int>(std::lround(height * scale)));
  small.fx *= scale;
  small.fy *= scale;
  small.center = scale * center;
  return small;
}

CameraModel pinhole(int width, int height, double view_rad) {
  const double f = width / 2.0 / std::tan(view_rad / 2);
  return {width, height, f, f, {width / 2.0, height / 2.0}, {}};
}

}  // namespace sinew::vision
