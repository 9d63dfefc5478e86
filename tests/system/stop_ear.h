#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "sinew/core/instant.h"
#include "sinew/model/robot_model.h"

namespace sinew::test {

/// A frame that says something about motion.
struct MotionFrame {
  Instant begins{};   ///< its first byte
  bool stops = true;  ///< false: it moves the machine on
};

/// Listens to what goes to a device, and tells the frames that stop it from all others. On wires
/// without a stop of their own the order to stay is one to move to where it is (LSC, MaxArm): there
/// each frame of targets counts, and who listens begins behind the last one of the motion.
class StopEar {
 public:
  virtual ~StopEar() = default;
  /// A byte, or a whole exchange, in order.
  /// @return  the frame that it completes, if that is about motion
  virtual std::optional<MotionFrame> hear(std::span<const std::uint8_t> bytes, Instant begins) = 0;
};

/// For the wire of this device. Null where nothing on it stops a motion.
std::unique_ptr<StopEar> stop_ear(const Device& device);

}  // namespace sinew::test
