#pragma once

#include <string>

#include "sinew/cli/output/outcome.h"

namespace sinew::cli {

/// An encoder node on a serial adapter.
struct EncoderRequest {
  std::string port;
  double watch_s = 0;  ///< for so long the shaft may be turned by hand; 0: one look
};

/// Asks the node for everything it can report; nothing moves.
Outcome examine_encoder(const EncoderRequest& request);

}  // namespace sinew::cli
