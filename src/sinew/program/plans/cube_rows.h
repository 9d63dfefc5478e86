#pragma once

#include <expected>
#include <optional>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/program/language/eyes.h"
#include "sinew/program/language/table_top.h"
#include "sinew/program/plans/program_plan.h"
#include "sinew/program/plans/row_planner.h"

/// What `pick` and `place` are made of: rows as a program could say them, chosen and planned where
/// the machine stands. Both end where they begin.
namespace sinew::program {

/// m; the edge of a cube before one was seen.
inline constexpr double kUsualCube = 25e-3;

/// Whether it can take cubes: with suction; or with jaws, of an arm whose tool stays in the plane
/// through its first axis, or one of six joints with a closed form.
bool can_pick(const RobotModel& robot);

struct CubeRows {
  std::vector<Step> steps;  ///< motions, each from stop to stop, and actions of the tool
  ToolState tool;           ///< behind them
  double duration = 0;      ///< s, predicted
  grasping::Cube cube{};    ///< that they take
  double room = kPi;        ///< rad or m, the least to a joint's limit where a row ends
  double tilt = 0;          ///< rad, of a grasp by jaws from straight down
  Vec3 p_BO{};              ///< m, of a place: where the tool releases
  /// It has a known drawback: a joint near its limit, a grasp that held nothing, or no approach
  /// from above. Any other sequence is better.
  bool is_last_resort = false;
};

/// Grasps of a cube that held nothing.
struct Tried {
  grasping::Cube cube;
  int grasps = 0;
};

/// Takes a cube that is seen: there from above, straight down, closed, up, and back. The first one
/// in order and the best grasp of it that can be planned.
/// @param standing  with known joints
/// @param row       a PickCubeStep
/// @param baskets   whose walls are kept clear of, as is what else is seen
/// @param tried     these grasps are left out while there are others
/// @error kNothingSeen; else why the first cube in order cannot be had: kOutOfReach, kCubeCovered,
///        kCubeCrowded, kCubeTooWide, kJointLimit, those of RowPlanner
std::expected<CubeRows, Refusal> rows_to_pick(RowPlanner& planner, const Standing& standing,
                                              const Step& row, const Sighting& seen,
                                              std::span<const Basket> baskets = {},
                                              const std::optional<Tried>& tried = {});

/// The same of one of them. @param which  of seen.cubes
std::expected<CubeRows, Refusal> rows_to_cube(RowPlanner& planner, const Standing& standing,
                                              const Step& row, const Sighting& seen,
                                              std::size_t which,
                                              std::span<const Basket> baskets = {});

/// Releases where the row says: there from above, straight down, open, up, and back. Where there is
/// no room above it goes there as `move` does.
/// @param standing  with known joints
/// @param row       a PlaceCubeStep
/// @param table     where its basket is looked up; null: there is none
/// @param lying     cubes in baskets: the next one goes where fewest lie
/// @param seen      what stands on the table beside what is held; null: not known. Where the row
///                  names another place than a basket, what is beside it there is not kept clear of
/// @error those of RowPlanner, kNoBasket, kBasketOutOfReach
std::expected<CubeRows, Refusal> rows_to_place(RowPlanner& planner, const Standing& standing,
                                               const Step& row, const TableTop* table = nullptr,
                                               std::span<const Vec3> lying = {},
                                               const Sighting* seen = nullptr);

/// Whether joints inside their limits bring the tool to one grasp of this cube and over it, without
/// a look at the way there.
bool in_reach(const RobotModel& robot, const Sighting& seen, std::size_t which);

/// Whether a cube lies where one was taken.
bool lies_at(const grasping::Cube& cube, const grasping::Cube& taken);
/// Whether a picture still shows a cube where one was taken.
bool still_there(const Sighting& seen, const grasping::Cube& taken);
/// Whether jaws that measure this width (m) hold the cube: closed on nothing they come nearer.
bool may_hold(const grasping::Cube& cube, double jaws);

}  // namespace sinew::program
