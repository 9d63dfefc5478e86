#pragma once

#include <expected>
#include <memory>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/runtime/journal/position_record.h"

namespace sinew::cli {

/// The position journal of this name in the state folder, for a verb that moves nothing.
/// @error  bad input: no name for one; the journal cannot be had
std::expected<std::unique_ptr<runtime::PositionRecord>, Outcome> open_journal(
    const std::string& name, const RobotModel& model);

}  // namespace sinew::cli
