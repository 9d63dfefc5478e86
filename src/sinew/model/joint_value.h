#pragma once

#include <cstddef>

#include "sinew/core/error.h"
#include "sinew/core/quantity.h"
#include "sinew/core/units.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// A joint's value, or a derivative of it, as people see it: mm of one that slides, else deg.
inline double shown_value(double value, const Joint& joint) {
  return joint.slides() ? to_mm(value) : to_deg(value);
}
inline const char* shown_unit(const Joint& joint) {
  return joint.slides() ? "mm" : "deg";
}
/// Of a value that people write.
inline Measure measure_of(const Joint& joint) {
  return joint.slides() ? Measure::kLength : Measure::kAngle;
}

/// A value that is not allowed, and the limit that it passes.
Error beyond_limit(const Joint& joint, std::size_t index, double q, double limit);
/// The same of the nearer limit. Only for values outside.
Error beyond_limit(const Joint& joint, std::size_t index, double q);

}  // namespace sinew
