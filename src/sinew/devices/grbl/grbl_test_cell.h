#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/devices/grbl/grbl_driver.h"
#include "sinew/devices/grbl/grbl_machine.h"
#include "support/driver_cell.h"

namespace sinew::test {

/// Joints that turn, every second one the other way round on the wire.
inline RobotModel grbl_robot(std::size_t joints = 3, bool homes = false) {
  RobotModel robot;
  robot.id = "grbl";
  SerialGeometry geometry;
  GrblDevice device;
  device.homes = homes;
  for (std::size_t i = 0; i < joints; ++i) {
    geometry.rows.push_back({0.1, 0.1, 0, 0});
    Joint joint;
    joint.name = std::string("abcdef").substr(i, 1);
    joint.lower = -1.5;
    joint.upper = 2;
    joint.velocity_max = from_deg(90);
    joint.acceleration_max = from_deg(400);
    joint.jerk_max = from_deg(4000);
    robot.joints.push_back(joint);
    const double steps = 3200 * 10 / 360.0;
    device.axes.push_back({.steps_per_unit = i % 2 == 0 ? steps : -steps,
                           .zero = homes ? 0.3 : 0.0,
                           .homes_down = i % 2 == 0});
  }
  robot.geometry = geometry;
  robot.device.protocol = "grbl";
  robot.device.baud = 115'200;
  robot.device.capability = {.motion = MotionKind::kStream,
                             .feedback = PositionFeedback::kCommanded,
                             .segment = std::chrono::milliseconds(50)};
  robot.device.settings = device;
  return robot;
}

/// rad: a step of such a robot and a digit of its wire.
inline constexpr double kGrblStep = 2 * kPi / 32'000 + from_deg(1e-3);

/// With 115,200 baud between, in segments of 50 ms.
class GrblCell : public DriverCell<GrblDriver, sim::GrblMachine> {
 public:
  explicit GrblCell(const RobotModel& model = grbl_robot(), const sim::LinkFaultSpec& faults = {},
                    bool opened = true)
      : DriverCell(
            model, {.step = std::chrono::milliseconds(1), .bytes_a_step = 11, .segment = 0.05},
            faults,
            [](const RobotModel& of) {
              return GrblDriver(of.device.settings.get<GrblDevice>(), of.joints, of.device.baud);
            },
            [](const RobotModel& of, Instant at) { return sim::GrblMachine(of, at); }) {
    if (opened) open();
  }

  void open(bool declared = true) {
    DriverCell::open();
    if (declared) declare();
    events.clear();
  }
  /// Where the machine really is.
  void declare() {
    std::vector<JointPosition> all;
    for (const sim::JointTruth& joint : machine.truth().joints) {
      all.push_back({PositionQuality::kCommanded, joint.q, joint.q - 1e-6, joint.q + 1e-6});
    }
    driver.declare_positions(all);
  }
};

}  // namespace sinew::test
