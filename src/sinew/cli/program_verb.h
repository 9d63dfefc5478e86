#pragma once

#include <expected>

#include "sinew/cli/outcome.h"
#include "sinew/cli/run_verb.h"

namespace sinew::cli {

/// A `.sinew` program on any robot. What `sinew run` does with it.
Outcome run_sinew_program(const RunRequest& request);

/// What a run may not overwrite, and whether its files could be written at all; shared by both
/// kinds of programs.
std::expected<void, Outcome> check_outputs(const RunRequest& request);

/// Adds a failure that must not hide what the arm did.
void add_failure(Outcome& outcome, const std::string& sentence);

}  // namespace sinew::cli
