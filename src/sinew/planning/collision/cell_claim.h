#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "sinew/planning/collision/cell_way.h"

/// Space in a cell: what a robot fills, now or while a motion lasts, and whether a motion would
/// come too near to what others fill. docs/collision.md.
namespace sinew::planning {

/// Space that belongs to somebody: a robot at rest, the whole of a motion, an object.
class CellClaim {
 public:
  /// Bodies that lie near each other.
  struct Group {
    CellBlock block;
    std::size_t begin = 0;
    std::size_t end = 0;
  };

  /// One more group. @param bodies  at least one
  void add(std::span<const CellBody> bodies);
  void add(const CellClaim& other);

  std::span<const CellBody> bodies() const { return bodies_; }
  std::span<const Group> groups() const { return groups_; }
  /// Around all of it.
  const CellBlock& block() const { return block_; }
  /// Bodies are where they are said to be. Else they are somewhere inside, and nobody is taken to
  /// leave them.
  bool sure = true;

 private:
  std::vector<CellBody> bodies_;
  std::vector<Group> groups_;
  CellBlock block_;
};

/// Of a claim for a motion: what a body is swollen by at most where that can be had, m. More where
/// the motion is so long that it would take more than kSweepPartsMax parts.
inline constexpr double kSweepSwell = 0.01;
inline constexpr std::size_t kSweepPartsMax = 512;
/// What a robot at rest is swollen by at most before its whole reach is taken, m.
inline constexpr double kUnsureSwell = 0.06;

/// A robot at rest, each joint somewhere in its interval.
/// @param surely  nothing but what sensors and devices leave open
CellClaim claim_of_rest(const RobotBodies& robot, const JointBox& joints, bool surely = true);
/// A robot of which nobody knows where it stands, or may go.
CellClaim claim_of_reach(const RobotBodies& robot);
/// Everything that a motion passes.
CellClaim claim_of_way(const RobotBodies& robot, const CellWay& way);
CellClaim claim_of(const CellObject& object);

/// What somebody else fills, as a motion has to respect it.
struct CellObstacle {
  const CellClaim* claim = nullptr;
  double margin = 0;  ///< m
  /// Of the links that do not count, a bit each: what stands on an object.
  std::uint32_t excused = 0;
};

/// Where a motion would come too near.
struct CellContact {
  std::size_t obstacle = 0;  ///< place among those that were given
  std::uint8_t link = 0;     ///< of who moves
  std::uint8_t other = 0;    ///< of the other robot
  double share = 0;          ///< of the way, 0..1: not before
  double distance = 0;       ///< m; minus infinity where a hexapod has no pose
  double margin = 0;         ///< m, what is asked for
  bool from_start = false;   ///< it begins there
};

/// m; what comes so near to the margin counts as at the margin.
inline constexpr double kCellResolution = 2e-4;

/// The first place of a motion at which it is nearer to an obstacle than its margin, if any. None
/// is missed, however thin: each part of the way is looked at as everything that it may pass, in
/// ever smaller parts where that is too much. What is nearer than the margin at the start and sure
/// to be there may only come apart until it is that far.
std::optional<CellContact> first_contact(const RobotBodies& robot, const CellWay& way,
                                         std::span<const CellObstacle> obstacles);

/// How near a robot at one place is to all obstacles: the nearest. Distance infinite where there
/// are none.
CellContact nearest_obstacle(const RobotBodies& robot, const JointArray& q,
                             std::span<const CellObstacle> obstacles);

/// Which links stand on or in an object, as bits: the stand, and what is joined to it; 0 where the
/// robot does not stand there.
std::uint32_t links_on(const RobotBodies& robot, const CellBody& object);

}  // namespace sinew::planning
