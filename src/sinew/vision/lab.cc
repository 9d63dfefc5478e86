#include "sinew/vision/lab.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/vision/srgb.h"

namespace sinew::vision {
namespace {

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

/// sRGB to XYZ over the white of D65, and on.
Lab lab_of(const std::uint8_t* rgb) {
  static const LabCurve curve;
  const auto& linear = linear_light();
  const float r = linear[rgb[0]];
  const float g = linear[rgb[1]];
  const float b = linear[rgb[2]];
  const float x = curve((0.4124F * r + 0.3576F * g + 0.1805F * b) / 0.9505F);
  const float y = curve(0.2126F * r + 0.7152F * g + 0.0722F * b);
  const float z = curve((0.0193F * r + 0.1192F * g + 0.9505F * b) / 1.0890F);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

}  // namespace

float distance(const Lab& one, const Lab& other) {
  return std::sqrt((one.L - other.L) * (one.L - other.L) + (one.a - other.a) * (one.a - other.a) +
                   (one.b - other.b) * (one.b - other.b));
}

LabPicture::LabPicture(const Picture& picture)
    : picture_(picture),
      across_((picture.width + kTile - 1) / kTile),
      is_filled_(tile_at(0, (picture.height + kTile - 1) / kTile)),
      values_(picture.rgb.size()) {}

void LabPicture::fill(int i, int j) const {
  for (int y = j * kTile; y < std::min((j + 1) * kTile, picture_.height); ++y) {
    for (int x = i * kTile; x < std::min((i + 1) * kTile, picture_.width); ++x) {
      const Lab lab = lab_of(picture_.at(x, y));
      std::ranges::copy(std::array{lab.L, lab.a, lab.b}, &values_[3 * pixel_at(x, y)]);
    }
  }
  is_filled_[tile_at(i, j)] = 1;
}

}  // namespace sinew::vision
