#pragma once

#include "sinew/core/rotation.h"
#include "sinew/core/vec3.h"

namespace sinew::kinematics {

/// I v of a body whose tensor has the diagonal `inertia` (kg m^2) along the columns of R. @rt
constexpr Vec3 inertia_times(const Rotation& R, const Vec3& inertia, const Vec3& v) {
  const Vec3 v_C = transposed_times(R, v);
  return R * Vec3{inertia.x * v_C.x, inertia.y * v_C.y, inertia.z * v_C.z};
}

}  // namespace sinew::kinematics
