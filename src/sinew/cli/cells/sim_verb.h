#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

struct SimRequest {
  std::string robot;
  std::optional<std::string> link;
  std::optional<std::string> log;
  std::optional<std::string> profile;
  std::optional<std::string> wire;
  std::optional<std::string> fault;
  std::optional<std::string> simwire;  ///< "unix:PATH" or "stdio"; boards on SPI only
  std::optional<std::int64_t> slaves;
  std::optional<std::string> nss;    ///< "hard" or "soft"
  bool ready_high = false;           ///< READY never falls
  std::optional<std::string> state;  ///< file of what the machine keeps without power
  std::optional<std::int64_t> seed;
  double time_scale = 1;
  std::optional<double> speed;  ///< deg/s of an encoder node's shaft
  bool json = false;
};

/// `sinew sim`: the robot's device on a pseudo-terminal, or its boards on SPI behind simwire, until
/// Ctrl-C. The first line on stdout is the port's path; with --json {"port": ..}, and {"truth": ..}
/// on the last, a document a line. SIGUSR1, and a line on stdin, are answered with the truth.
Outcome simulate(const SimRequest& request);

void add_sim(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
