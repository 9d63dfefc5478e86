#pragma once

#include "sinew/cli/outcome.h"
#include "sinew/cli/run_verb.h"

namespace sinew::cli {

/// A `.sinew` program on any robot. What `sinew run` does with it.
Outcome run_sinew_program(const RunRequest& request);

}  // namespace sinew::cli
