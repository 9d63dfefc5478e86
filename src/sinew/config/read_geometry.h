#pragma once

#include <optional>

#include "sinew/model/robot_model.h"
#include "sinew/toml/table_reader.h"

namespace sinew {

enum class GeometryKind : std::uint8_t { kSerial, kPalletizer, kHexapod };

/// Reads [geometry], and [tool] and [gripper] where the kind has them.
/// @return  the kind if it could be read: without it nothing else of the file can be judged.
std::optional<GeometryKind> read_geometry(TableReader& root, Geometry& geometry);

}  // namespace sinew
