#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>

namespace sinew {

/// What a number that people write measures.
enum class Measure : std::uint8_t {
  kLength,
  kAngle,
  kTime,
  kShare,
  kVoltage,
  kMass,
  kTorque,
  kSpeed,
  kAcceleration,
};

/// Whether a number without a unit is one: a flag's name may say it (--joints-deg), a program's
/// row does not.
enum class UnitRule : std::uint8_t { kOptional, kRequired };

/// One number with its unit: "90deg", "1.57rad", "12.5mm", "0.1m", "2in", "0.5s", "200ms", "50%",
/// "9V", "0.5kg", "2Nm", "80mm/s", "1m/s2", to SI and rad; a share of 1 for %. Without a unit,
/// where that is allowed: mm, deg, s, %, V, kg, Nm, mm/s, mm/s2. The error is a sentence that names
/// the text and what would be right.
std::expected<double, std::string> parse_quantity(std::string_view text, Measure measure,
                                                  UnitRule rule);

}  // namespace sinew
