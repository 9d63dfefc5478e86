#pragma once

#include <array>
#include <string>

#include "sinew/core/units.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/model/robot_model.h"

namespace sinew::test {

/// The arm with the numbers of the maker's document, without its file.
inline RobotModel maxarm_model() {
  RobotModel robot;
  robot.id = "maxarm";
  robot.geometry = PalletizerGeometry{.base_height = from_mm(84.4),
                                      .shoulder_offset = from_mm(8.14),
                                      .upper_arm = from_mm(128.4),
                                      .forearm = from_mm(138.0),
                                      .tool_offset = from_mm(16.8),
                                      .base_front = from_deg(120),
                                      .radius_min = from_mm(50)};
  constexpr std::array<double, 3> kUpperDeg{240, 210, 120};
  constexpr std::array<double, 3> kHomeDeg{120, 90, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    robot.joints.push_back({.name = "J" + std::to_string(i + 1),
                            .upper = from_deg(kUpperDeg[i]),
                            .velocity_max = from_deg(180),
                            .acceleration_max = from_deg(720),
                            .jerk_max = from_deg(7200),
                            .home = from_deg(kHomeDeg[i])});
  }
  const double pulses = 1000 / from_deg(240);
  robot.device.settings.emplace<MaxArmDevice>().servos = {
      {{0, pulses}, {875, -pulses}, {500, pulses}}};
  return robot;
}

}  // namespace sinew::test
