#pragma once

#include <CLI/CLI.hpp>

#include "sinew/cli/cells/local_cell.h"

/// Options of verbs that open a robot.
namespace sinew::cli {

inline void add_journal(CLI::App& verb, RobotOptions& robot) {
  verb.add_option("--journal", robot.journal,
                  "name of its position journal; the robot's id where left out, none for a "
                  "simulated port");
}

inline void add_settings(CLI::App& verb, RobotOptions& robot) {
  verb.add_option("--settings", robot.settings,
                  "what commissioning found: its file, or none; on a real port that of the state "
                  "folder where left out");
}

inline void add_time_scale(CLI::App& verb, RobotOptions& robot) {
  verb.add_option("--time-scale", robot.time_scale, "simulated device only: faster or slower");
}

inline void add_seed(CLI::App& verb, RobotOptions& robot) {
  verb.add_option("--seed", robot.seed, "simulated device only: of all its chance");
}

}  // namespace sinew::cli
