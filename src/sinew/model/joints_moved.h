#pragma once

#include <cstddef>
#include <variant>

#include "sinew/model/robot_model.h"

namespace sinew {

/// How many joints a geometry has.
inline std::size_t joints_moved_by(const Geometry& geometry) {
  if (const auto* serial = std::get_if<SerialGeometry>(&geometry)) return serial->rows.size();
  return std::holds_alternative<HexapodGeometry>(geometry) ? kLegs : 3;
}

}  // namespace sinew
