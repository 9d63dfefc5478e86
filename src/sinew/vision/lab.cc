#include "sinew/vision/lab.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sinew::vision {
namespace {

/// sRGB's curve, for each of its bytes.
const std::array<float, 256>& linear_of() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> all{};
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double v = static_cast<double>(i) / 255;
      all[i] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
    }
    return all;
  }();
  return table;
}

/// The curve of L*a*b* over 0 to 1.6, in steps that are finer than a byte shows.
class LabCurve {
 public:
  LabCurve() {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const double t = static_cast<double>(i) / kSteps;
      constexpr double kKnee = 216.0 / 24389;
      values_[i] = static_cast<float>(t > kKnee ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116);
    }
  }
  float operator()(float t) const {
    const auto i = static_cast<std::size_t>(std::max(0.0F, t) * kSteps + 0.5F);
    return values_[std::min(i, values_.size() - 1)];
  }

 private:
  static constexpr float kSteps = 4096;
  std::array<float, 6554> values_{};
};

Plane plane_of(const Picture& picture) {
  return {picture.width, picture.height, std::vector<float>(picture.rgb.size() / 3)};
}

}  // namespace

float distance(const Lab& one, const Lab& other) {
  return std::sqrt((one.L - other.L) * (one.L - other.L) + (one.a - other.a) * (one.a - other.a) +
                   (one.b - other.b) * (one.b - other.b));
}
float chroma(const Lab& colour) {
  return std::hypot(colour.a, colour.b);
}
float hue(const Lab& colour) {
  const float angle = std::atan2(colour.b, colour.a);
  return angle < 0 ? angle + 2 * std::numbers::pi_v<float> : angle;
}

std::array<float, 3> white_balance(const Picture& picture) {
  constexpr float kPale = 0.35F;   // (largest - smallest) / largest, linear
  constexpr float kBurnt = 0.94F;  // a channel that is clipped tells no colour
  constexpr float kDark = 0.03F;
  constexpr double kLeast = 0.01;  // of all pixels
  const auto& linear = linear_of();
  std::array<double, 3> sum{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) {
    const std::array<float, 3> v{linear[picture.rgb[i]], linear[picture.rgb[i + 1]],
                                 linear[picture.rgb[i + 2]]};
    const auto [least, most] = std::ranges::minmax(v);
    if (most > kBurnt || most < kDark || most - least > kPale * most) continue;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += v[c];
    ++count;
  }
  if (static_cast<double>(count) < kLeast * static_cast<double>(picture.rgb.size()) / 3) {
    return {1, 1, 1};
  }
  const double grey = (sum[0] + sum[1] + sum[2]) / 3;
  std::array<float, 3> gains{};
  for (std::size_t c = 0; c < 3; ++c) {
    gains[c] = static_cast<float>(std::clamp(grey / sum[c], 0.6, 1.6));
  }
  return gains;
}

LabPicture to_lab(const Picture& picture, const std::array<float, 3>& gains) {
  static const LabCurve curve;
  const auto& linear = linear_of();
  LabPicture lab{plane_of(picture), plane_of(picture), plane_of(picture)};
  for (std::size_t i = 0; i < lab.L.values.size(); ++i) {
    const float r = std::min(1.0F, gains[0] * linear[picture.rgb[3 * i]]);
    const float g = std::min(1.0F, gains[1] * linear[picture.rgb[3 * i + 1]]);
    const float b = std::min(1.0F, gains[2] * linear[picture.rgb[3 * i + 2]]);
    // sRGB to XYZ over the white of D65 (IEC 61966-2-1).
    const float x = curve((0.4124F * r + 0.3576F * g + 0.1805F * b) / 0.9505F);
    const float y = curve(0.2126F * r + 0.7152F * g + 0.0722F * b);
    const float z = curve((0.0193F * r + 0.1192F * g + 0.9505F * b) / 1.0890F);
    lab.L.values[i] = 116 * y - 16;
    lab.a.values[i] = 500 * (x - y);
    lab.b.values[i] = 200 * (y - z);
  }
  return lab;
}

Plane smoothed(const Plane& plane) {
  constexpr std::array<float, 3> kBell{0.44F, 0.24F, 0.04F};
  Plane across = plane;
  Plane out = plane;
  const auto blur = [&](const Plane& from, Plane& to, int dx, int dy) {
    for (int y = 0; y < plane.height; ++y) {
      for (int x = 0; x < plane.width; ++x) {
        float sum = kBell[0] * from.at(x, y);
        for (int k = 1; k <= 2; ++k) {
          const auto neighbour = [&](int sign) {
            return from.at(std::clamp(x + sign * k * dx, 0, plane.width - 1),
                           std::clamp(y + sign * k * dy, 0, plane.height - 1));
          };
          sum += kBell[static_cast<std::size_t>(k)] * (neighbour(-1) + neighbour(1));
        }
        to.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(plane.width) +
                  static_cast<std::size_t>(x)] = sum;
      }
    }
  };
  blur(plane, across, 1, 0);
  blur(across, out, 0, 1);
  return out;
}

}  // namespace sinew::vision
