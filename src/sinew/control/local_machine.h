#pragma once

#include "sinew/control/controller.h"
#include "sinew/control/machine.h"

namespace sinew::control {

/// A client in the thread of the controller itself: it takes the lease, renews it, and its commands
/// go into the next step. Whoever owns both calls, each cycle,
///
///   outputs = controller.step({.commands = machine.commands(now), ..}, now);
///   machine.take(outputs);
class LocalMachine final : public Machine {
 public:
  /// Commands and events that wait for one cycle.
  static constexpr std::size_t kWaitingMax = 64;
  static constexpr Duration kRenewal = std::chrono::milliseconds(250);

  /// @param controller  outlives this
  LocalMachine(const Controller& controller, ClientId client)
      : controller_(controller), lease_{.client = client} {}

  const RobotModel& robot() const override { return controller_.robot(); }
  MachineState state() const override { return controller_.state(); }
  std::span<const JointPosition> positions() const override { return controller_.positions(); }
  std::optional<JointVector> reference() const override { return controller_.reference(); }
  ToolState tool() const override { return controller_.tool(); }
  const LeaseToken& lease() const override { return lease_; }
  const std::optional<Latched>& latched() const override { return controller_.latched(); }
  std::optional<Instant> goes_on_until() const override {
    return controller_.driver().goes_on_until();
  }
  std::optional<std::size_t> homing_joint() const override {
    return controller_.driver().homing_joint();
  }
  std::uint32_t give(const CommandWhat& what) override;
  std::optional<ControlEvent> take_event() override { return events_.take_front(); }

  /// Those of this cycle; valid until the next call.
  std::span<const Command> commands(Instant now);
  void take(const Outputs& outputs);
  /// Something waits for the next step.
  bool has_commands() const { return !waiting_.empty(); }

 private:
  const Controller& controller_;
  LeaseToken lease_;
  std::uint32_t last_id_ = 0;
  Instant renewed_{};
  FixedVector<Command, kWaitingMax> waiting_;
  FixedVector<Command, Controller::kCommandsMax> now_;
  FixedVector<ControlEvent, 4 * kWaitingMax> events_;
};

}  // namespace sinew::control
