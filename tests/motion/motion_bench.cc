#include "motion/motion_bench.h"

#include <algorithm>
#include <cmath>

namespace sinew::planning {

MotionBench::MotionBench(std::string_view id)
    : robot(id),
      dealer(robot),
      planner(robot.model),
      collision(robot.model),
      limits(motion_limits(robot.model)),
      jog(id, true),
      fresh{planner.make_motion(), planner.make_motion()} {
  while (plans_.size() < kPlans) plans_.push_back({{}, planner.make_motion()});
}

double MotionBench::distance(const JointArray& q, const PoseBT& X_near) const {
  const auto X_BP = relabel<frame::Base, frame::Platform>(X_near);
  return collision.distance(joints(q), &X_BP).distance;
}

RobotPlace MotionBench::free_place(test::Random& random) const {
  RobotPlace place = robot.random_place(random);
  for (int tries = 0; tries < 50; ++tries) {
    if (distance(place.q, place.X_BT) >= collision.margin()) break;
    place = robot.random_place(random);
  }
  return place;
}

std::string MotionBench::deal_plans(test::Random& random, MotionSums& sums) {
  ready_ = 0;
  RobotPlace at = free_place(random);
  for (std::size_t k = 0; k < kPlans; ++k) {
    ReadyPlan& ready = plans_[ready_];
    const auto moves = dealer.deal(random, at);
    const auto planned = planner.plan(at, moves, 0, ready.motion);
    if (!planned) {
      sums.count(planned.error().error);
      const std::string fault = fault_of(planned.error(), moves.size(), false);
      if (!fault.empty()) return fault;
      continue;
    }
    if (ready.motion.empty()) continue;
    ++sums.plans;
    sums.blends += ready.motion.stretch.moves - 1;
    ready.from = at;
    at = ready.motion.stretch.end;
    ++ready_;
  }
  return {};
}

std::string fault_of(const Error& error, bool asked_nonsense) {
  const auto table = error_table();
  const auto row = std::find_if(table.begin(), table.end(),
                                [&](const ErrorInfo& info) { return info.code == error.code; });
  const auto code = std::to_string(static_cast<int>(error.code));
  if (row == table.end()) return "refused with " + code + ", which has no row in the table";
  const bool finite = std::isfinite(error.measured) && std::isfinite(error.limit);
  // What was asked for may stand in the refusal, as it was asked.
  if (!finite && !asked_nonsense) {
    return "refused with " + std::string(row->name) + ", " + std::to_string(error.measured) +
           " and " + std::to_string(error.limit);
  }
  if (describe(error).empty()) return "refused with " + code + " and no sentence";
  return {};
}

std::string fault_of(const PathRefusal& refusal, std::size_t moves, bool asked_nonsense) {
  const std::string fault = fault_of(refusal.error, asked_nonsense);
  if (!fault.empty()) return fault;
  const auto& [move, at, share, metres] = refusal.place;
  if (move >= moves || !(at >= 0) || !std::isfinite(at) || !(share >= 0 && share <= 1)) {
    return describe(refusal.error) + ", at move " + std::to_string(move) + ", " +
           std::to_string(at) + " m, share " + std::to_string(share);
  }
  if (refusal.nearest) {
    const auto& [R, p] = refusal.nearest->X_BT;
    bool finite = true;
    for (const Vec3& v : {p, R.x, R.y, R.z}) {
      finite = finite && std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    }
    if (!finite) {
      return describe(refusal.error) + ", and the nearest pose is none";
    }
  }
  return {};
}

}  // namespace sinew::planning
