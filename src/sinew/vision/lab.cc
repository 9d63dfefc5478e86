#include "sinew/vision/lab.h"

#include <algorithm>
#include <array>
#include <cmath>

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

/// The curve of L*a*b* over 0 to 1, in steps that are finer than a byte shows.
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
  std::array<float, 4097> values_{};
};

Plane plane_of(const Picture& picture) {
  return {picture.width, picture.height, std::vector<float>(picture.rgb.size() / 3)};
}

}  // namespace

float distance(const Lab& one, const Lab& other) {
  return std::sqrt((one.L - other.L) * (one.L - other.L) + (one.a - other.a) * (one.a - other.a) +
                   (one.b - other.b) * (one.b - other.b));
}
LabPicture to_lab(const Picture& picture) {
  static const LabCurve curve;
  const auto& linear = linear_of();
  LabPicture lab{plane_of(picture), plane_of(picture), plane_of(picture)};
  for (std::size_t i = 0; i < lab.L.values.size(); ++i) {
    const float r = linear[picture.rgb[3 * i]];
    const float g = linear[picture.rgb[3 * i + 1]];
    const float b = linear[picture.rgb[3 * i + 2]];
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

}  // namespace sinew::vision
