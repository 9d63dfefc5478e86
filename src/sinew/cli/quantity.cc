#include "sinew/cli/quantity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "sinew/cli/table.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"

namespace sinew::cli {
namespace {

struct Unit {
  std::string_view name;
  Dimension dimension;
  double factor;  ///< to m or rad
};

constexpr auto kUnits = std::to_array<Unit>({
    {"mm", Dimension::kLength, 1e-3},
    {"cm", Dimension::kLength, 1e-2},
    {"m", Dimension::kLength, 1},
    {"in", Dimension::kLength, 0.0254},
    {"deg", Dimension::kAngle, kPi / 180},
    {"rad", Dimension::kAngle, 1},
});

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

std::expected<double, std::string> parse_quantity(std::string_view text, Dimension dimension) {
  const std::string_view word = trimmed(text);
  const std::string_view units = dimension == Dimension::kLength ? "mm, cm, m, in" : "deg, rad";
  if (word.empty()) return std::unexpected("a number is missing");
  const std::string_view digits = word.front() == '+' ? word.substr(1) : word;
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool two_signs = digits.size() != word.size() && digits.starts_with('-');
  if (two_signs || error != std::errc{} || !std::isfinite(value)) {
    return std::unexpected(fmt::format("'{}' is not a finite number", printable(word)));
  }
  const std::string_view suffix =
      trimmed(digits.substr(static_cast<std::size_t>(end - digits.data())));
  if (suffix.empty()) return value * (dimension == Dimension::kLength ? 1e-3 : kPi / 180);
  for (const Unit& unit : kUnits) {
    if (unit.name == suffix && unit.dimension == dimension) return value * unit.factor;
  }
  return std::unexpected(fmt::format("'{}' ends in '{}', which is none of {}", printable(word),
                                     printable(suffix), units));
}

std::expected<std::vector<double>, std::string> parse_quantities(
    std::string_view option, std::string_view text, const std::vector<Dimension>& dimensions,
    const std::vector<std::string>& names) {
  std::vector<double> values;
  std::string_view rest = text;
  while (true) {
    const std::size_t comma = rest.find(',');
    if (values.size() == dimensions.size()) {
      const auto given = std::count(text.begin(), text.end(), ',') + 1;
      return std::unexpected(fmt::format("{}: {} numbers are wanted ({}), {} were given", option,
                                         dimensions.size(), joined(names, ","), given));
    }
    const auto value = parse_quantity(rest.substr(0, comma), dimensions[values.size()]);
    if (!value) {
      return std::unexpected(fmt::format("{}: {} (number {}, {})", option, value.error(),
                                         values.size() + 1, names[values.size()]));
    }
    values.push_back(*value);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (values.size() != dimensions.size()) {
    return std::unexpected(fmt::format("{}: {} numbers are wanted ({}), {} were given", option,
                                       dimensions.size(), joined(names, ","), values.size()));
  }
  return values;
}

}  // namespace sinew::cli
