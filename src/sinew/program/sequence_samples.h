#pragma once

#include <span>
#include <vector>

#include "sinew/program/sequence_run.h"

namespace sinew::sequence {

/// Joints at one instant of a run: by the device's own profile while it moves (it cannot be asked
/// then), by its report at rest.
struct Sample {
  double t = 0;  ///< s since the first order
  BigRobotArmAngles q{};
  BigRobotArmAngles qd{};
  bool predicted = false;
};

/// The whole run, every `period` > 0 seconds and at each end of a motion; times never run back.
std::vector<Sample> sample(std::span<const Record> records, double period);

}  // namespace sinew::sequence
