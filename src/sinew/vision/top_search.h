#pragma once

#include <vector>

#include "sinew/vision/cube_net.h"
#include "sinew/vision/picture.h"

namespace sinew::vision {

/// What looks like a top, with its sides where the picture has edges.
struct Top : LikelyTop {
  int corners = 0;        ///< that are filled, of four
  bool is_print = false;  ///< black and white: rings, a tag, a checker board
};

struct Things {
  std::vector<Top> tops;  ///< the surest first; of those that lie on each other the surest
  std::vector<LikelyOther> others;
};

/// All in it that looks like a top or like something else, px.
Things things_in(const Picture& picture);

}  // namespace sinew::vision
