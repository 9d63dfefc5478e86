#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sinew/cli/outcome.h"

namespace sinew::cli {

struct RunRequest {
  std::string file;
  std::string robot;
  std::optional<std::string> port;
  std::optional<std::string> wire;
  std::vector<std::string> without;  ///< joints that are left out
  std::optional<std::string> profile;
  std::optional<std::string> standing_at;  ///< "home", "shown", or one value per joint
  std::optional<std::string> moved;        ///< why what was known of its position does not count
  std::optional<int> from_line;            ///< of a program NAME.sinew, where it goes on
  std::optional<std::string> speed;        ///< of all its rows, "30%"
  /// What commissioning found: a file, "none", or that of the state folder where left out, which
  /// counts on real ports only.
  std::optional<std::string> settings;
  std::optional<std::string> journal;  ///< name of the robot's position journal
  std::int64_t seed = 1;               ///< of the simulated machine
  std::optional<std::string> record;
  bool recorded = true;  ///< in the state folder, where `record` is no .mcap
  std::optional<std::string> plot;
  std::optional<std::string> log;
  double time_scale = 1;
  bool quiet = false;  ///< no progress on stderr
};

/// `sinew run`: a program on a robot, over its port or against the simulated device.
Outcome run_program(const RunRequest& request);

}  // namespace sinew::cli
