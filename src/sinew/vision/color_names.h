#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sinew::vision {

/// What people call the colours of cubes.
enum class ColorName : std::uint8_t {
  kRed,
  kOrange,
  kYellow,
  kGreen,
  kBlue,
  kPurple,
  kPink,
  kBlack,
  kWood,
};
inline constexpr std::size_t kColorNames = 9;

std::string_view name(ColorName color);
std::optional<ColorName> color_named(std::string_view text);
/// All of them, for a sentence: "red, orange, ..".
std::string color_list();

}  // namespace sinew::vision
