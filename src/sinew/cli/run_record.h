#pragma once

#include <expected>
#include <memory>

#include "sinew/cli/outcome.h"
#include "sinew/cli/run_verb.h"
#include "sinew/io/clock.h"
#include "sinew/runtime/run_recorder.h"

namespace sinew::cli {

/// The record of a run: into the file that was asked for, or else into the state folder; and of a
/// real machine's fault the seconds before it. Null where there is neither.
std::expected<std::unique_ptr<runtime::RunRecorder>, Outcome> begin_record(
    const RunRequest& request, const RobotModel& model, bool real, const io::Clock& clock);

/// Behind the last sample: ends the files, and tells of them.
void end_record(const RunRequest& request, runtime::RunRecorder& recorder, Outcome& outcome);

}  // namespace sinew::cli
