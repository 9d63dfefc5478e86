#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "sinew/vision/color_names.h"
#include "sinew/vision/picture.h"
#include "sinew/vision/white_balance.h"

namespace sinew::vision {

/// What looks like the top face of a cube.
struct LikelyTop {
  Quad quad{};                     ///< px, its corners, clockwise
  double sureness = 0;             ///< 0 to 1
  std::optional<ColorName> color;  ///< nothing: white or grey
};

inline constexpr std::string_view kIsFlat = "it is flat: printed, or a piece of paper";

/// What looks like a thing on the table that is no cube.
struct LikelyOther {
  Pixel middle;          ///< px
  double sureness = 0;   ///< 0 to 1
  std::string_view why;  ///< it is no cube
  bool is_flat = false;  ///< printed, or a piece of paper
};

struct Likely {
  std::vector<LikelyTop> tops;
  std::vector<LikelyOther> others;
};

/// All that is surer than `least`, by a convolutional network that was trained on rendered tables
/// only: tools/cube_net makes its 187 000 weights from nothing. Edges of 9 to 140 px are found.
Likely likely_things(const Picture& picture, const WhiteBalance& balance, double least);

}  // namespace sinew::vision
