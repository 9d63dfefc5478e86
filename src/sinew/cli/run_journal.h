#pragma once

#include <expected>
#include <memory>

#include "sinew/cli/outcome.h"
#include "sinew/cli/run_verb.h"
#include "sinew/io/clock.h"
#include "sinew/runtime/control_loop.h"
#include "sinew/runtime/position_record.h"

namespace sinew::cli {

/// The position journal of a run: a real machine has one, a simulated one only where it was given a
/// name, since most of them begin anew each time. Null where there is none.
std::expected<std::unique_ptr<runtime::PositionRecord>, Outcome> open_journal(
    const RunRequest& request, const RobotModel& model);

/// A loop that begins where the record says, and is recorded by it.
/// @param record  null where nothing is recorded; outlives the loop, as the robot and driver do
runtime::ControlLoop recorded_loop(const RobotModel& robot, Driver& driver, const io::Clock& clock,
                                   runtime::PositionRecord* record);

}  // namespace sinew::cli
