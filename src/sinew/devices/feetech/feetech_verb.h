#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"
#include "sinew/cli/output/verb.h"

namespace sinew::cli {

/// Servos on a bus, before they are an arm.
struct ServosRequest {
  std::string port;
  std::int64_t baud = 1'000'000;
  std::int64_t last = 20;
  std::optional<std::int64_t> id;
  std::optional<std::int64_t> new_id;
  bool middle = false;
};

Outcome servos(const ServosRequest& request);

/// The verb with its options.
void add_servos(CLI::App& app, ChosenVerb& call);

}  // namespace sinew::cli
