#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "sinew/vision/lab.h"

namespace sinew::vision {

/// What hangs together of a plane on one side of a threshold.
struct Region {
  double area = 0;           ///< px^2
  std::vector<Pixel> edges;  ///< corners of the first and last pixels of its runs; by y, then x
};

/// Bounds for what is worth a look; a region that reaches the border of the picture never is.
struct RegionLimits {
  double area_min = 0;        ///< px^2
  double area_max = 0;        ///< px^2
  double elongation_max = 1;  ///< of the upright box around it
};

enum class Side : std::uint8_t { kAbove, kBelow };

/// The regions of pixels whose value is above a threshold, or not above it; pixels hang together
/// along their sides.
void for_each_region(const Plane& plane, float threshold, Side side, const RegionLimits& limits,
                     const std::function<void(const Region&)>& look);

}  // namespace sinew::vision
