#pragma once

#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

/// `sinew robots`: one row a built-in robot; with an id or a file, everything about that one.
Outcome list_robots();
Outcome show_robot(const std::string& argument);

void add_robots(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
