#pragma once

#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"

namespace sinew::cli {

/// What the user wrote after `sinew jog`; numbers still as text.
struct JogRequest {
  std::string robot;
  std::string frame = "base";
  std::string velocity;
  std::optional<std::string> time;
  std::optional<std::string> from;  ///< joints; home where left out
  bool contact = false;             ///< the robot may touch itself and its table
  std::optional<std::string> plot;
};

/// `sinew jog`: what a robot does while somebody holds a stick, and then lets go; simulated,
/// nothing moves.
Outcome jog(const JogRequest& request);

}  // namespace sinew::cli
