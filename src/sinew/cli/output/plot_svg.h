#pragma once

#include <cstddef>
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

/// Pixels of a picture with so many boxes.
struct PictureSize {
  double width = 0;
  double height = 0;
};
PictureSize plot_size(std::size_t panels);

/// Pictures of one size beside and below each other, in `columns`.
std::string tiled_svg(const std::string& title, const std::vector<std::string>& pictures,
                      std::size_t columns, PictureSize size);

}  // namespace sinew::cli
