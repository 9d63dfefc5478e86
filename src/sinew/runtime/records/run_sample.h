#pragma once

#include <optional>

#include "sinew/control/controller.h"
#include "sinew/runtime/links/byte_line.h"

namespace sinew::runtime {

/// A machine at one instant, as its records show it.
struct RunSample {
  Instant at{};
  control::MachineState state = control::MachineState::kOff;
  FixedVector<JointPosition, kMaxJoints> positions;
  std::optional<JointVector> commanded;  ///< control::Controller::commanded()
  ToolState tool;
  double feed = 1;
  double progress = 0;     ///< of the command under way
  std::uint32_t task = 0;  ///< that command
  DriverHealth health;
  ByteCount bytes;
  bool connected = false;
  std::optional<control::StopCause> fault;  ///< latched
};

/// What the machine's control told at one instant.
struct RunEvent {
  Instant at{};
  control::ControlEvent event;
};

/// @rt
inline RunSample sample_of(const control::Controller& controller, const ByteCount& bytes,
                           bool connected, Instant now) {
  RunSample sample;
  sample.at = now;
  sample.state = controller.state();
  sample.positions = FixedVector<JointPosition, kMaxJoints>(controller.positions());
  sample.commanded = controller.commanded();
  sample.tool = controller.tool();
  sample.feed = controller.feed();
  sample.progress = controller.progress();
  sample.task = controller.task();
  sample.health = controller.driver().health();
  sample.bytes = bytes;
  sample.connected = connected;
  if (controller.latched()) sample.fault = controller.latched()->cause;
  return sample;
}

}  // namespace sinew::runtime
