#include "sinew/vision/color_names.h"

#include <algorithm>
#include <array>

namespace sinew::vision {
namespace {

constexpr std::array<std::string_view, kColorNames> kNames{
    "red", "orange", "yellow", "green", "blue", "purple", "pink", "black", "wood"};

}  // namespace

std::string_view name(ColorName color) {
  return kNames[static_cast<std::size_t>(color)];
}

std::optional<ColorName> color_named(std::string_view text) {
  const auto found = std::ranges::find(kNames, text);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<ColorName>(found - kNames.begin());
}

std::string color_list() {
  std::string list;
  for (const std::string_view one : kNames) list += (list.empty() ? "" : ", ") + std::string(one);
  return list;
}

}  // namespace sinew::vision
