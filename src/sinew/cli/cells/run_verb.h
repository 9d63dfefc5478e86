#pragma once

#include <optional>
#include <string>

#include "sinew/cli/cells/local_cell.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

struct RunRequest {
  std::string file;
  RobotOptions robot;
  std::optional<std::string> standing_at;  ///< "home", "shown", or one value per joint
  std::optional<std::string> moved;        ///< why what was known of its position does not count
  std::optional<int> from_line;            ///< of a program NAME.sinew, where it goes on
  std::optional<std::string> speed;        ///< of all its rows, "30%"
  std::optional<std::string> record;
  bool recorded = true;  ///< in the state folder, where `record` is no .mcap
  std::optional<std::string> plot;
  std::optional<std::string> log;
  bool quiet = false;  ///< no progress on stderr
};

/// `sinew run`: a program on a robot, over its port or against the simulated device.
Outcome run_program(const RunRequest& request);

void add_run(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
