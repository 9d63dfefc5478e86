#include "sinew/devices/axis/axis_verb_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sinew/cli/output/plot_svg.h"
#include "sinew/cli/output/table.h"
#include "sinew/core/units.h"

namespace sinew::cli {
namespace {

constexpr double kNear = 0.25;  // deg: the neighbourhood of the target that is drawn again, larger
constexpr double kShown = 1.2;  // s of a step response, where the joint settles sooner

/// Reference minus joint, deg.
std::vector<double> errors(const sim::LoopRecord& record, std::size_t size, double widest) {
  std::vector<double> result;
  for (std::size_t i = 0; i < size; ++i) {
    const double error = to_deg(record.reference[i] - record.q[i]);
    const double gap = std::numeric_limits<double>::quiet_NaN();
    result.push_back(std::abs(error) <= widest ? error : gap);
  }
  return result;
}

std::vector<double> travelled(const std::vector<double>& values, double from, std::size_t size) {
  std::vector<double> result;
  for (std::size_t i = 0; i < size; ++i) result.push_back(to_deg(values[i] - from));
  return result;
}

std::string step_picture(const AxisCurves& axis) {
  const double settled =
      std::max(sim::step_figures(axis.up).settling, sim::step_figures(axis.down).settling);
  std::size_t size = 0;
  while (size < axis.up.t.size() && axis.up.t[size] < std::max(kShown, 1.5 * settled)) ++size;
  const std::vector<double> t(axis.up.t.begin(),
                              axis.up.t.begin() + static_cast<std::ptrdiff_t>(size));
  const Panel response{"joint, deg from where it stood",
                       {{"up", travelled(axis.up.q, axis.up.q[0], size)},
                        {"down", travelled(axis.down.q, axis.down.q[0], size)},
                        {"reference up", travelled(axis.up.reference, axis.up.q[0], size)},
                        {"reference down", travelled(axis.down.reference, axis.down.q[0], size)}}};
  const Panel close{
      "reference minus joint, near the end, deg",
      {{"up", errors(axis.up, size, kNear)}, {"down", errors(axis.down, size, kNear)}}};
  const std::string title =
      fmt::format("{}: jump of the reference; weight {} Nm, inertia {} kg m²", axis.name,
                  number(axis.up.load_torque, 2), number(axis.up.load_inertia, 4));
  return plot_svg(title, t, {response, close});
}

std::string tracking_picture(const AxisCurves& axis) {
  const std::size_t size = axis.tracking.t.size();
  const double all = std::numeric_limits<double>::infinity();
  const Panel with{"reference minus joint with feed-forward, deg",
                   {{"error", errors(axis.tracking, size, all)}}};
  const Panel without{"without feed-forward, deg", {{"error", errors(axis.blind, size, all)}}};
  return plot_svg(fmt::format("{}: move of {} deg and back", axis.name,
                              number(to_deg(*std::ranges::max_element(axis.tracking.reference) -
                                            axis.tracking.reference.back()),
                                     1)),
                  axis.tracking.t, {with, without});
}

}  // namespace

std::string axis_plot(const std::string& title, std::span<const AxisCurves> axes) {
  std::vector<std::string> pictures;
  for (const AxisCurves& axis : axes) {
    pictures.push_back(step_picture(axis));
    pictures.push_back(tracking_picture(axis));
  }
  return tiled_svg(title + ": control loops with load", pictures, 2, plot_size(2));
}

}  // namespace sinew::cli
