#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

struct CheckRequest {
  std::string file;
  std::string robot;
  std::optional<std::string> from;  ///< joints; home where left out
  std::optional<std::string> profile, wire;
  std::vector<std::string> without;  ///< joints that are left out
};

/// `sinew check`: everything but the motion, a verdict for each row.
Outcome check_program(const CheckRequest& request);

struct FormatRequest {
  std::vector<std::string> files;
  bool only_look = false;
};

/// `sinew fmt`: programs in their one layout, in place; or only which ones are not in it.
Outcome format_programs(const FormatRequest& request);

void add_check(CLI::App& app, ChosenVerb& call);
void add_format(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
