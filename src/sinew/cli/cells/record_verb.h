#pragma once

#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

struct RecordRequest {
  std::string file;
  std::optional<std::string> csv;
  std::optional<std::string> pictures;  ///< a folder
};

/// `sinew record`: what is in a record, the same as CSV, and what a program looked at as files. Of
/// a record that was cut off, as much as there is; a damaged one is refused.
Outcome show_record(const RecordRequest& request);

void add_record(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
