#include "sinew/core/quantity.h"

#include <array>
#include <charconv>
#include <cmath>

#include "sinew/core/spelling.h"
#include "sinew/core/units.h"

namespace sinew {
namespace {

struct Unit {
  std::string_view name;
  Measure measure;
  double factor;  ///< to SI or rad
};

/// The first one of each measure is meant where none is written.
constexpr auto kUnits = std::to_array<Unit>({
    {"mm", Measure::kLength, 1e-3},
    {"cm", Measure::kLength, 1e-2},
    {"m", Measure::kLength, 1},
    {"in", Measure::kLength, 0.0254},
    {"deg", Measure::kAngle, kPi / 180},
    {"rad", Measure::kAngle, 1},
    {"s", Measure::kTime, 1},
    {"ms", Measure::kTime, 1e-3},
    {"min", Measure::kTime, 60},
    {"%", Measure::kShare, 1e-2},
    {"V", Measure::kVoltage, 1},
    {"kg", Measure::kMass, 1},
    {"g", Measure::kMass, 1e-3},
    {"Nm", Measure::kTorque, 1},
    {"mm/s", Measure::kSpeed, 1e-3},
    {"m/s", Measure::kSpeed, 1},
    {"in/s", Measure::kSpeed, 0.0254},
    {"mm/s2", Measure::kAcceleration, 1e-3},
    {"m/s2", Measure::kAcceleration, 1},
});

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::string units_of(Measure measure) {
  std::string names;
  for (const Unit& unit : kUnits) {
    if (unit.measure == measure) names += (names.empty() ? "" : ", ") + std::string(unit.name);
  }
  return names;
}

double default_factor(Measure measure) {
  for (const Unit& unit : kUnits) {
    if (unit.measure == measure) return unit.factor;
  }
  return 1;
}

}  // namespace

std::expected<double, std::string> parse_quantity(std::string_view text, Measure measure,
                                                  UnitRule rule) {
  const std::string_view word = trimmed(text);
  if (word.empty()) return std::unexpected("a number is missing");
  const std::string_view digits = word.front() == '+' ? word.substr(1) : word;
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool two_signs = digits.size() != word.size() && digits.starts_with('-');
  if (two_signs || error != std::errc{} || !std::isfinite(value)) {
    return std::unexpected("'" + printable(word) + "' is not a finite number");
  }
  const std::string_view suffix =
      trimmed(digits.substr(static_cast<std::size_t>(end - digits.data())));
  if (suffix.empty()) {
    if (rule == UnitRule::kOptional) return value * default_factor(measure);
    return std::unexpected("'" + printable(word) + "' needs a unit: " + units_of(measure));
  }
  for (const Unit& unit : kUnits) {
    if (unit.name == suffix && unit.measure == measure) return value * unit.factor;
  }
  return std::unexpected("'" + printable(word) + "' ends in '" + printable(suffix) +
                         "', which is none of " + units_of(measure));
}

}  // namespace sinew
