#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "sinew/devices/axis/axis_registers_settings.h"
#include "sinew/model/device.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// How long whole moves over the register wire take, undisturbed: AxisRegistersDriver's own order
/// of frames, one after the other, each board at its own pace once it was told. Moves are asked for
/// in a row, since the driver's round goes on where the last one ended.
class AxisRegisterTimes {
 public:
  struct Move {
    double own = 0;      ///< s, from the first board's start until the last one has arrived
    double arrival = 0;  ///< s, from the order until the last board has arrived
    double report = 0;   ///< s, from the order until the driver tells so
    std::array<double, kMaxJoints> start{};  ///< s, from the order until each board starts
  };

  explicit AxisRegisterTimes(const AxisRegistersDevice& device) : device_(device) {}

  /// @param own  s that each board's move takes; 0 where it is not told to
  Move next(std::span<const double> own);

 private:
  const AxisRegistersDevice& device_;
  std::size_t cursor_ = 0;  ///< of the driver's round
};

/// What a board is told of a joint's angle: the document's registers have whole degrees.
double told_angle(const AxisRegistersDevice& device, const RobotModel& robot, std::size_t joint,
                  double q);

}  // namespace sinew
