#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "sinew/model/joint_count.h"

namespace sinew {

/// How long point-to-point moves take, undisturbed, of a device whose joints are commanded one
/// after the other and go each at its own pace. Moves are asked for in a row: how the device is
/// spoken to goes on where the last one ended.
class SeparateMoves {
 public:
  struct Move {
    double own = 0;      ///< s, from the first joint's start until the last one has arrived
    double arrival = 0;  ///< s, from the order until the last joint has arrived
    double report = 0;   ///< s, from the order until the driver reports so
    std::array<double, kMaxJoints> start{};  ///< s, from the order until each joint starts
  };

  virtual ~SeparateMoves() = default;
  /// Where a joint goes that is sent to q: the nearest position that can be commanded, rad.
  virtual double target(std::size_t joint, double q) const = 0;
  /// @param own  s that each joint's move takes; 0 where it is not commanded
  virtual Move next(std::span<const double> own) = 0;
};

}  // namespace sinew
