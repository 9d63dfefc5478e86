#pragma once

#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/model/robot_model.h"

namespace sinew::test {

/// The BigRobotArm as its user interface counts it, for tests of its machine and its driver.
inline RobotModel big_robot_arm(BigRobotArmWire wire = BigRobotArmWire::kByte,
                                BigRobotArmDialect dialect = BigRobotArmDialect::k2021) {
  constexpr std::array<double, 5> kStepsPerQuarter{6500, -2500, -10000, -2000, 3000};
  constexpr std::array<double, 5> kStepsPerRev{3200, 400, 3200, 3200, 3200};
  constexpr std::array<double, 5> kRange{90, 90, 126, 90, 90};        // deg
  constexpr std::array<double, 5> kSpeed{88.6, 14.4, 28.8, 144, 96};  // deg/s
  constexpr std::array<const char*, 5> kNames{"base", "shoulder", "elbow", "wrist_rotate", "wrist"};
  RobotModel robot;
  robot.id = "bigrobotarm";
  BigRobotArmDevice device;
  device.wire = wire;
  device.dialect = dialect;
  for (std::size_t i = 0; i < 5; ++i) {
    Joint joint;
    joint.name = kNames[i];
    joint.upper = kRange[i] * kPi / 180;
    joint.lower = -joint.upper;
    joint.velocity_max = joint.acceleration_max = kSpeed[i] * kPi / 180;
    joint.jerk_max = 10 * joint.velocity_max;
    robot.joints.push_back(joint);
    device.joints[i] = {kStepsPerQuarter[i] / (kPi / 2), kStepsPerRev[i], i == 0 ? 200 : 100};
  }
  SerialGeometry geometry;
  geometry.rows = {{0, 0, -kPi / 2, 0},
                   {0, 0.22113, 0, -kPi / 2},
                   {0, 0, kPi / 2, kPi / 2},
                   {0.223844, 0, -kPi / 2, 0},
                   {0, 0, kPi / 2, 0}};
  geometry.X_FT.p = {0, 0, 0.123035};
  robot.geometry = geometry;
  robot.device.baud = 250'000;
  robot.device.settings = device;
  return robot;
}

}  // namespace sinew::test
