#pragma once

#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

struct ConvertRequest {
  std::string in;
  std::optional<std::string> out;  ///< on stdout where left out
  std::string robot;
  std::optional<std::string> from, to;  ///< a kind; by the file's ending where left out
  bool comma = false;                   ///< decimals of a .pos file
  bool replace = false;                 ///< a file `out` that is there; what a journal knows
  std::optional<std::string> journal;   ///< takes over what a config says, as uncertain
};

/// `sinew convert`: programs and poses from and to the forms that others read. What a form cannot
/// say is a complaint with its line, and nothing is written then.
Outcome convert(const ConvertRequest& request);

void add_convert(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
