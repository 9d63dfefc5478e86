#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "sinew/core/fixed_vector.h"
#include "sinew/model/joint_count.h"

namespace sinew {

/// One controller of one axis on an SPI bus, and its wires. Boards may share a bus, or have one
/// each.
struct AxisBoard {
  std::uint8_t spi_bus = 0;
  std::uint8_t spi_device = 0;
  std::uint8_t select_gpio = 0;       ///< BCM number of the chip select
  std::uint8_t ready_gpio = 0;        ///< READY, which is shown and never relied on
  double zero = 0;                    ///< rad: the joint angle that kDegU32 calls 0
  std::uint8_t homing_place = 0;      ///< 1: homes first; 0 of all of them: in the joints' order
  std::int8_t homing_direction = -1;  ///< in which its search goes: -1 towards lower angles
  double step_rate_max = 5000;        ///< microsteps/s that it makes; the first firmware's ceiling
  bool encoder_node = false;          ///< the joint's AS5600 is read over RS-485, else I2C
};

/// Of its step rate, what motions may use; the rest is for a board's loop to correct with.
inline constexpr double kStepRateShare = 0.9;

using AxisBoards = FixedVector<AxisBoard, kMaxJoints>;  ///< one per joint

/// Joints in the order in which they look for their zeros.
inline FixedVector<std::uint8_t, kMaxJoints> homing_order(const AxisBoards& boards) {
  FixedVector<std::uint8_t, kMaxJoints> order;
  for (std::size_t i = 0; i < boards.size(); ++i) order.push_back(static_cast<std::uint8_t>(i));
  std::ranges::sort(
      order, {}, [&](std::uint8_t joint) { return std::pair(boards[joint].homing_place, joint); });
  return order;
}

}  // namespace sinew
