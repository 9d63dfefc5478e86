#pragma once

#include <string>
#include <vector>

#include "sinew/vision/color_names.h"
#include "sinew/vision/picture.h"

namespace sinew::vision {

/// A coloured cube, seen from above. Places are px of the picture as it was given.
struct SeenCube {
  ColorName color = ColorName::kRed;
  Quad top{};             ///< corners of its top face, clockwise
  Pixel center;           ///< middle of its top face
  double size = 0;        ///< px, of an edge
  double yaw = 0;         ///< rad, of its edges on the screen, clockwise, 0 to pi/2
  double confidence = 0;  ///< 0 to 1
};

/// Something that looked like one, and why it is none.
struct RefusedShape {
  Quad outline{};
  std::string why;
};

struct Detection {
  std::vector<SeenCube> cubes;  ///< the surest first
  std::vector<RefusedShape> refused;
};

struct DetectionSettings {
  std::vector<ColorName> colors;  ///< these only; empty: all of them
};

/// Finds coloured cubes on a table from above. Nothing is set for a picture: its white is balanced
/// by its pale parts; every lightness, chroma and pair of opponent colours is tried as the border
/// between a cube's top and what is around it; what has four straight sides of one length, one
/// colour inside and another all around, and the size of the others, is a cube. Pure: the same
/// picture has the same answer.
Detection detect_cubes(const Picture& picture, const DetectionSettings& settings = {});

}  // namespace sinew::vision
