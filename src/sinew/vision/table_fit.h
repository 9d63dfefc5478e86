#pragma once

#include <optional>
#include <vector>

#include "sinew/vision/table_camera.h"

namespace sinew::vision {

/// A cube's top of a known size, moved and turned on its plane until its sides lie where the
/// picture changes most.
struct TableFit {
  CubePosition position;
  /// Across its sides, mean, of 8-bit RGB. What is more than enough counts no more: a top and a
  /// side face below it together have a strong outline too.
  double contrast = 0;
  /// The same where the side faces below it that are seen meet the table, of the one with the
  /// least; nothing where none is seen.
  std::optional<double> foot;
  /// Whether enough of its sides is seen to say where it is: of each two that face each other one
  /// half or more.
  bool is_sure = true;
};

/// @param start   about where its top is; its level stays
/// @param edge    m
/// @param pixel   m on the top that a pixel shows
/// @param hidden  cells of grid_of() that show something else before it, where that is known
/// @return  `start` where the best place is farther away than a third of an edge
TableFit fitted_on_table(const Picture& picture, const TableCamera& camera,
                         const CubePosition& start, double edge, double pixel,
                         const std::vector<bool>& hidden);

}  // namespace sinew::vision
