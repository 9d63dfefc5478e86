#include "sinew/cli/output/plan_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <ranges>
#include <utility>
#include <vector>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/svg_parts.h"
#include "sinew/cli/output/table.h"
#include "sinew/kinematics/hexapod.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/planning/paths/tool_space.h"

namespace sinew::cli {
namespace {

constexpr double kMargin = 64;
constexpr double kColumn = 268;
constexpr double kBoxWidth = 206;
constexpr double kBoxHeight = 120;
constexpr double kRow = 158;
constexpr double kTop = 96;
constexpr double kView = 340;
constexpr std::size_t kRows = 4;
constexpr const char* kShade = "#f6d5c3";
constexpr const char* kStart = "#009e73";
constexpr const char* kEnd = "#d55e00";

struct Box {
  double x = 0;
  double y = 0;
  double width = 0;
  double height = 0;
};

/// What one box of the grid shows: values in deg or mm and per second powers, and where its limits
/// are.
struct Row {
  const char* name;
  planning::JointArray planning::JointMotion::* values;
};
constexpr std::array<Row, kRows> kGrid{{{"position", &planning::JointMotion::q},
                                        {"velocity", &planning::JointMotion::qd},
                                        {"acceleration", &planning::JointMotion::qdd},
                                        {"jerk", &planning::JointMotion::qddd}}};

std::pair<double, double> limits_of(const Joint& joint, std::size_t row) {
  const std::array<double, kRows> upper{joint.upper, joint.velocity_max, joint.acceleration_max,
                                        joint.jerk_max};
  return {row == 0 ? joint.lower : -upper[row], upper[row]};
}

/// s
double end_of(const MotionPlan& plan) {
  return plan.samples.empty() ? 0 : plan.samples.back().t;
}

class Drawing {
 public:
  Drawing(const MotionPlan& plan, const std::string& title) : plan_(plan) {
    const auto joints = static_cast<double>(plan.model.joints.size());
    width_ = std::max(kMargin + joints * kColumn, kMargin + 3 * (kView + 60));
    const double height = kTop + kRows * kRow + kView + 90;
    svg_ = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
        "height=\"{1}\" font-family=\"system-ui, sans-serif\" font-size=\"11\">\n"
        "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
        "<text x=\"{2}\" y=\"34\" font-size=\"19\" font-weight=\"600\" "
        "fill=\"#1a1a1a\">{3}</text>\n"
        "<text x=\"{2}\" y=\"56\" font-size=\"13\" fill=\"#555\">{4} s, {5} mm of tool way; "
        "shaded: "
        "outside of a joint's limits</text>\n",
        width_, height, kMargin, svg_escaped(title), number(end_of(plan), 2),
        number(plan.way * 1e3, 0));
  }

  void joint(std::size_t j) {
    const Joint& joint = plan_.model.joints[j];
    const double x = kMargin + static_cast<double>(j) * kColumn;
    svg_ += fmt::format(
        "<text x=\"{}\" y=\"{}\" font-size=\"14\" font-weight=\"600\" fill=\"{}\">{}</text>\n", x,
        kTop - 14, kCurveColours[j % kCurveColours.size()], svg_escaped(joint.name));
    for (std::size_t row = 0; row < kRows; ++row) {
      curve(j, row, {x, kTop + 8 + static_cast<double>(row) * kRow, kBoxWidth, kBoxHeight});
    }
  }

  /// The tool's way, one axis against another at one scale for all views.
  void view(std::size_t index, const std::string& name, double Vec3::* across, double Vec3::* up) {
    const Box box = view_box(index);
    const auto middle = [&](double Vec3::* axis) {
      const auto [low, high] = range(axis);
      return (low + high) / 2;
    };
    const double half = largest_range() / 2 * 1.15;
    const double pixels = box.width / (2 * half);
    const auto x = [&](const Vec3& p) {
      return box.x + box.width / 2 + (p.*across - middle(across)) * pixels;
    };
    const auto y = [&](const Vec3& p) {
      return box.y + box.height / 2 - (p.*up - middle(up)) * pixels;
    };
    frame(box, fmt::format("tool, {} (mm)", name));
    ticks(box, 1e3 * (middle(across) - half), 1e3 * (middle(across) + half), true);
    ticks(box, 1e3 * (middle(up) - half), 1e3 * (middle(up) + half), false);
    std::string path;
    for (const PlanSample& sample : plan_.samples) {
      path +=
          fmt::format("{}{:.1f},{:.1f} ", path.empty() ? "M" : "L", x(sample.p_BT), y(sample.p_BT));
    }
    svg_ += fmt::format(
        "<path d=\"{}\" fill=\"none\" stroke=\"#0072b2\" stroke-width=\"2\" "
        "stroke-linejoin=\"round\"/>\n",
        path);
    dot(x(plan_.samples.front().p_BT), y(plan_.samples.front().p_BT), kStart);
    dot(x(plan_.samples.back().p_BT), y(plan_.samples.back().p_BT), kEnd);
    both_ends(box);
  }

  /// Base, legs and platform at both ends of the path, obliquely: y goes into the page, at half its
  /// length.
  void platform(std::size_t index, const HexapodGeometry& geometry) {
    struct Stand {
      const char* colour;
      std::array<Vec3, kLegs> anchors;
    };
    const kinematics::Hexapod hexapod(geometry);
    std::vector<Stand> stands;
    auto X_BP = geometry.X_BP_home;
    for (const PlanSample& sample : plan_.samples) {
      JointVector legs;
      for (std::size_t leg = 0; leg < kLegs; ++leg) legs.push_back(sample.joints.q[leg]);
      const auto there = hexapod.forward(legs, X_BP);
      if (!there) return;
      X_BP = there->X_BP;
      const bool last = &sample == &plan_.samples.back();
      if (!last && &sample != &plan_.samples.front()) continue;
      Stand stand{last ? kEnd : kStart, {}};
      for (std::size_t leg = 0; leg < kLegs; ++leg) {
        stand.anchors[leg] = X_BP * geometry.p_PA[leg];
      }
      stands.push_back(stand);
    }
    constexpr double kDepth = 0.5 * std::numbers::sqrt2 / 2;
    const auto across = [&](const Vec3& p) { return p.x + kDepth * p.y; };
    const auto up = [&](const Vec3& p) { return p.z + kDepth * p.y; };
    std::vector<Vec3> all(geometry.p_BA.begin(), geometry.p_BA.end());
    for (const Stand& stand : stands) {
      all.insert(all.end(), stand.anchors.begin(), stand.anchors.end());
    }
    const auto [left, right] = std::ranges::minmax(all | std::views::transform(across));
    const auto [low, high] = std::ranges::minmax(all | std::views::transform(up));
    const Box box = view_box(index);
    const double pixels = box.width / (1.15 * std::max(right - left, high - low));
    const auto point = [&](const Vec3& p) {
      return fmt::format("{:.1f},{:.1f} ",
                         box.x + box.width / 2 + (across(p) - (left + right) / 2) * pixels,
                         box.y + box.height / 2 - (up(p) - (low + high) / 2) * pixels);
    };
    const auto ring = [&](const std::array<Vec3, kLegs>& anchors, const char* colour) {
      std::string points;
      for (const Vec3& anchor : anchors) points += point(anchor);
      svg_ += fmt::format(
          "<polygon points=\"{}\" fill=\"{}\" fill-opacity=\"0.12\" stroke=\"{}\" "
          "stroke-width=\"2\" stroke-linejoin=\"round\"/>\n",
          points, colour, colour);
    };
    frame(box, "oblique: x across, z up, y into the page");
    ring(geometry.p_BA, "#777");
    for (const Stand& stand : stands) {
      std::string legs;
      for (std::size_t leg = 0; leg < kLegs; ++leg) {
        legs += "M" + point(geometry.p_BA[leg]) + "L" + point(stand.anchors[leg]);
      }
      svg_ += fmt::format(
          "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.4\" "
          "stroke-opacity=\"0.7\"/>\n",
          legs, stand.colour);
      ring(stand.anchors, stand.colour);
    }
    both_ends(box);
  }

  std::string finish() { return std::move(svg_) + "</svg>\n"; }

 private:
  static Box view_box(std::size_t index) {
    return {kMargin + static_cast<double>(index) * (kView + 60), kTop + kRows * kRow + 34, kView,
            kView};
  }

  void both_ends(const Box& box) {
    legend(box.x + box.width - 84, box.y - 11, kStart, "start");
    legend(box.x + box.width - 32, box.y - 11, kEnd, "end");
  }

  std::pair<double, double> range(double Vec3::* axis) const {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const PlanSample& sample : plan_.samples) {
      low = std::min(low, sample.p_BT.*axis);
      high = std::max(high, sample.p_BT.*axis);
    }
    return {low, high};
  }
  double largest_range() const {
    double largest = 1e-3;
    for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      const auto [low, high] = range(axis);
      largest = std::max(largest, high - low);
    }
    return largest;
  }

  void frame(const Box& box, const std::string& title) {
    svg_ += fmt::format(
        "<text x=\"{0}\" y=\"{1}\" fill=\"#444\">{2}</text>\n"
        "<rect x=\"{0}\" y=\"{3}\" width=\"{4}\" height=\"{5}\" fill=\"none\" stroke=\"#bbb\"/>\n",
        box.x, box.y - 7, svg_escaped(title), box.y, box.width, box.height);
  }

  void dot(double x, double y, const char* colour) {
    svg_ +=
        fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5\" fill=\"{}\" stroke=\"#fff\"/>\n",
                    x, y, colour);
  }

  void legend(double x, double y, const char* colour, const char* name) {
    dot(x, y, colour);
    svg_ += fmt::format("<text x=\"{}\" y=\"{}\" fill=\"#444\">{}</text>\n", x + 8, y + 4, name);
  }

  void ticks(const Box& box, double lower, double upper, bool across) {
    const PlotScale scale = tight_scale(lower, upper, across ? 5 : 4);
    for (const double value : scale.ticks()) {
      const double at = (value - lower) / (upper - lower);
      if (across) {
        const double x = box.x + at * box.width;
        svg_ += fmt::format(
            "<path d=\"M{0:.1f} {1}v{2}\" stroke=\"#eee\"/><text x=\"{0:.1f}\" y=\"{3}\" "
            "text-anchor=\"middle\" fill=\"#666\">{4}</text>\n",
            x, box.y, box.height, box.y + box.height + 14, number(value));
      } else {
        const double y = box.y + (1 - at) * box.height;
        svg_ += fmt::format(
            "<path d=\"M{0} {1:.1f}h{2}\" stroke=\"{3}\"/><text x=\"{4}\" y=\"{5:.1f}\" "
            "text-anchor=\"end\" fill=\"#666\">{6}</text>\n",
            box.x, y, box.width, value == 0 ? "#aaa" : "#eee", box.x - 6, y + 4, number(value));
      }
    }
  }

  void shade(const Box& box, double from, double to) {
    const double top = std::clamp(1 - to, 0.0, 1.0);
    const double bottom = std::clamp(1 - from, 0.0, 1.0);
    if (bottom <= top) return;
    svg_ += fmt::format(
        "<rect x=\"{}\" y=\"{:.1f}\" width=\"{}\" height=\"{:.1f}\" fill=\"{}\"/>\n", box.x,
        box.y + top * box.height, box.width, (bottom - top) * box.height, kShade);
  }

  void curve(std::size_t j, std::size_t row, const Box& box) {
    const Joint& joint = plan_.model.joints[j];
    const auto values = kGrid[row].values;
    const auto [limit_low, limit_high] = limits_of(joint, row);
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const PlanSample& sample : plan_.samples) {
      low = std::min(low, (sample.joints.*values)[j]);
      high = std::max(high, (sample.joints.*values)[j]);
    }
    if (row > 0) {
      low = 1.2 * limit_low;
      high = 1.2 * limit_high;
    } else {
      // A joint that hardly moves is not blown up to fill its box.
      const double room = std::max(0.15 * (high - low), 0.01 * (limit_high - limit_low));
      low -= room;
      high += room;
    }
    const auto share = [&](double value) { return (value - low) / (high - low); };
    shade(box, 0, share(limit_low));
    shade(box, share(limit_high), 1);
    const char* unit = shown_unit(joint);
    constexpr std::array<const char*, kRows> kPer{"", "/s", "/s²", "/s³"};
    ticks(box, shown_value(low, joint), shown_value(high, joint), false);
    ticks(box, 0, std::max(end_of(plan_), 1e-3), true);
    frame(box, fmt::format("{}, {}{}{}", kGrid[row].name, unit, kPer[row],
                           row + 1 == kRows ? "; time in s" : ""));
    std::string path;
    double drawn = -1;
    for (const PlanSample& sample : plan_.samples) {
      const double x = box.x + box.width * sample.t / std::max(end_of(plan_), 1e-3);
      const bool last = &sample == &plan_.samples.back();
      if (x < drawn + 0.5 && !last) continue;
      drawn = x;
      path += fmt::format("{}{:.1f},{:.1f} ", path.empty() ? "M" : "L", x,
                          box.y + (1 - share((sample.joints.*values)[j])) * box.height);
    }
    svg_ += fmt::format(
        "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\" "
        "stroke-linejoin=\"round\"/>\n",
        path, kCurveColours[j % kCurveColours.size()]);
  }

  const MotionPlan& plan_;
  double width_ = 0;
  std::string svg_;
};

/// What a view along the other one of the two axes is called: an arm's front is where its tool is
/// at home. Nothing for a robot whose tool stands above its base.
std::string seen_from(const RobotModel& model, bool x_across) {
  const planning::ToolSpace tool(model);
  const JointVector q = home_joints(model);
  const auto X_BT = tool.forward({q.data(), q.size()}, tool.home());
  if (tool.hexapod() != nullptr || !X_BT) return "";
  const bool x_forward = std::abs(X_BT->p.x) >= std::abs(X_BT->p.y);
  return x_across == x_forward ? "from the side: " : "from the front: ";
}

}  // namespace

std::string plan_svg(const MotionPlan& plan, const std::string& title) {
  Drawing drawing(plan, title);
  if (plan.samples.empty()) return drawing.finish();
  for (std::size_t j = 0; j < plan.model.joints.size(); ++j) drawing.joint(j);
  drawing.view(0, seen_from(plan.model, true) + "x across, z up", &Vec3::x, &Vec3::z);
  drawing.view(1, seen_from(plan.model, false) + "y across, z up", &Vec3::y, &Vec3::z);
  drawing.view(2, "from above: x across, y up", &Vec3::x, &Vec3::y);
  if (const auto* platform = std::get_if<HexapodGeometry>(&plan.model.geometry)) {
    drawing.platform(3, *platform);
  }
  return drawing.finish();
}

}  // namespace sinew::cli
