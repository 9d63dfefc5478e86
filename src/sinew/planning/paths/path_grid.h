#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "sinew/motion/rest_to_rest.h"
#include "sinew/planning/paths/planned_path.h"

namespace sinew::planning {

/// What can hold a motion back.
enum class LimitKind : std::uint8_t {
  kJointVelocity,
  kJointAcceleration,
  kJointJerk,
  kToolSpeed,         ///< asked for
  kToolAcceleration,  ///< asked for
  kFeed,              ///< the tool speed or the joints' share was asked for, and scaled down
  kWire,              ///< what it carries for all joints together
};

struct PathLimit {
  LimitKind kind = LimitKind::kJointJerk;
  std::int8_t joint = -1;  ///< -1 for the tool's limits
  friend bool operator==(const PathLimit&, const PathLimit&) = default;
};

/// A stretch of path within which s may have any speed up to `v`, any acceleration up to +-`a` and
/// any jerk up to +-`u`, together and everywhere, without any joint or the tool beyond its limits.
struct PathCell {
  double begin = 0;     ///< s
  double v_joints = 0;  ///< what the joints' velocities allow, each and all together
  double v_tool = 0;    ///< what was asked for, at feed 1
  double v_shape = 0;   ///< what the bends of the path allow
  double v = 0;         ///< the least of the three at the present feed
  double a = 0;
  double u = 0;
  double share = 1;  ///< of the joints' velocities, asked for
  std::uint32_t piece = 0;
  std::uint32_t section = 0;
  std::int8_t velocity_joint = -1;  ///< -1: all together
  std::int8_t jerk_joint = -1;
  PathLimit shape;
  PathLimit acceleration;
};

/// The limits of every joint and of the tool, as limits of s, in cells.
///
/// Within a cell |q'|, |q''|, |q'''| have rigorous upper bounds d1, d2, d3, and the cell's numbers
/// satisfy, for each joint with the limits V, A, J:
///   d1 v <= V,   d2 v^2 + d1 a <= A,   d3 v^3 + 3 d2 v a + d1 u <= J
/// and the same of the tool; the sum of all d1 v is at most what the joints share. These are the
/// terms of qd = q' s', qdd = q'' s'^2 + q' s'' and qddd = q''' s'^3 + 3 q'' s' s'' + q' s''', each
/// with its worst sign. So a motion inside the cells holds the limits at every instant and not only
/// where somebody looks.
class PathGrid {
 public:
  explicit PathGrid(std::size_t capacity);

  /// @param shared_velocity  the sum of the joints' speeds at most.
  /// @return false: more pieces than cells. The path outlives the grid's use.
  bool build(const PlannedPath& path, std::span<const motion::AxisLimits> limits,
             double shared_velocity = std::numeric_limits<double>::infinity());
  /// Once it is known how quick each cell is passed (one number a cell): what the speed does not
  /// need is given to acceleration and jerk.
  void refine(std::span<const double> speeds);
  /// Sets every cell's `v`.
  void set_feed(double feed);
  /// What `v` of cell `i` is at a feed.
  double speed_at(std::size_t i, double feed) const;

  /// Whether some cell is not straight in joint space, so that speed costs acceleration.
  bool curved() const { return curved_; }
  std::size_t size() const { return cells_.size(); }
  std::size_t capacity() const { return cells_.capacity(); }
  double length() const { return length_; }
  double feed() const { return feed_; }
  const PathCell& operator[](std::size_t i) const { return cells_[i]; }
  double begin(std::size_t i) const { return i < size() ? cells_[i].begin : length_; }
  /// The cell in which s lies.
  std::size_t cell_at(double s) const;
  /// What holds back the speed in cell `i`.
  PathLimit speed_limit(std::size_t i) const;

 private:
  struct Bounds;
  void bound(const PathCell& cell, double end, Bounds& out) const;
  void box(const Bounds& bounds, PathCell& cell) const;
  void share_out(const Bounds& bounds, PathCell& cell) const;
  void append(PathCell cell, double end, std::size_t depth, std::size_t spare);

  const PlannedPath* path_ = nullptr;
  double length_ = 0;
  double feed_ = 1;
  bool curved_ = false;
  double cell_length_max_ = 0;
  // One over the joints' limits, 0 for lanes without a joint.
  JointArray per_velocity_{}, per_acceleration_{}, per_jerk_{};
  double per_shared_ = 0;
  std::vector<PathCell> cells_;
};

}  // namespace sinew::planning
