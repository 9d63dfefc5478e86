#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sinew/render/scene.h"

namespace sinew::render {

inline constexpr std::uint16_t kNoSolid = 0xFFFF;

/// Light on a camera's pixels, and what each of them shows.
struct View {
  int width = 0;
  int height = 0;
  std::vector<Rgb> light;             ///< row by row
  std::vector<std::uint16_t> solids;  ///< seen in the middle of each pixel; kNoSolid: nothing
  std::vector<bool> upward;           ///< whether that surface faces up, within 45 deg
};

/// A scene as a camera sees it. The same seed gives the same picture.
/// @param X_WC  of the camera: z out of the lens, y down the picture
View view_of(const Scene& scene, const vision::CameraModel& camera,
             const Pose<frame::World, frame::Camera>& X_WC, std::uint64_t seed);

/// X_WC of a camera at `eye` that looks at `target`, with the horizon level; straight down the top
/// of the picture is towards +y. m, in W
Pose<frame::World, frame::Camera> looking_at(const Vec3& eye, const Vec3& target);

/// How a sensor turns light into bytes.
struct Sensor {
  double exposure = 1;     ///< light that is white: 1 / exposure
  double blur = 0.6;       ///< px, of the lens
  double noise = 0.005;    ///< of white, where it is dark
  double grain = 0.01;     ///< of white, where it is white; as the root of light in between
  double vignette = 0.15;  ///< share of light that the corners lack
  Rgb balance{1, 1, 1};    ///< gains of the white balance
  double saturation = 1;   ///< of colours, in the camera's own processing
  double contrast = 0;     ///< 0: sRGB; 1: an S through it, as cameras like it
  int jpeg = 0;            ///< quality of its compression, 1 to 100; 0: none
  double shutter = 0;      ///< s, that each row is exposed; for picture_of() alone
  double read_out = 0;     ///< s, from the first row to the last; likewise
};

vision::Picture taken(const View& view, const Sensor& sensor, std::uint64_t seed);

/// One picture of things that move: each row is the mean of the views within its own exposure.
/// @param views  at even times over exposure and read-out, of one size, at least one
/// @param exposure  share of that time, 0 to 1; the rest passes from the first row to the last
View rolling_shutter(std::span<const View> views, double exposure);

}  // namespace sinew::render
