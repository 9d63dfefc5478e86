#include "sinew/cli/output/plot_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "sinew/cli/output/svg_parts.h"
#include "sinew/cli/output/table.h"

namespace sinew::cli {
namespace {

constexpr double kWidth = 960;
constexpr double kPanelHeight = 260;
constexpr double kLeft = 64;
constexpr double kRight = 150;
constexpr double kPlotTop = 72;
constexpr double kGap = 48;
constexpr double kPlotWidth = kWidth - kLeft - kRight;

/// Zero is shown where it is not far beside the values: a leg of 268 mm has no use for it.
std::pair<double, double> range_of(const Panel& panel) {
  double lower = std::numeric_limits<double>::infinity();
  double upper = -lower;
  for (const Curve& curve : panel.curves) {
    for (const double value : curve.values) {
      if (!std::isfinite(value)) continue;
      lower = std::min(lower, value);
      upper = std::max(upper, value);
    }
  }
  if (lower > upper) return {0, 0};
  const double span = upper - lower;
  if (lower > 0 && lower < 10 * span) lower = 0;
  if (upper < 0 && -upper < 10 * span) upper = 0;
  return {lower, upper};
}

class Picture {
 public:
  Picture(const std::string& title, const std::vector<double>& t_s, std::size_t panels)
      : t_s_(t_s) {
    const double height = plot_size(panels).height;
    svg_ = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
        "height=\"{1}\" font-family=\"system-ui, sans-serif\" font-size=\"12\">\n"
        "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
        "<text x=\"{2}\" y=\"30\" font-size=\"17\" font-weight=\"600\" "
        "fill=\"#1a1a1a\">{3}</text>\n",
        kWidth, height, kLeft, svg_escaped(title));
    time_ = scale_for(0, t_s.empty() ? 1 : t_s.back(), 10);
    if (!t_s.empty()) time_.upper = t_s.back() > 0 ? t_s.back() : 1;
  }

  void add(const Panel& panel, std::size_t index) {
    const double top = kPlotTop + static_cast<double>(index) * (kPanelHeight + kGap);
    const auto [lower, upper] = range_of(panel);
    const PlotScale axis = scale_for(lower, upper, 6);
    const auto y = [&](double value) {
      return top + kPanelHeight * (axis.upper - value) / (axis.upper - axis.lower);
    };
    svg_ += fmt::format("<text x=\"{}\" y=\"{}\" fill=\"#444\">{}</text>\n", kLeft, top - 8,
                        svg_escaped(panel.title));
    for (const double value : axis.ticks()) {
      svg_ += fmt::format(
          "<path d=\"M{} {:.1f}h{}\" stroke=\"{}\"/><text x=\"{}\" y=\"{:.1f}\" "
          "text-anchor=\"end\" fill=\"#666\">{}</text>\n",
          kLeft, y(value), kPlotWidth, value == 0 ? "#999" : "#e4e4e4", kLeft - 8, y(value) + 4,
          number(value));
    }
    for (const double tick : time_.ticks()) {
      svg_ += fmt::format(
          "<path d=\"M{0:.1f} {1}v{2}\" stroke=\"#f0f0f0\"/><text x=\"{0:.1f}\" y=\"{3}\" "
          "text-anchor=\"middle\" fill=\"#666\">{4} s</text>\n",
          x(tick), top, kPanelHeight, top + kPanelHeight + 17, number(tick));
    }
    for (std::size_t i = 0; i < panel.curves.size(); ++i) add(panel.curves[i], i, top, y);
  }

  std::string finish() { return std::move(svg_) + "</svg>\n"; }

 private:
  double x(double t) const { return kLeft + kPlotWidth * t / time_.upper; }

  template <class Y>
  void add(const Curve& curve, std::size_t i, double top, const Y& y) {
    const char* colour = kCurveColours[i % kCurveColours.size()];
    std::string path;
    double drawn = -1;
    bool pen_down = false;
    for (std::size_t k = 0; k < t_s_.size(); ++k) {
      const bool known = std::isfinite(curve.values[k]);
      // One point a pixel is all that the eye gets.
      if (known && pen_down && x(t_s_[k]) < drawn + 1 && k + 1 < t_s_.size()) continue;
      drawn = x(t_s_[k]);
      if (known) {
        path += fmt::format("{}{:.1f},{:.1f} ", pen_down ? "L" : "M", drawn, y(curve.values[k]));
      }
      pen_down = known;
    }
    svg_ += fmt::format(
        "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.8\" "
        "stroke-linejoin=\"round\"/>\n",
        path, colour);
    const double legend = top + 8 + 20 * static_cast<double>(i);
    svg_ += fmt::format(
        "<path d=\"M{} {}h18\" stroke=\"{}\" stroke-width=\"3\"/><text x=\"{}\" y=\"{}\" "
        "fill=\"#333\">{}</text>\n",
        kWidth - kRight + 14, legend, colour, kWidth - kRight + 38, legend + 4,
        svg_escaped(curve.name));
  }

  const std::vector<double>& t_s_;
  PlotScale time_;
  std::string svg_;
};

}  // namespace

std::string plot_svg(const std::string& title, const std::vector<double>& t_s,
                     const std::vector<Panel>& panels) {
  Picture picture(title, t_s, panels.size());
  for (std::size_t i = 0; i < panels.size(); ++i) picture.add(panels[i], i);
  return picture.finish();
}

PictureSize plot_size(std::size_t panels) {
  return {kWidth, kPlotTop + static_cast<double>(panels) * (kPanelHeight + kGap)};
}

std::string tiled_svg(const std::string& title, const std::vector<std::string>& pictures,
                      std::size_t columns, PictureSize size) {
  constexpr double kHead = 64;
  constexpr std::string_view kRoot = "<svg ";
  const std::size_t rows = (pictures.size() + columns - 1) / columns;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
      "height=\"{1}\" font-family=\"system-ui, sans-serif\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
      "<text x=\"{2}\" y=\"44\" font-size=\"24\" font-weight=\"600\" fill=\"#1a1a1a\">{3}</text>\n",
      size.width * static_cast<double>(columns), kHead + size.height * static_cast<double>(rows),
      kLeft, svg_escaped(title));
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    svg += fmt::format("<svg x=\"{}\" y=\"{}\" ", size.width * static_cast<double>(i % columns),
                       kHead + size.height * static_cast<double>(i / columns));
    svg += pictures[i].substr(kRoot.size());
  }
  return svg + "</svg>\n";
}

}  // namespace sinew::cli
