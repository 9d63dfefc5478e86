#pragma once

#include <span>
#include <string>

#include "sinew/devices/axis/axis_machine_loop.h"

namespace sinew::cli {

/// What one axis did in `sinew axis`.
struct AxisCurves {
  std::string name;
  sim::LoopRecord up, down;         ///< jumps of the reference
  sim::LoopRecord tracking, blind;  ///< the move, with and without feed-forward
};

/// A picture with a row for each axis: its step responses at the left, its tracking errors at the
/// right.
std::string axis_plot(const std::string& title, std::span<const AxisCurves> axes);

}  // namespace sinew::cli
