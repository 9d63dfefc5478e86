#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "sinew/io/clock.h"
#include "sinew/io/port.h"
#include "sinew/program/sequence_run.h"
#include "sinew/runtime/byte_log.h"
#include "sinew/runtime/driver_line.h"

namespace sinew::runtime {

/// What a session tells while it runs.
struct SessionView {
  const sequence::Run& run;
  Instant now;
};

struct SessionHooks {
  /// Called at least every 50 ms.
  std::function<void(const SessionView&)> progress;
  /// 0: go on, 1: finish the motion under way, 2 and more: leave at once.
  std::function<int()> interrupts;
};

struct SessionEnd {
  std::vector<ByteCount> bytes;  ///< one per record of the run
  ByteCount total;
  bool left_at_once = false;
  std::optional<io::IoError> port_failure;  ///< the port went away; nobody saw what came after
};

/// Drives one program over one port in real (or scaled) time until it is over. What the run had
/// done by then stands in its records, however it ended.
SessionEnd run_sequence(sequence::Run& run, BigRobotArmDriver& driver, io::Port& port,
                        const io::Clock& clock, ByteLog& log, const SessionHooks& hooks);

}  // namespace sinew::runtime
