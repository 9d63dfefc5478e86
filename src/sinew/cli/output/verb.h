#pragma once

#include <functional>
#include <string>

#include "sinew/cli/output/outcome.h"

namespace CLI {
class App;
}  // namespace CLI

namespace sinew::cli {

/// What a command line has asked for.
struct ChosenVerb {
  bool json = false;
  std::function<Outcome()> verb;
};

/// A verb with --json and an example.
CLI::App* add_verb(CLI::App& app, ChosenVerb& call, const std::string& name,
                   const std::string& what, const std::string& example);

}  // namespace sinew::cli
