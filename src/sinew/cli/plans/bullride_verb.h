#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>

#include "sinew/cli/output/outcome.h"

namespace sinew::cli {

struct BullrideRequest {
  std::string robot;
  std::optional<std::string> profile;
  std::optional<std::string> wire;
  std::optional<std::string> time;  ///< 30s where absent
  std::int64_t seed = 1;
  std::optional<std::string> amplitude;  ///< as in 20%, of legs 0.02mm; what the wire allows else
  std::optional<std::string> from;       ///< home where absent
};

/// Of both: what is said, or why not.
std::expected<double, Outcome> ride_time(const std::optional<std::string>& text);
/// @param stroke  of a platform's legs, m: they take a length too; 0: joints turn
std::expected<double, Outcome> ride_amplitude(const std::optional<std::string>& text,
                                              double stroke);

/// `sinew bullride`: a program of random moves on stdout; nothing moves.
Outcome bullride(const BullrideRequest& request);

}  // namespace sinew::cli
