#include "sinew/vision/side_color.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"

namespace sinew::vision {
namespace {

/// The middle of a side face, and where it looks.
struct Face {
  Vec3 middle_W;
  Vec3 out;    ///< horizontal, unit
  Vec3 aside;  ///< along the face, horizontal, unit
};

Face face_of(const CubePosition& cube, double edge, int side) {
  const double turn = cube.yaw + side * kPi / 2;
  const Vec3 out{std::cos(turn), std::sin(turn), 0};
  return {cube.top_W + edge / 2 * out - Vec3{0, 0, edge / 2}, out, {-out.y, out.x, 0}};
}

/// Whether another cube stands so near before it that it hides it.
bool is_hidden(const Face& face, double edge, std::span<const SeenCube> cubes) {
  constexpr double kNear = 1.2;  // edges
  const Vec3 before = face.middle_W + edge / 2 * face.out;
  return std::ranges::any_of(cubes, [&](const SeenCube& other) {
    if (!other.position) return false;
    const Vec3 between = other.position->top_W - before;
    return std::hypot(between.x, between.y) < kNear * edge;
  });
}

/// Mean of the inner part of a face, white balanced bytes; nothing where it is not in the picture.
std::optional<std::array<double, 3>> color_on(const Picture& picture, const WhiteBalance& balance,
                                              const TableCamera& camera, const Face& face,
                                              double edge) {
  std::array<double, 3> sum{};
  int count = 0;
  for (const double u : {-0.3, -0.15, 0.0, 0.15, 0.3}) {
    for (const double up : {-0.1, 0.0, 0.1}) {
      const Vec3 p_W = face.middle_W + u * edge * face.aside + Vec3{0, 0, up * edge};
      const auto p = camera.model.project(camera.X_WC.inverse() * p_W);
      if (!p || p->x < 0 || p->y < 0 || p->x >= picture.width || p->y >= picture.height) {
        return std::nullopt;
      }
      const std::uint8_t* rgb = picture.at(static_cast<int>(p->x), static_cast<int>(p->y));
      for (std::size_t c = 0; c < 3; ++c) sum[c] += balance.curve(c)[rgb[c]];
      ++count;
    }
  }
  for (double& value : sum) value /= count;
  return sum;
}

}  // namespace

std::optional<ColorName> name_by_hue(const std::array<double, 3>& rgb) {
  constexpr double kBlack = 75;        // of 255, the brightest channel
  constexpr double kBlackest = 25;     // the same, where noise alone gives hues
  constexpr double kSaturation = 0.3;  // from here on it has a color
  constexpr double kPale = 0.6;        // red of less is pink
  const double most = std::ranges::max(rgb), least = std::ranges::min(rgb);
  const double saturation = (most - least) / std::max(most, 1.0);
  // What has a color has one in the shadow, too.
  if (most < kBlackest || (most < kBlack && saturation < kPale)) return ColorName::kBlack;
  if (saturation < kSaturation) return std::nullopt;
  const auto [r, g, b] = rgb;
  const double span = most - least;
  double hue = most == r   ? 60 * (g - b) / span
               : most == g ? 120 + 60 * (b - r) / span
                           : 240 + 60 * (r - g) / span;
  if (hue < 0) hue += 360;
  constexpr double kRedTo = 12, kOrangeTo = 40, kYellowTo = 70, kGreenTo = 170, kBlueTo = 255,
                   kPurpleTo = 290, kPinkTo = 330;  // deg
  if (hue < kRedTo || hue >= kPinkTo)
    return saturation < kPale ? ColorName::kPink : ColorName::kRed;
  if (hue < kOrangeTo) return ColorName::kOrange;
  if (hue < kYellowTo) return ColorName::kYellow;
  if (hue < kGreenTo) return ColorName::kGreen;
  if (hue < kBlueTo) return ColorName::kBlue;
  return hue < kPurpleTo ? ColorName::kPurple : ColorName::kPink;
}

std::optional<ColorName> side_color(const Picture& picture, const WhiteBalance& balance,
                                    const TableCamera& camera, const CubePosition& cube,
                                    double edge, std::span<const SeenCube> cubes) {
  constexpr double kSlant =
      0.08;  // sine: of what is seen more from the side pixels show too little
  std::optional<ColorName> color;
  double best = kSlant;
  for (int side = 0; side < 4; ++side) {
    const Face face = face_of(cube, edge, side);
    const Vec3 to_camera = camera.X_WC.p - face.middle_W;
    const double slant = dot(face.out, to_camera) / norm(to_camera);
    if (slant <= best || is_hidden(face, edge, cubes)) continue;
    const auto rgb = color_on(picture, balance, camera, face, edge);
    if (!rgb) continue;
    best = slant;
    color = name_by_hue(*rgb);
  }
  return color;
}

}  // namespace sinew::vision
