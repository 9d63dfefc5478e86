#pragma once

#include <expected>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "sinew/program/plans/cube_rows.h"
#include "sinew/program/plans/program_plan.h"

/// What programs would do with the cubes that are seen now: planned as a run plans, nothing moves.
namespace sinew::program {

/// One order of a plan as it would be carried out.
struct Foreseen {
  const Order& order;
  const Standing& from;          ///< before it, with known joints where `rows` are
  const CubeRows* rows;          ///< of a `pick` or `place`; null of all others
  const Refusal* why = nullptr;  ///< of a `pick` or `place` that cannot be
};
/// @return  what ends it
using ForeseenLook = std::function<std::expected<void, Refusal>(const Foreseen&)>;

/// Follows a plan: what asks for cubes is decided by those that are seen (Program::table), of
/// other conditions both branches are shown, one behind the other. Where nothing was seen, an `if
/// seen` holds, a `repeat` has one round, and `pick` is shown without rows.
/// @return  the cubes that are left on the table then; what `look` has ended it with
std::expected<std::vector<grasping::Cube>, Refusal> foresee(const Plan& plan,
                                                            const Program& program,
                                                            RowPlanner& planner,
                                                            const Standing& start,
                                                            const ForeseenLook& look);

/// Whether one cube of those that are seen can be had as they lie now, and how.
struct CubeVerdict {
  std::size_t which = 0;  ///< of Sighting::cubes
  std::expected<CubeRows, Refusal> rows;
};
/// In the order in which `pick` takes them.
/// @param standing  with known joints
/// @param baskets   as rows_to_pick() has them
std::vector<CubeVerdict> judge_cubes(RowPlanner& planner, const Standing& standing,
                                     const Sighting& seen, std::span<const Basket> baskets = {});

/// How a cube of this edge can be taken that lies alone on a surface, its sides turned to the
/// robot.
enum class Grasp : std::uint8_t { kNone, kTilted, kStraightDown };
/// @param standing  with known joints  @param p_BO  m, the middle of its body
Grasp best_grasp(RowPlanner& planner, const Standing& standing, const Vec3& p_BO, double edge);

/// What a person can do about a cube that cannot be had; empty where that is not known.
std::string_view help_with_cube(ErrorCode why);

}  // namespace sinew::program
