#pragma once

#include <gtest/gtest.h>

#include <string>

#include "sinew/core/units.h"
#include "sinew/devices/ideal/ideal_driver.h"
#include "sinew/devices/ideal/ideal_machine.h"
#include "support/driver_cell.h"

namespace sinew::test {

/// Three joints that turn, and jaws.
inline RobotModel ideal_robot() {
  RobotModel robot;
  robot.id = "three";
  SerialGeometry geometry;
  for (int i = 0; i < 3; ++i) geometry.rows.push_back({0.1, 0.1, 0, 0});
  geometry.gripper = JawGripper{0.04, 0.1, 0.1};
  robot.geometry = geometry;
  for (int i = 0; i < 3; ++i) {
    Joint joint;
    joint.name = std::string("abc").substr(static_cast<std::size_t>(i), 1);
    joint.lower = -2;
    joint.upper = 2 + i;
    joint.velocity_max = 2;
    joint.acceleration_max = 8;
    joint.jerk_max = 80;
    robot.joints.push_back(joint);
  }
  return robot;
}

/// With a megabaud between, in segments of 20 ms.
class IdealCell : public DriverCell<IdealDriver, sim::IdealMachine> {
 public:
  /// @param late  every byte comes so much later, either way
  explicit IdealCell(const sim::LinkFaultSpec& faults = {}, bool opened = true, Duration late = {},
                     const RobotModel& model = ideal_robot())
      : DriverCell(
            model, {.step = std::chrono::microseconds(100), .bytes_a_step = 10, .late = late},
            faults,
            [](const RobotModel& of) {
              return IdealDriver(of.joints, std::get<SerialGeometry>(of.geometry).gripper,
                                 1'000'000);
            },
            [](const RobotModel& of, Instant at) { return sim::IdealMachine(of, at); }) {
    if (opened) open();
  }
};

}  // namespace sinew::test
