#pragma once

#include <optional>
#include <string>

#include "sinew/cli/outcome.h"

namespace sinew::cli {

struct DoctorRequest {
  std::optional<std::string> robot;
  std::optional<std::string> port;
  std::optional<std::string> wire;
  std::optional<std::string> profile;
  std::optional<std::string> journal;   ///< name of the position journal, as of run
  std::optional<std::string> settings;  ///< what commissioning found, as of run
};

/// `sinew doctor`: ports, rights and kernel interfaces of this computer; with a robot and a port
/// also what answers there. Only questions that move nothing are asked.
Outcome examine(const DoctorRequest& request);

}  // namespace sinew::cli
