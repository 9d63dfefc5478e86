#pragma once

#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// Whether a robot's wire can say a place, asked before anything moves and of the very functions by
/// which the robot's driver says it: a program is refused as a whole then, not in its middle.
class WireTarget {
 public:
  /// @param robot  outlives this.
  explicit WireTarget(const RobotModel& robot) : robot_(robot) {}

  /// DeviceSettings::target_refusal() of the robot's device.
  std::optional<Error> refusal(std::span<const double> q, std::span<const double> from = {}) const;

  /// The place nearest to q that can be said and is inside the limits: joints that can be said
  /// stay. Nothing where there is none within some thousand steps.
  std::optional<JointVector> nearest(std::span<const double> q) const;

 private:
  const RobotModel& robot_;
};

}  // namespace sinew
