#include "sinew/config/read_geometry.h"

#include "sinew/core/rotation.h"

namespace sinew {
namespace {

// Sinew is for arms on a bench; what is larger is a wrong unit.
constexpr Range kAnyLength = between(-10, 10);           // m
constexpr Range kLinkLength = above_zero_to(10);         // m
constexpr Range kAnyAngle = between(-2 * kPi, 2 * kPi);  // rad
constexpr Range kJawLength = between(0, 1);              // m
constexpr Range kConeAngle = above_zero_to(kPi / 2);     // rad
constexpr std::size_t kRowsWithPitch = 5;

/// xyz and fixed-axis roll, pitch, yaw of one frame in another.
template <class A, class B>
void read_pose(TableReader& reader, Pose<A, B>& X_AB) {
  Vec3 rpy;
  reader.vector("xyz_*", kLength, kAnyLength, X_AB.p);
  if (reader.vector("rpy_*", kAngle, kAnyAngle, rpy)) X_AB.R = rotation_from_fixed_xyz(rpy);
  reader.finish();
}

void read_gripper(TableReader& root, SerialGeometry& geometry) {
  std::optional<TableReader> reader = root.table("gripper", Presence::kOptional);
  if (!reader) return;
  JawGripper gripper;
  reader->quantity("width_max_*", kLength, above_zero_to(1), gripper.width_max);
  reader->quantity("reach_open_*", kLength, kJawLength, gripper.reach_open);
  reader->quantity("reach_closed_*", kLength, kJawLength, gripper.reach_closed);
  reader->finish();
  geometry.gripper = gripper;
}

void read_serial(TableReader& root, TableReader& reader, SerialGeometry& geometry) {
  for (TableReader& row_reader : reader.tables("dh")) {
    if (geometry.rows.full()) {
      row_reader.complain("one row too many: a chain has at most " + std::to_string(kMaxJoints));
      break;
    }
    DhRow row;
    row_reader.quantity("theta_offset_*", kAngle, kAnyAngle, row.theta_offset);
    row_reader.quantity("d_*", kLength, kAnyLength, row.d);
    row_reader.quantity("a_*", kLength, kAnyLength, row.a);
    row_reader.quantity("alpha_*", kAngle, kAnyAngle, row.alpha);
    row_reader.finish();
    geometry.rows.push_back(row);
  }
  if (geometry.rows.size() == kRowsWithPitch) {
    reader.quantity("pitch_preferred_*", kAngle, between(0, kPi), geometry.pitch_preferred);
  }
  if (auto tool = root.table("tool", Presence::kOptional)) read_pose(*tool, geometry.X_FT);
  read_gripper(root, geometry);
}

void read_palletizer(TableReader& reader, PalletizerGeometry& geometry) {
  reader.quantity("base_height_*", kLength, kAnyLength, geometry.base_height);
  reader.quantity("shoulder_offset_*", kLength, kAnyLength, geometry.shoulder_offset);
  reader.quantity("upper_arm_*", kLength, kLinkLength, geometry.upper_arm);
  reader.quantity("forearm_*", kLength, kLinkLength, geometry.forearm);
  reader.quantity("tool_offset_*", kLength, kAnyLength, geometry.tool_offset);
  reader.quantity("base_front_*", kAngle, kAnyAngle, geometry.base_front);
  reader.quantity("radius_min_*", kLength, between(0, 10), geometry.radius_min);
}

void read_legs(TableReader& reader, HexapodGeometry& geometry) {
  std::size_t leg = 0;
  for (TableReader& leg_reader : reader.tables("leg")) {
    if (leg == kLegs) {
      leg_reader.complain("one leg too many: a hexapod has six");
      return;
    }
    leg_reader.vector("base_anchor_*", kLength, kAnyLength, geometry.p_BA[leg]);
    leg_reader.vector("platform_anchor_*", kLength, kAnyLength, geometry.p_PA[leg]);
    leg_reader.direction("motor_axis", geometry.motor_axis_B[leg]);
    leg_reader.direction("skewer_axis", geometry.skewer_axis_P[leg]);
    leg_reader.finish();
    ++leg;
  }
  if (leg > 0 && leg < kLegs) {
    reader.complain("leg", "a hexapod has six legs, not " + std::to_string(leg));
  }
}

void read_hexapod(TableReader& reader, HexapodGeometry& geometry) {
  constexpr Range kCondition = between(1, 1e6);  // 1 is the best that there is
  reader.quantity("cardan_angle_max_*", kAngle, kConeAngle, geometry.cardan_angle_max);
  reader.quantity("ball_angle_max_*", kAngle, kConeAngle, geometry.ball_angle_max);
  reader.number("condition_max", kCondition, geometry.condition_max);
  reader.quantity("platform_radius_*", kLength, kLinkLength, geometry.platform_radius);
  read_legs(reader, geometry);
  if (std::optional<TableReader> home = reader.table("home")) read_pose(*home, geometry.X_BP_home);
}

}  // namespace

std::optional<GeometryKind> read_geometry(TableReader& root, Geometry& geometry) {
  constexpr Named<GeometryKind> kKinds[] = {{"serial", GeometryKind::kSerial},
                                            {"palletizer", GeometryKind::kPalletizer},
                                            {"hexapod", GeometryKind::kHexapod}};
  std::optional<TableReader> reader = root.table("geometry");
  GeometryKind kind{};
  if (!reader) return std::nullopt;
  if (!reader->choice("kind", kKinds, kind)) {
    reader->ignore_rest();
    reader->finish();
    return std::nullopt;
  }
  switch (kind) {
    case GeometryKind::kSerial:
      read_serial(root, *reader, geometry.emplace<SerialGeometry>());
      break;
    case GeometryKind::kPalletizer:
      read_palletizer(*reader, geometry.emplace<PalletizerGeometry>());
      break;
    case GeometryKind::kHexapod:
      read_hexapod(*reader, geometry.emplace<HexapodGeometry>());
      break;
  }
  reader->finish();
  return kind;
}

}  // namespace sinew
