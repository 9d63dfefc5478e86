#include "sinew/program/plans/program_plan.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/error_code.h"
#include "sinew/model/joint_value.h"
#include "sinew/model/left_out.h"
#include "sinew/program/plans/order_planner.h"

namespace sinew::program {
namespace {

constexpr double kFirstMoveSpeed = 0.1;  // of a joint's top speed
constexpr double kFirstMoveMin = 2;      // s

}  // namespace

double first_move_duration(const RobotModel& robot) {
  double longest = kFirstMoveMin;
  for (const Joint& joint : robot.joints) {
    longest =
        std::max(longest, (joint.upper - joint.lower) / (kFirstMoveSpeed * joint.velocity_max));
  }
  return longest;
}

bool plannable(const Start& q, const RobotModel& robot) {
  if (!q) return false;
  bool inside = true;
  for (std::size_t i = 0; i < q->size(); ++i) {
    inside = inside && within_limits(robot.joints[i], (*q)[i]);
  }
  if (inside) return true;
  const planning::ToolSpace space(robot);
  return space.forward({q->data(), q->size()}, space.home()).has_value();
}

std::expected<JointVector, Refusal> first_target(const Step& row, const Start& q,
                                                 const RobotModel& robot) {
  const auto refused = [&](const Error& error) {
    return std::unexpected(Refusal{row.line, error, std::nullopt});
  };
  const auto* joint = std::get_if<JointStep>(&row.what);
  JointVector target;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const auto index = static_cast<std::int8_t>(i);
    const bool given = joint != nullptr && (joint->given >> i & 1) != 0;
    const bool relative = given && (joint->relative >> i & 1) != 0;
    if (!q && is_left_out(robot, i)) {
      target.push_back(assumed_place(robot.joints[i]));
      continue;
    }
    if ((!given || relative) && !q) return refused(Error{ErrorCode::kPositionUnknown, index});
    target.push_back((given ? joint->q[i] : 0) + (!given || relative ? (*q)[i] : 0));
    const Joint& limits = robot.joints[i];
    if (within_limits(limits, target[i])) continue;
    return refused(beyond_limit(limits, i, target[i]));
  }
  if (joint == nullptr) return refused(Error{ErrorCode::kPositionUnknown, 0});
  if (const auto error = WireTarget(robot).refusal({target.data(), target.size()})) {
    return refused(*error);
  }
  return target;
}

std::optional<JointVector> slow_way_back(const Step& row, const JointVector& q, const Refusal& why,
                                         const RobotModel& robot) {
  if (why.error.code != ErrorCode::kCollision) return std::nullopt;
  bool inside = true;
  for (std::size_t i = 0; i < q.size(); ++i) {
    inside = inside && within_limits(robot.joints[i], q[i]);
  }
  if (inside) return std::nullopt;
  const auto target = first_target(row, q, robot);
  return target ? std::optional(*target) : std::nullopt;
}

std::expected<Plan, Refusal> make_plan(const Program& program, const RobotModel& robot,
                                       const Standing& start, const Homing& homing,
                                       const WayLook& look) {
  OrderPlanner planner(robot, start, homing);
  if (look) planner.show_to(look);
  if (const auto refusal = planner.take_all(program)) return std::unexpected(*refusal);
  return std::move(planner.plan());
}

}  // namespace sinew::program
