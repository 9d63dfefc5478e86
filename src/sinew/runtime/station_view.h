#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sinew/control/controller.h"
#include "sinew/runtime/links/byte_line.h"
#include "sinew/sim/machine.h"

namespace sinew::runtime {

/// A machine as it was in the last cycle of its control loop: what clients are shown.
struct StationView {
  Instant at{};
  std::uint32_t stops = 0;  ///< that clients have asked for, ever
  control::MachineState state = control::MachineState::kOff;
  FixedVector<JointPosition, kMaxJoints> positions;
  std::optional<JointVector> reference;
  ToolState tool;
  std::optional<control::LeaseToken> holder;
  std::optional<control::Latched> latched;
  FixedVector<control::Latched, control::Controller::kLaterCausesMax> later;
  std::optional<control::StopCause> last_stop;
  double feed = 1;
  bool free_drive = false;
  std::uint32_t task = 0;  ///< the command under way
  double progress = 0;     ///< of it
  planning::JogStatus jog;
  std::optional<Instant> goes_on_until;
  bool brakes = false;  ///< it was told to stop, or stops by itself, and does not stand yet
  std::optional<std::size_t> homing_joint;
  DriverHealth health;
  ByteCount bytes;
  bool port_open = false;
  std::optional<sim::Truth> truth;  ///< of a simulated machine
  DeviceFacts facts;                ///< what its driver has heard
  double cycle_mean = 0;            ///< s of real time, over the last hundred cycles
  double cycle_longest = 0;         ///< s, of them
};

/// Events that wait for one who listens; those beyond kMax are dropped and counted.
class EventQueue {
 public:
  static constexpr std::size_t kMax = 256;

  void push(const control::ControlEvent& event) {
    if (!events_.full()) {
      events_.push_back(event);
    } else {
      ++dropped_;
    }
  }
  std::optional<control::ControlEvent> take() { return events_.take_front(); }
  std::uint64_t dropped() const { return dropped_; }

 private:
  FixedVector<control::ControlEvent, kMax> events_;
  std::uint64_t dropped_ = 0;
};

}  // namespace sinew::runtime
