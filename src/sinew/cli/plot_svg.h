#pragma once

#include <string>
#include <vector>

namespace sinew::cli {

/// One curve: a name for the legend and a value for each instant.
struct Curve {
  std::string name;
  std::vector<double> values;
};

/// One box of a plot; all boxes share the time axis.
struct Panel {
  std::string title;  ///< with the unit
  std::vector<Curve> curves;
};

/// A picture of curves over time, readable on light and dark pages alike.
/// @param t_s  ascending; every curve has as many values; what is not a number is a gap.
std::string plot_svg(const std::string& title, const std::vector<double>& t_s,
                     const std::vector<Panel>& panels);

}  // namespace sinew::cli
