#pragma once

#include <string>

#include "sinew/core/pose.h"
#include "sinew/toml/table_reader.h"

namespace sinew {

/// `position_mm` and `rotation_deg` (about fixed x, y, z), a line each.
std::string toml_pose(const Vec3& p, const Rotation& R);

/// Both, up to 100 m.
void read_toml_pose(TableReader& table, Vec3& p, Rotation& R);

template <class From, class To>
void read_toml_pose(TableReader& table, Pose<From, To>& X) {
  read_toml_pose(table, X.p, X.R);
}

}  // namespace sinew
