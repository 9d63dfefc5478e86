#include "sinew/vision/color_names.h"

#include <algorithm>
#include <array>

#include "sinew/core/units.h"

namespace sinew::vision {
namespace {

constexpr std::array<std::string_view, kColorNames> kNames{
    "red", "orange", "yellow", "green", "blue", "purple", "pink", "black", "wood"};

/// Up to which hue a name goes, deg of L*a*b*: halfway between paints and plastics that are sold by
/// these names.
struct Border {
  double hue_deg;
  ColorName name;
};
constexpr std::array<Border, 8> kBorders{{{20, ColorName::kPink},
                                          {47, ColorName::kRed},
                                          {78, ColorName::kOrange},
                                          {112, ColorName::kYellow},
                                          {215, ColorName::kGreen},
                                          {304, ColorName::kBlue},
                                          {333, ColorName::kPurple},
                                          {360, ColorName::kPink}}};

constexpr float kGrey = 14;       // chroma; what is paler has no colour
constexpr float kBlack = 28;      // lightness
constexpr float kBlackTint = 18;  // chroma of what is black all the same
constexpr float kVeryDark = 16;   // lightness
constexpr float kWoodTint = 36;   // chroma between orange and yellow: bare wood
constexpr float kPinkLight = 62;  // lightness from which a pale red is pink
constexpr float kPinkTint = 52;   // and its chroma
constexpr float kPinkDark = 42;   // lightness below which a bluish red is red

}  // namespace

std::string_view name(ColorName color) {
  return kNames[static_cast<std::size_t>(color)];
}

std::optional<ColorName> color_named(std::string_view text) {
  const auto found = std::ranges::find(kNames, text);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<ColorName>(found - kNames.begin());
}

std::optional<ColorName> color_name(const Lab& color) {
  const float tint = chroma(color);
  const bool dark = color.L < kBlack && tint < kGrey;
  if (dark || (color.L < kVeryDark && tint < kBlackTint)) return ColorName::kBlack;
  if (tint < kGrey) return std::nullopt;
  const double angle = to_deg(hue(color));
  const auto border =
      std::ranges::find_if(kBorders, [&](const Border& one) { return angle < one.hue_deg; });
  const ColorName by_hue = border != kBorders.end() ? border->name : ColorName::kPink;
  const bool pale_red = color.L > kPinkLight && tint < kPinkTint;
  switch (by_hue) {
    case ColorName::kPink:
      return color.L < kPinkDark ? ColorName::kRed : ColorName::kPink;
    case ColorName::kRed:
      return pale_red ? ColorName::kPink : ColorName::kRed;
    case ColorName::kOrange:
    case ColorName::kYellow:
      return tint < kWoodTint ? ColorName::kWood : by_hue;
    default:
      return by_hue;
  }
}

}  // namespace sinew::vision
