#pragma once

#include <expected>
#include <optional>

#include "sinew/cli/cells/run_verb.h"
#include "sinew/cli/output/outcome.h"
#include "sinew/runtime/running_cell.h"

namespace sinew::cli {

/// Where a run leaves its record, and the seconds before a fault.
struct RecordPlan {
  runtime::CellFolders folders;
  std::optional<runtime::RecordPlace> place;  ///< of the run's own record; nothing: none
};

/// The record of a run: into the file that was asked for, or else into the state folder; and of a
/// real machine's fault the seconds before it.
/// @error  there is no state folder for a real machine's
std::expected<RecordPlan, Outcome> plan_records(const RunRequest& request, const RobotModel& model);

/// Once the run is over: ends the files, and tells of them.
void end_records(const RunRequest& request, runtime::Station& station, Outcome& outcome);

}  // namespace sinew::cli
