#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "sinew/core/instant.h"
#include "sinew/devices/axis/axis_device.h"
#include "sinew/devices/encoder/encoder_device_reader.h"
#include "sinew/devices/encoder/encoder_machine.h"

namespace sinew::sim {

/// A joint's AS5600 on an encoder node, and the axis board's end of the RS-485 line. One call each
/// control tick of 1 ms: at 115200 baud a request and its reply need 0.7 ms, so the reply to one
/// tick's request is there at the next. @rt
class JointNode {
 public:
  JointNode(As5600& sensor, Instant boot) : bus_(sensor), board_(bus_, boot) {}

  /// The joint's part of `inputs`, as the board knows it over its line.
  void read(AxisInputs& inputs, Instant now);

 private:
  /// Of a request: three bytes of ten bits.
  static constexpr Duration kRequestTime = std::chrono::nanoseconds(260'417);

  As5600Bus bus_;
  EncoderBoard board_;
  EncoderReader reader_;
  std::optional<encoder_link::RequestBytes> request_;
  Instant asked_at_;
};

}  // namespace sinew::sim
