#pragma once

#include <array>
#include <cmath>
#include <string>

#include "sinew/core/units.h"
#include "sinew/model/robot_model.h"

namespace sinew::test {

/// The default hexapod: assumed, until someone measures the machine.
inline HexapodGeometry default_hexapod_geometry() {
  constexpr std::array kBaseAnglesDeg{-10.0, 10.0, 110.0, 130.0, 230.0, 250.0};
  constexpr std::array kPlatformAnglesDeg{-50.0, 50.0, 70.0, 170.0, 190.0, 290.0};
  constexpr std::array kPairCentresDeg{-60.0, 60.0, 60.0, 180.0, 180.0, 300.0};
  const auto on_circle = [](double radius_mm, double angle_deg) {
    const double angle = from_deg(angle_deg);
    return from_mm(radius_mm) * Vec3{std::cos(angle), std::sin(angle), 0};
  };
  HexapodGeometry geometry;
  for (std::size_t i = 0; i < kLegs; ++i) {
    geometry.p_BA[i] = on_circle(150, kBaseAnglesDeg[i]);
    geometry.p_PA[i] = on_circle(100, kPlatformAnglesDeg[i]);
    geometry.motor_axis_B[i] = {0, 0, 1};
    geometry.skewer_axis_P[i] = on_circle(1000, kPairCentresDeg[i]);
  }
  geometry.cardan_angle_max = from_deg(45);
  geometry.ball_angle_max = from_deg(35);
  geometry.condition_max = 20;
  geometry.platform_radius = from_mm(100);
  geometry.X_BP_home.p = {0, 0, from_mm(250)};
  return geometry;
}

/// Its legs: 195 to 345 mm, anchor to anchor.
inline std::array<Joint, kLegs> default_hexapod_legs() {
  std::array<Joint, kLegs> legs;
  for (std::size_t i = 0; i < kLegs; ++i) {
    legs[i] = {.name = "leg " + std::to_string(i + 1),
               .kind = JointKind::kPrismatic,
               .lower = from_mm(195),
               .upper = from_mm(345),
               .velocity_max = from_mm(0.05),
               .acceleration_max = from_mm(1),
               .jerk_max = from_mm(10),
               .home = from_mm(195)};
  }
  return legs;
}

}  // namespace sinew::test
