#pragma once

#include <expected>
#include <functional>
#include <string>

#include "sinew/cli/cells/run_verb.h"
#include "sinew/cli/output/outcome.h"

namespace sinew::cli {

/// The record is one of everything, in MCAP, and written while it runs; else a CSV of the joints.
bool records_mcap(const RunRequest& request);

/// What a run may not overwrite, and whether its files can be written at all.
std::expected<void, Outcome> check_outputs(const RunRequest& request);

/// The texts of the files that a run leaves behind; asked for only where the request names one.
struct RunTexts {
  std::function<std::string()> record;
  std::function<std::string()> plot;
};

/// Writes the files that were asked for. What goes wrong is added to the
/// outcome and hides nothing of what the arm did.
void write_outputs(const RunRequest& request, const RunTexts& texts, Outcome& outcome);

}  // namespace sinew::cli
