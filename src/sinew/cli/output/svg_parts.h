#pragma once

#include <array>
#include <string>
#include <vector>

namespace sinew::cli {

/// Okabe and Ito's palette: told apart by readers of every kind of colour vision.
inline constexpr std::array<const char*, 8> kCurveColours{
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a6d00", "#666666"};

/// Text for an SVG element, without control characters.
std::string svg_escaped(const std::string& text);

/// A scale with round numbers on it.
struct PlotScale {
  double lower = 0;
  double upper = 1;
  double step = 1;

  std::vector<double> ticks() const;
};

/// Round numbers that hold all from `lower` to `upper`, about `ticks` of them.
PlotScale scale_for(double lower, double upper, int ticks);

/// The same, ending where the values do: ticks lie inside.
PlotScale tight_scale(double lower, double upper, int ticks);

}  // namespace sinew::cli
