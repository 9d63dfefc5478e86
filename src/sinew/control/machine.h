#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/control/command.h"
#include "sinew/model/tool_state.h"

namespace sinew::control {

/// A machine as its clients see it: whoever runs a program, jogs, or answers for somebody far away.
/// Behind it is a Controller, in this thread or in another one. What view() says is as old as the
/// last cycle.
class Machine {
 public:
  virtual ~Machine() = default;

  virtual const RobotModel& robot() const = 0;
  virtual MachineState state() const = 0;
  /// One a joint.
  virtual std::span<const JointPosition> positions() const = 0;
  /// Where a motion that is planned now has to begin; nothing where a joint is not known.
  virtual std::optional<JointVector> reference() const = 0;
  /// What its gripper is like; nothing where it was not told since the device was opened.
  virtual ToolState tool() const = 0;
  /// Who is asking for a command has to be the client of this lease; empty before take_lease().
  virtual const LeaseToken& lease() const = 0;
  virtual const std::optional<Latched>& latched() const = 0;
  /// Until when the machine may go on although nothing is under way.
  virtual std::optional<Instant> goes_on_until() const = 0;
  /// The joint whose zero is being searched for.
  virtual std::optional<std::size_t> homing_joint() const = 0;

  /// Given in the next cycle, with the lease at hand. @return  what its events are known by, > 0
  virtual std::uint32_t give(const CommandWhat& what) = 0;
  /// What became of this client's commands, and what concerns all; each once, in order.
  virtual std::optional<ControlEvent> take_event() = 0;
};

}  // namespace sinew::control
