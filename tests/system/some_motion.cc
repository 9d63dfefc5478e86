#include "system/some_motion.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <vector>

#include "sinew/control/path_motion.h"
#include "sinew/control/piece_motion.h"
#include "sinew/planning/motion_planner.h"
#include "sinew/program/plans/program_plan.h"

namespace sinew::test {

using namespace std::chrono_literals;

std::unique_ptr<control::MotionSource> motion_to(const RobotModel& robot, const JointVector& from,
                                                 const JointVector& to) {
  planning::MotionPlanner planner(robot);
  const auto start = planner.place_at({from.data(), from.size()});
  if (!start) return nullptr;
  planning::JointArray goal{};
  std::ranges::copy(to, goal.begin());
  planning::Move move;
  move.way = planning::MoveJ{goal};
  planning::PlannedMotion planned = planner.make_motion();
  if (!planner.plan(*start, std::span(&move, 1), 0, planned) || planned.empty()) return nullptr;
  if (robot.device.capability.motion == MotionKind::kStream) {
    auto path = std::make_unique<control::PathMotion>(robot);
    if (path->start(planned.path)) return nullptr;
    return path;
  }
  JointMove whole{.q = to, .qd = {}, .duration = 0ms};
  whole.qd.resize(to.size());
  whole.duration = from_seconds(program::whole_move_duration(from, to, robot, 1));
  return std::make_unique<control::PieceMotion>(from, std::vector<JointMove>(1, whole), robot);
}

std::unique_ptr<control::MotionSource> first_motion(const RobotModel& robot) {
  JointMove move{.q = {}, .qd = {}, .duration = 3s};
  for (const Joint& joint : robot.joints) move.q.push_back(joint.home);
  move.qd.resize(robot.joints.size());
  return std::make_unique<control::PieceMotion>(JointVector{}, std::vector<JointMove>(1, move),
                                                robot);
}

}  // namespace sinew::test
