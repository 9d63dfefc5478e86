#include "sinew/toml/toml_pose.h"

#include <array>
#include <cstdio>

#include "sinew/core/units.h"

namespace sinew {

std::string toml_pose(const Vec3& p, const Rotation& R) {
  const Vec3 mm = 1e3 * p;
  const Vec3 deg = (180 / kPi) * fixed_xyz(R);
  std::array<char, 300> text{};
  std::snprintf(text.data(), text.size(),
                "position_mm = [%.9f, %.9f, %.9f]\nrotation_deg = [%.9f, %.9f, %.9f]\n", mm.x, mm.y,
                mm.z, deg.x, deg.y, deg.z);
  return text.data();
}

void read_toml_pose(TableReader& table, Vec3& p, Rotation& R) {
  constexpr Range kReach = between(-100, 100);  // m
  constexpr Range kTurn = between(-2 * kPi, 2 * kPi);
  Vec3 rpy;
  table.vector("position_*", kLength, kReach, p);
  table.vector("rotation_*", kAngle, kTurn, rpy);
  R = rotation_from_fixed_xyz(rpy);
}

}  // namespace sinew
