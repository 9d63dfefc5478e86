#pragma once

#include "sinew/cli/output/verb.h"

namespace sinew::cli {

void add_jog(CLI::App& app, ChosenVerb& call);
void add_bullride(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
