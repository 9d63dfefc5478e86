#pragma once

#include <gtest/gtest.h>

#include <string>

#include "sinew/core/units.h"
#include "sinew/devices/feetech/feetech_driver.h"
#include "sinew/devices/feetech/feetech_machine.h"
#include "support/driver_cell.h"

namespace sinew::test {

/// Three joints that turn, the second one against its servo, and jaws.
inline RobotModel feetech_robot(FeetechSeries series = FeetechSeries::kSts) {
  RobotModel robot;
  robot.id = "servos";
  SerialGeometry geometry;
  FeetechDevice device;
  device.series = series;
  const bool sts = series == FeetechSeries::kSts;
  for (int i = 0; i < 3; ++i) {
    geometry.rows.push_back({i == 0 ? 0.1 : 0, i == 0 ? 0 : 0.1, i == 0 ? -kPi / 2 : 0, 0});
    Joint joint;
    joint.name = std::string("abc").substr(static_cast<std::size_t>(i), 1);
    joint.lower = -1.5;
    joint.upper = 1.5;
    joint.velocity_max = from_deg(180);
    joint.acceleration_max = from_deg(900);
    joint.jerk_max = from_deg(9000);
    robot.joints.push_back(joint);
    device.servos.push_back(
        {static_cast<std::uint8_t>(i + 1), sts ? 2048.0 : 512.0, i == 1 ? -1.0 : 1.0, 1.0});
  }
  device.gripper = {6, sts ? 3200.0 : 800.0, sts ? 2030.0 : 510.0, sts ? 0.5 : 1};
  geometry.gripper = JawGripper{0.05, 0.1, 0.1};
  robot.geometry = geometry;
  robot.device.protocol = "feetech";
  robot.device.baud = 1'000'000;
  robot.device.capability = {.motion = MotionKind::kStream,
                             .feedback = PositionFeedback::kMeasured,
                             .segment = std::chrono::milliseconds(20),
                             .hand = HandDrive::kJaws,
                             .free_drive = true};
  robot.device.settings = device;
  return robot;
}

/// rad that a servo is off its goal by the weight of such an arm, its dead band, and rounding.
inline constexpr double kFeetechSag = 0.05;

struct FeetechCellOptions {
  sim::LinkFaultSpec faults{};
  bool opened = true;
  Duration late{};    ///< every byte comes so much later, either way
  bool echo = false;  ///< the adapter hears what it says
};

/// With a megabaud between, in segments of 20 ms.
class FeetechCell : public DriverCell<FeetechDriver, sim::FeetechMachine> {
 public:
  using Options = FeetechCellOptions;

  explicit FeetechCell(const RobotModel& model = feetech_robot(), const Options& options = {})
      : DriverCell(
            model,
            {.step = std::chrono::microseconds(100),
             .bytes_a_step = 10,
             .late = options.late,
             .echo = options.echo},
            options.faults,
            [](const RobotModel& of) {
              return FeetechDriver(of.device.settings.get<FeetechDevice>(), of.joints,
                                   std::get<SerialGeometry>(of.geometry).gripper);
            },
            [](const RobotModel& of, Instant at) { return sim::FeetechMachine(of, 5, at); }) {
    if (options.opened) open();
  }

  sim::FeetechServo& servo(std::size_t i) { return machine.bus().servo(i); }
};

}  // namespace sinew::test
