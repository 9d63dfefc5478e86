#pragma once

#include <functional>
#include <optional>

#include "sinew/program/program_run.h"
#include "sinew/runtime/control_loop.h"
#include "sinew/runtime/driver_line.h"

namespace sinew::runtime {

struct ProgramHooks {
  /// Called at least every 50 ms.
  std::function<void(const program::Run&, Instant)> progress;
  /// 0: go on, 1: stop, 2 and more: leave at once.
  std::function<int()> interrupts;
};

struct ProgramEnd {
  ByteCount bytes;
  bool left_at_once = false;
  std::optional<io::IoError> wire_failure;  ///< nobody saw what came after
};

/// What a controller needs to know of the time that a process like this one keeps: a scheduler that
/// lets others go first, and `scale` seconds of the run in one real second.
/// @param opening  how long the device may take until it answers
control::ControllerSettings session_settings(const io::Clock& clock, Duration opening);

/// Drives one program in real (or scaled) time until it is over and its machine is at rest. What
/// the run had done by then stands in its records, however it ended.
ProgramEnd run_program(program::Run& run, ControlLoop& loop, DriverLine& line,
                       const io::Clock& clock, const ProgramHooks& hooks);

}  // namespace sinew::runtime
