#pragma once

#include <vector>

#include "sinew/vision/cube_net.h"
#include "sinew/vision/picture.h"

namespace sinew::vision {

/// What looks like a top, with its sides where the picture has edges.
struct Top : LikelyTop {
  int corners = 0;  ///< that are filled, of four
};

struct Things {
  std::vector<Top> tops;  ///< the surest first; of those that lie on each other the surest
  std::vector<LikelyOther> others;
};

/// All that looks like a top or like something else, in px of `picture`.
Things things_in(const Picture& picture);

}  // namespace sinew::vision
