#pragma once

#include <optional>
#include <span>
#include <vector>

#include "sinew/planning/paths/planned_path.h"
#include "sinew/planning/paths/tool_space.h"
#include "sinew/planning/paths/tool_way.h"

namespace sinew::planning {

/// What stops a way, and where.
struct WayFault {
  Error error;
  double s = 0;  ///< m along the way
};

/// So near to its way the tool stays between the knots of a path.
inline constexpr double kPathTolerance = 5e-6;      ///< m
inline constexpr double kPathTurnTolerance = 1e-5;  ///< rad

/// Joints along a tool's way: marches along it by the inverse, and lays a C2 spline through what it
/// finds, with so many knots that the tool stays on the way. Joint limits are not looked at. Holds
/// its workspace: no allocation after construction.
class WaySpline {
 public:
  /// @param space     outlives this.
  /// @param capacity  knots at most
  WaySpline(const ToolSpace& space, std::size_t capacity);

  /// Joints along the whole way, from q_from on; what was found remains where it stops short.
  /// @error the inverse's; a singularity where the joints would have to jump; kProgramTooLong
  std::optional<WayFault> march(const ToolWay& way, const JointArray& q_from);
  /// Keeps what lies between `from` and `to` (m along the way), and finds the rates at both ends.
  std::optional<WayFault> cut(const ToolWay& way, double from, double to);
  /// Adds knots until the spline keeps to kPathTolerance and kPathTurnTolerance.
  /// @error a singularity where no number of knots is enough; kProgramTooLong
  std::optional<WayFault> fit(const ToolWay& way);

  /// Where on its way it begins, and how long it is, m.
  double begin() const { return begin_; }
  double length() const { return knots_.back(); }
  /// From 0 on; points and rates beside them.
  std::span<const double> knots() const { return knots_; }
  std::span<const JointArray> points() const { return points_; }
  /// The spline that fit() found, from s = 0 on; one rate a piece.
  const JointPath& spline() const { return spline_; }
  std::span<const ToolRate> rates() const { return rates_; }
  bool append_to(JointPath& path) const {
    return path.append_spline(knots_, points_, dq_first_, dq_last_);
  }

 private:
  std::optional<WayFault> place(const ToolWay& way, double s, const JointArray& q_near,
                                JointArray& q) const;
  std::optional<WayFault> end_rate(const ToolWay& way, double s, const JointArray& q, double reach,
                                   JointArray& dq) const;
  WayFault too_long(double s) const;
  WayFault singular_at(const ToolWay& way, double s, const JointArray& q) const;
  bool follows(const ToolWay& way, std::size_t piece, PoseBT& X_near);
  std::optional<WayFault> split(const ToolWay& way);

  const ToolSpace& space_;
  std::size_t capacity_;
  double begin_ = 0;
  std::vector<double> knots_;
  std::vector<JointArray> points_;
  JointArray dq_first_{};
  JointArray dq_last_{};
  JointPath spline_;
  std::vector<ToolRate> rates_;
  // Workspace of fit(): which pieces do not follow their way, and the knots of the next round.
  std::vector<char> off_;
  std::vector<double> knots_next_;
  std::vector<JointArray> points_next_;
};

}  // namespace sinew::planning
