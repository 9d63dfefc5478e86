#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sinew/planning/paths/tool_space.h"

namespace sinew::planning {

/// A way shorter than this (m, turns counted by kTurnRadius) is none.
inline constexpr double kNoWay = 1e-9;

/// Where the tool shall be, as a function of the metres that it has gone: s counts the way of its
/// position, or its turn times kTurnRadius where that is longer. Infinitely often differentiable
/// along lines and arcs, twice along splines. @rt, apart from its construction.
class ToolWay {
 public:
  explicit ToolWay(TaskSpace task);

  void make_line(const TaskPoint& from, const TaskPoint& to);
  /// @error kArcCollinear
  std::optional<Error> make_arc(const TaskPoint& from, const Vec3& p_via_BT, const TaskPoint& to);
  /// A natural cubic spline of position and attitude over the chords' lengths; a point that repeats
  /// the one before it is left out.
  /// @param through  the first is where it starts; MoveSpline::kPointsMax + 1 at most.
  void make_spline(std::span<const TaskPoint> through);

  /// m; 0 where the tool stays.
  double length() const { return length_; }
  /// s counts the way of the tool's position, at least nearly everywhere.
  bool counts_metres() const { return metres_ >= 0.999 * length_; }
  /// @param s  [0, length()]
  TaskPoint at(double s) const;

 private:
  enum class Kind : std::uint8_t { kLine, kArc, kSpline };
  static constexpr std::size_t kRows = 7;
  using Row = std::array<double, kRows>;  ///< position, attitude

  double set_turn(const TaskPoint& from, const TaskPoint& to);
  void attitude_at(double share, std::array<double, 4>& attitude) const;
  TaskPoint spline_at(double s) const;

  TaskSpace task_;
  Kind kind_ = Kind::kLine;
  double length_ = 0;
  double metres_ = 0;  ///< that its position moves; of a spline along chords
  Vec3 p_from_;
  Vec3 p_to_;
  // Of the arc: its centre, the radius towards its start, the same a quarter turn on, its sweep.
  Vec3 p_centre_;
  Vec3 radius_from_;
  Vec3 radius_across_;
  double sweep_ = 0;
  // The attitude turns by turn_ (rad, half a quaternion's) from first_ towards across_; pitch and
  // roll go from first_ by across_.
  std::array<double, 4> first_{};
  std::array<double, 4> across_{};
  double turn_ = 0;
  // Of the spline: places, values and second derivatives of its knots.
  std::vector<double> knots_;
  std::vector<Row> rows_;
  std::vector<Row> curvature_;
  std::vector<double> diagonal_;
};

}  // namespace sinew::planning
