#pragma once

#include "sinew/core/vec3.h"

namespace sinew::grasping {

/// An upright cube, where a camera has seen it.
struct Cube {
  Vec3 p_BO;        ///< m, the middle of its body in base B
  double yaw = 0;   ///< rad, of its edges about z, mod pi / 2
  double edge = 0;  ///< m
  int color = -1;   ///< whatever whoever made it counts colors by
};

/// Something else on the table: an upright box that it is within.
struct Body {
  Vec3 p_BO;       ///< m, its middle in base B
  double yaw = 0;  ///< rad, of its edges about z
  Vec3 half;       ///< m
};

inline Body body_of(const Cube& cube) {
  const double half = cube.edge / 2;
  return {cube.p_BO, cube.yaw, {half, half, half}};
}

}  // namespace sinew::grasping
