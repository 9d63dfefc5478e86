#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include "sinew/planning/paths/joint_path.h"
#include "sinew/planning/paths/path_grid.h"
#include "sinew/planning/paths/tool_space.h"

namespace sinew::planning {

/// A place of a path where something is wrong.
struct PathFault {
  Error error;
  double s = 0;  ///< of the path
};

/// Pieces [first, last) of a path.
struct PieceRange {
  std::size_t first = 0;
  std::size_t last = 0;
};

/// How far each joint may go: to its limits, and farther where it stands outside of them.
struct JointRoom {
  JointArray lower{};
  JointArray upper{};

  JointRoom() = default;
  JointRoom(std::span<const Joint> joints, const JointArray& q);
};

/// The first place where a joint leaves its limits, inside the polynomials too: their Bernstein
/// hulls bound them, and only where a hull sticks out it is divided. A joint that begins outside
/// may only come in, and never turns back, until it is inside. @rt
/// @param room  at the first piece's begin.
/// @return kJointLimit (kLegLength for a leg) with the joint and the farthest that it would go.
std::optional<PathFault> first_limit_break(const JointPath& path, PieceRange pieces,
                                           std::span<const Joint> joints, JointRoom room);
/// From inside.
std::optional<PathFault> first_limit_break(const JointPath& path, PieceRange pieces,
                                           std::span<const Joint> joints);

/// The first place that Hexapod::check() refuses, looked at every 2 mm (or 0.02 rad) of the
/// platform's way and then narrowed down; an angle goes no farther than 1e-5 rad beyond its limit
/// between two good places. @rt
/// @param X_first  pose at the first piece's begin; on return, at the last good place.
std::optional<PathFault> first_hexapod_refusal(const ToolSpace& space, const JointPath& path,
                                               PieceRange pieces, PoseBT& X_first);

/// Where the joints let the tool go slowest.
struct SlowestPlace {
  double s = 0;
  double rate = 0;            ///< ds/dt, m/s
  double rate_elsewhere = 0;  ///< the greatest that they allow anywhere on these pieces
  PathLimit by;               ///< what it is slow by
};

/// By the joints' velocities, each and all together (times `joint_share`), and what q'' asks of
/// their accelerations, looked at in three places of each piece. @rt
SlowestPlace slowest_place(const JointPath& path, PieceRange pieces, std::span<const Joint> joints,
                           double joint_share,
                           double shared_velocity = std::numeric_limits<double>::infinity());

}  // namespace sinew::planning
