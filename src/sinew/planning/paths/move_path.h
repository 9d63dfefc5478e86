#pragma once

#include <expected>
#include <span>
#include <vector>

#include "sinew/core/fixed_vector.h"
#include "sinew/planning/paths/move_check.h"
#include "sinew/planning/paths/move_way.h"
#include "sinew/planning/paths/way_spline.h"

namespace sinew::planning {

/// A place along a program of moves.
struct MovePlace {
  std::size_t move = 0;  ///< which one, from 0
  double at = 0;         ///< m along it, or its like where the tool hardly moves
  double share = 0;      ///< of it, 0..1
  bool metres = true;    ///< `at` counts the tool's way
};

/// Why moves cannot be made, and where.
struct PathRefusal {
  Error error;
  MovePlace place;
  /// Where another orientation would do: the nearest one that the robot can have.
  std::optional<NearestPose> nearest;
  RobotPlace from;  ///< where the robot stands before the refused move
  /// Of a contact: how near bodies would come to each other anywhere on the rest of the way, m;
  /// below 0 they overlap.
  std::optional<double> nearest_behind{};
};

/// A place near a singularity (or a joint's slow spot) where the joints cannot follow the tool's
/// asked-for speed, so that the tool slows down.
struct Slowdown {
  MovePlace place;
  double tool_speed = 0;  ///< m/s, what is left there
  PathLimit by;           ///< what does not let it go faster: a joint, or the wire
  Error near;             ///< the singularity with its measure; kSingular where none is near
};

/// Whether a singularity of ToolSpace::singularity() is what slows a tool down, and not only the
/// nearest one that there is.
bool slows_down(const Error& singularity);

/// How a corner between two moves was rounded.
struct Blend {
  std::size_t move = 0;  ///< at whose end
  double way = 0;        ///< m of its way that it takes, and as much of the next move's
};

/// A path from rest to rest, made of one or more moves.
struct PathStretch {
  std::size_t moves = 0;  ///< that it took, at least one
  RobotPlace end;
  /// The slowest place of each move that has one; the first few.
  FixedVector<Slowdown, 16> slowdowns;
};

struct BuildLimits {
  std::size_t pieces = JointPath::kPiecesMax;  ///< of one stretch
  std::size_t moves = 1024;                    ///< of one stretch
};

/// Makes paths from moves, checked over their whole length before anything is sent: reach, joint
/// limits inside the polynomials too, singularities, and all that a hexapod can refuse.
///
/// A stretch is a path with continuous q, dq/ds and d2q/ds2, which a robot goes through without a
/// stop. It ends where a move has no blend, where no blend fits, or with the last move; the next
/// stretch begins there from rest.
///
/// Holds its workspace; build() does not allocate. One builder serves one thread.
class MovePathBuilder {
 public:
  /// @param space  outlives this.
  explicit MovePathBuilder(const ToolSpace& space, const BuildLimits& limits = {});

  /// Where the robot stands at q.
  /// @param X_near  of a hexapod: its last pose, or home() of its space.
  /// @error kMoveInput, kJointLimit, kLegLength; a hexapod's
  Expected<RobotPlace> place_at(std::span<const double> q, const PoseBT& X_near) const;
  /// The same where joints may be outside of their limits, though not by more than kFarTurn.
  Expected<RobotPlace> stand_at(std::span<const double> q, const PoseBT& X_near) const;

  /// The path of moves[first] and of those that blend into each other behind it.
  /// @param start  where a joint is outside of its limits it only comes in, and only a move that is
  ///               straight in joints begins there.
  /// @param out  its content is replaced; empty where the first move goes nowhere. Its capacities
  ///             are at least the builder's limits.
  std::expected<PathStretch, PathRefusal> build(const RobotPlace& start,
                                                std::span<const Move> moves, std::size_t first,
                                                PlannedPath& out);

  /// The corners that the last build() rounded.
  std::span<const Blend> blends() const { return blends_; }
  /// Where the last build()'s move `k` begins, counted from its first, blends aside.
  const RobotPlace& corner_before(std::size_t k) const { return legs_[k].from; }

 private:
  /// One move on its way into the path.
  struct Leg {
    std::size_t move = 0;
    RobotPlace from;         ///< the corner before it
    double lead = 0;         ///< m of its way that the blend before it takes
    double blend_max = 0;    ///< m that the blend behind it may take
    std::size_t pieces = 0;  ///< of the path before it and its blend
    Slowdown slowdown{};     ///< where tool_speed > 0
    JointRoom room{};        ///< at its begin
  };
  enum class Outcome : std::uint8_t { kStop, kGoOn, kBack };
  using Result = std::expected<Outcome, PathRefusal>;

  Result add(std::span<const Move> moves, PlannedPath& out);
  void go_back(PlannedPath& out);
  std::optional<PathRefusal> find_corner(const Leg& leg, const Move& move);
  double blend_length(const Leg& leg, const Move& move) const;
  std::optional<PathRefusal> lay(Leg& leg, const Move& move, double end);
  std::optional<PathRefusal> check(const Leg& leg);
  std::optional<PathRefusal> check_speed(Leg& leg, const Move& move);
  bool join(const Leg& leg, const Move& before, PlannedPath& out);
  void append(const Leg& leg, const Move& move, double end, PlannedPath& out);
  PathRefusal refusal(const Leg& leg, const Error& error, double s) const;
  PathRefusal earliest(const Leg& leg, const WayFault& fault) const;
  PathRefusal narrowed(const Leg& leg, double good, JointArray q_good, WayFault bad,
                       std::span<const JointArray> behind) const;
  std::optional<Error> limit_broken(const JointArray& q) const;
  std::optional<Error> broken_at(const TaskPoint& point, const JointArray& q) const;
  /// What the move at hand adds, before it is joined to the path.
  const JointPath& laid() const { return way_.straight_in_joints() ? line_ : spline_.spline(); }
  std::span<const double> joints(const JointArray& q) const { return {q.data(), space_.size()}; }

  const ToolSpace& space_;
  BuildLimits limits_;
  MoveWay way_;
  MoveWay ahead_;
  WaySpline spline_;
  JointPath line_;  ///< a move that is straight in joints
  std::vector<Leg> legs_;
  std::vector<Blend> blends_;
  RobotPlace corner_;  ///< end of the last leg, blend aside
};

}  // namespace sinew::planning
