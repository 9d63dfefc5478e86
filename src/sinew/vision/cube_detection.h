#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sinew/core/vec3.h"
#include "sinew/vision/color_names.h"
#include "sinew/vision/picture.h"

namespace sinew::vision {

/// A seen cube in the world.
struct CubePosition {
  Vec3 top_W;       ///< m, middle of its top face
  double yaw = 0;   ///< rad, of its edges about z of W, 0 to pi/2
  double edge = 0;  ///< m, of its top, measured
  int level = 1;    ///< 1: it stands on the table; 2: on one cube, and so on
};

/// A coloured cube, seen from above. Places are px of the picture as it was given.
struct SeenCube {
  ColorName color = ColorName::kRed;
  Quad top{};                            ///< corners of its top face, clockwise
  Pixel center;                          ///< middle of its top face
  double size = 0;                       ///< px, of an edge
  double yaw = 0;                        ///< rad, of its edges on the screen, clockwise, 0 to pi/2
  double confidence = 0;                 ///< 0 to 1
  std::optional<CubePosition> position;  ///< with a camera: vision/table_camera.h
};

/// Pose of an object that is no cube: an upright box on the table.
struct ThingPosition {
  Vec3 top_W;                     ///< m, middle of its top face
  double yaw = 0;                 ///< rad, of its edges about z of W, 0 to pi/2
  double half_x = 0, half_y = 0;  ///< m, of its turned edges
};

/// Estimated height of an object.
enum class Height : std::uint8_t {
  kFlat,
  kPerhaps,  ///< unknown: a brick, a disc, or a false detection
  kLikely,   ///< of a cube: a white or uncertain one
};

/// Something that looked like one, and why it is none.
struct RefusedShape {
  Quad outline{};
  std::string why;
  Height height = Height::kFlat;
  /// With a calibrated camera, unless it is flat: vision/table_camera.h.
  std::optional<ThingPosition> position{};
  /// The cube that it may be: its sides on a calibrated table decide.
  std::optional<SeenCube> cube{};
  bool has_color = true;  ///< else that cube's color says nothing: its top is white or grey
  bool is_sure = false;   ///< that it is a cube: only its color is why it is refused
};

struct Detection {
  std::vector<SeenCube> cubes;  ///< the surest first; behind them those that sides decided
  std::vector<RefusedShape> refused;
};

struct DetectionSettings {
  std::vector<ColorName> colors;  ///< these only; empty: all of them
};

/// Finds coloured cubes on a table. Nothing is set for a picture: a network that was trained on
/// rendered tables says where tops are and what else there is (vision/cube_net.h), the picture's
/// edges say exactly where a top's sides are, and what has another size than the others is refused.
/// Pure: the same picture has the same answer.
Detection detect_cubes(const Picture& picture, const DetectionSettings& settings = {});

}  // namespace sinew::vision
