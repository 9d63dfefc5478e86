#pragma once

#include "sinew/cli/cells/local_cell.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

struct DoctorRequest {
  RobotOptions robot;                  ///< robot and port: both or none
  std::optional<std::string> encoder;  ///< port of an encoder node instead
  double watch_s = 0;                  ///< with an encoder: its shaft is turned by hand meanwhile
};

/// `sinew doctor`: ports, rights and kernel interfaces of this computer; with a robot and a port
/// also what answers there. Only questions that move nothing are asked.
Outcome examine(const DoctorRequest& request);

void add_doctor(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
