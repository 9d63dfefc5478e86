#pragma once

#include <optional>
#include <string>

#include "sinew/cli/cells/web_door.h"
#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

struct ServeRequest {
  std::string file;                   ///< a cell's; all robots simulated where empty
  std::optional<std::string> socket;  ///< where it listens; the user's own place where absent
  std::optional<std::string> record_folder;   ///< of each job's record; "none": they leave none
  std::optional<std::string> program_folder;  ///< of programs and points, in a folder a robot's id
  WebDoorRequest web;
  bool realtime = false;       ///< its control threads before all else on the computer
  bool demonstrate = false;    ///< simulated robots show what they can do until somebody moves one
  bool shown_is_over = false;  ///< the end is when each has been shown once
  bool json = false;
};

/// `sinew serve`: runs a cell until Ctrl-C, and answers JSON-RPC on a Unix socket and the network.
Outcome serve(const ServeRequest& request);

void add_serve(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
