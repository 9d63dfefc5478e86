#pragma once

#include "sinew/devices/feetech/feetech_driver_servos.h"
#include "sinew/driver/device_facts.h"

namespace sinew {

/// All servos of a robot as they reported last, joints in their order and the jaws' behind them.
struct FeetechFacts {
  std::array<FeetechServoState, kMaxJoints> servos{};
  std::size_t count = 0;
};

}  // namespace sinew
