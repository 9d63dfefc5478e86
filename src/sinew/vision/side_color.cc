#include "sinew/vision/side_color.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"
#include "sinew/vision/view_watch.h"

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

/// Whether something as high as the cube is on the way from the face's middle to the camera.
bool is_hidden(const Face& face, double edge, const Vec3& to_camera, std::span<const Vec3> others) {
  constexpr double kNear = 0.75;  // edges, from its middle: between its sides and its corners
  for (const double up : {0.1, 0.25, 0.4, 0.5}) {
    const Vec3 p_W = face.middle_W + up * edge / to_camera.z * to_camera;
    const bool meets = std::ranges::any_of(others, [&](const Vec3& top_W) {
      return std::hypot(top_W.x - p_W.x, top_W.y - p_W.y) < kNear * edge;
    });
    if (meets) return true;
  }
  return false;
}

/// Mean of the inner part of a face, white balanced bytes; nothing where the picture does not show
/// it.
std::optional<std::array<double, 3>> color_on(const Picture& picture, const WhiteBalance& balance,
                                              const TableCamera& camera, const Face& face,
                                              double edge, const std::vector<bool>& hidden) {
  const CellGrid grid = grid_of(picture.width, picture.height);
  std::array<double, 3> sum{};
  int count = 0;
  for (const double u : {-0.3, -0.15, 0.0, 0.15, 0.3}) {
    for (const double up : {-0.1, 0.0, 0.1}) {
      const Vec3 p_W = face.middle_W + u * edge * face.aside + Vec3{0, 0, up * edge};
      const auto p = camera.model.project(camera.X_WC.inverse() * p_W);
      const auto cell = p ? cell_of(grid, picture.width, picture.height, *p) : std::nullopt;
      if (!cell || (!hidden.empty() && hidden[*cell])) return std::nullopt;
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
  // Of 255, the brightest channel: the shaded side of grey is brighter.
  constexpr double kBlack = 60;
  constexpr double kBlackest = 25;      // the same, where noise alone gives hues
  constexpr double kSaturation = 0.22;  // from here on it has a color
  constexpr double kStrong = 0.5;       // that of plain wood is less
  constexpr double kPale = 0.6;         // red of less is pink
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
  if (hue < kOrangeTo) return saturation < kStrong ? ColorName::kWood : ColorName::kOrange;
  if (hue < kYellowTo) return ColorName::kYellow;
  if (hue < kGreenTo) return ColorName::kGreen;
  if (hue < kBlueTo) return ColorName::kBlue;
  return hue < kPurpleTo ? ColorName::kPurple : ColorName::kPink;
}

std::optional<ColorName> side_color(const Picture& picture, const WhiteBalance& balance,
                                    const TableCamera& camera, const CubePosition& cube,
                                    double edge, std::span<const Vec3> others,
                                    const std::vector<bool>& hidden) {
  // Sine: of what is seen more from the side pixels show too little.
  constexpr double kSlant = 0.08;
  std::optional<ColorName> color;
  double best = kSlant;
  for (int side = 0; side < 4; ++side) {
    const Face face = face_of(cube, edge, side);
    const Vec3 to_camera = camera.X_WC.p - face.middle_W;
    const double slant = dot(face.out, to_camera) / norm(to_camera);
    if (slant <= best || is_hidden(face, edge, to_camera, others)) continue;
    const auto rgb = color_on(picture, balance, camera, face, edge, hidden);
    if (!rgb) continue;
    best = slant;
    color = name_by_hue(*rgb);
  }
  return color;
}

}  // namespace sinew::vision
