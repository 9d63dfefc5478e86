#include "sinew/program/plans/foresight.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/grasping/grasps.h"
#include "sinew/model/hand.h"

namespace sinew::program {
namespace {

/// A straight-down grasp, as far as it is tilted at most.
constexpr double kStraight = from_deg(1);

class Walk {
 public:
  Walk(const Plan& plan, const Program& program, RowPlanner& planner, const Standing& start,
       const ForeseenLook& look)
      : plan_(plan), table_(program.table.get()), planner_(planner), at_(start), look_(look) {
    if (table_ != nullptr && table_->seen) seen_ = table_->seen;
    if (!seen_) return;
    lying_ = lying_in(baskets_on(table_), {}, seen_->in_baskets);
  }

  std::expected<std::vector<grasping::Cube>, Refusal> go() {
    std::size_t next = 0;
    while (next < plan_.orders.size()) {
      const Order& order = plan_.orders[next++];
      if (const auto* jump = std::get_if<JumpOrder>(&order.what)) {
        if (std::erase(jumps_, next - 1) > 0) next = jump->to;
        continue;
      }
      const auto* branch = std::get_if<BranchOrder>(&order.what);
      if (branch != nullptr && branch->condition.subject == Condition::Subject::kSeen) {
        next = decide(order, *branch, next);
        continue;
      }
      if (const auto done = take(order); !done) return std::unexpected(done.error());
    }
    return seen_ ? seen_->cubes : std::vector<grasping::Cube>{};
  }

 private:
  std::size_t decide(const Order& order, const BranchOrder& branch, std::size_t next) {
    const Step row{order.line, PickCubeStep{branch.condition.color}, order.file};
    const bool holds =
        seen_ && at_.q ? rows_to_pick(planner_, at_, row, *seen_, baskets_on(table_)).has_value()
                       : order.round == 1;
    if (!holds) return branch.otherwise;
    // Before an `else` there is a jump behind it.
    const std::size_t last = branch.otherwise - 1;
    if (std::holds_alternative<JumpOrder>(plan_.orders[last].what)) jumps_.push_back(last);
    return next;
  }

  std::expected<void, Refusal> take(const Order& order) {
    if (const auto* pick = std::get_if<PickOrder>(&order.what)) return take_pick(order, *pick);
    if (const auto* place = std::get_if<PlaceOrder>(&order.what)) return take_place(order, *place);
    const auto looked = look_({order, at_, nullptr});
    if (const auto* move = std::get_if<MoveOrder>(&order.what)) at_.q = move->q;
    if (const auto* tool = std::get_if<ToolOrder>(&order.what)) {
      const auto* jaws = std::get_if<JawsTo>(&tool->action);
      if (jaws != nullptr) at_.tool = {jaws->width, jaws->held};
    }
    return looked;
  }

  std::expected<void, Refusal> take_pick(const Order& order, const PickOrder& pick) {
    if (!seen_ || !at_.q) {
      if (jaws_of(planner_.robot()) != nullptr) at_.tool = {kUsualCube, kUsualCube};
      return look_({order, at_, nullptr});
    }
    const Step row{order.line, pick.row, order.file};
    const auto rows = rows_to_pick(planner_, at_, row, *seen_, baskets_on(table_));
    if (!rows) return look_({order, at_, nullptr, &rows.error()});
    const auto looked = look_({order, at_, &*rows});
    at_.tool = rows->tool;
    at_.at_cup = rows->cube.edge;
    std::erase_if(seen_->cubes,
                  [&](const grasping::Cube& one) { return one.p_BO == rows->cube.p_BO; });
    return looked;
  }

  std::expected<void, Refusal> take_place(const Order& order, const PlaceOrder& place) {
    if (!at_.q) return look_({order, at_, nullptr});
    const auto rows = rows_to_place(planner_, at_, {order.line, place.row, order.file}, table_,
                                    lying_, seen_ ? &*seen_ : nullptr);
    if (!rows) return look_({order, at_, nullptr, &rows.error()});
    const auto looked = look_({order, at_, &*rows});
    at_.tool = rows->tool;
    if (std::holds_alternative<BasketGoal>(place.row.there)) lying_.push_back(rows->p_BO);
    return looked;
  }

  const Plan& plan_;
  const TableTop* table_;
  RowPlanner& planner_;
  Standing at_;
  const ForeseenLook& look_;
  std::optional<Sighting> seen_;
  std::vector<Vec3> lying_;
  std::vector<std::size_t> jumps_;  ///< orders, that are taken
};

}  // namespace

std::expected<std::vector<grasping::Cube>, Refusal> foresee(const Plan& plan,
                                                            const Program& program,
                                                            RowPlanner& planner,
                                                            const Standing& start,
                                                            const ForeseenLook& look) {
  return Walk(plan, program, planner, start, look).go();
}

std::vector<CubeVerdict> judge_cubes(RowPlanner& planner, const Standing& standing,
                                     const Sighting& seen, std::span<const Basket> baskets) {
  std::vector<CubeVerdict> verdicts;
  const Step row{0, PickCubeStep{}};
  for (const std::size_t which : grasping::order_of(seen.cubes)) {
    verdicts.push_back({which, rows_to_cube(planner, standing, row, seen, which, baskets)});
  }
  return verdicts;
}

Grasp best_grasp(RowPlanner& planner, const Standing& standing, const Vec3& p_BO, double edge) {
  const Sighting alone{.cubes = {{p_BO, std::atan2(p_BO.y, p_BO.x), edge}}};
  if (!in_reach(planner.robot(), alone, 0)) return Grasp::kNone;
  const auto rows = rows_to_cube(planner, standing, {0, PickCubeStep{}}, alone, 0);
  if (!rows) return Grasp::kNone;
  return rows->tilt <= kStraight ? Grasp::kStraightDown : Grasp::kTilted;
}

std::string_view help_with_cube(ErrorCode why) {
  switch (why) {
    case ErrorCode::kOutOfReach:
    case ErrorCode::kJointLimit:
      return "move it nearer to the middle of the reachable region";
    case ErrorCode::kTooClose:
      return "move it away from the robot";
    case ErrorCode::kCubeCrowded:
      return "move it away from its neighbours, or pick them first";
    case ErrorCode::kCubeCovered:
      return "pick the cube that stands on it first";
    case ErrorCode::kCubeTooWide:
      return "pick it by hand, or give cube_mm of the camera its real size";
    case ErrorCode::kCollision:
    case ErrorCode::kCellContact:
    case ErrorCode::kJawsContact:
      return "move it away from what stands beside it";
    case ErrorCode::kCellTaken:
      return "wait until the other robot has moved away";
    default:
      return {};
  }
}

}  // namespace sinew::program
