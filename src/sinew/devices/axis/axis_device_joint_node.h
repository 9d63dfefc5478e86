#pragma once

#include "sinew/devices/axis/axis_device.h"
#include "sinew/devices/encoder/encoder_device_reader.h"

namespace sinew {

/// The joint's part of `inputs`, of an AS5600 that is read over RS-485. @rt
inline void read_joint_node(EncoderReader& reader, AxisInputs& inputs, Instant now) {
  const auto position = reader.take_position();
  inputs.joint_magnet = reader.magnet();
  inputs.joint_fresh = position.has_value();
  if (!position) return;
  inputs.joint_encoder_ok = true;
  inputs.joint_counts = position->ticks;
  inputs.joint_age = to_seconds(now - position->asked_at);
}

}  // namespace sinew
