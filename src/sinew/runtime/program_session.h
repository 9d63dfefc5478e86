#pragma once

#include <functional>
#include <optional>

#include "sinew/program/program_run.h"
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

/// Drives one program in real (or scaled) time until it is over and its driver is at rest. What
/// the run had done by then stands in its records, however it ended.
ProgramEnd run_program(program::Run& run, Driver& driver, DriverLine& line, const io::Clock& clock,
                       const ProgramHooks& hooks);

}  // namespace sinew::runtime
