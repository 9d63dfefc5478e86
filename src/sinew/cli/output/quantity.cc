#include "sinew/cli/output/quantity.h"

#include <fmt/format.h>

#include <algorithm>

#include "sinew/cli/output/table.h"

namespace sinew::cli {

std::expected<std::vector<double>, std::string> parse_quantities(
    std::string_view option, std::string_view text, const std::vector<Measure>& dimensions,
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
    const auto value =
        parse_quantity(rest.substr(0, comma), dimensions[values.size()], UnitRule::kOptional);
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

std::expected<double, std::string> speed_share(std::string_view text) {
  const auto share = parse_quantity(text, Measure::kShare, UnitRule::kRequired);
  if (!share) return std::unexpected("--speed: " + share.error());
  if (!(*share >= 0.01 && *share <= 1)) {
    return std::unexpected("--speed: is 1% to 100% of what the rows say");
  }
  return *share;
}

}  // namespace sinew::cli
