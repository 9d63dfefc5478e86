#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "sinew/vision/lab.h"

namespace sinew::vision {

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

/// What people call a colour in a picture whose white is balanced; nothing for white and grey.
std::optional<ColorName> color_name(const Lab& color);

}  // namespace sinew::vision
