#pragma once

#include <string>
#include <vector>

#include "sinew/cli/outcome.h"
#include "sinew/model/robot_model.h"
#include "sinew/planning/move_proposal.h"
#include "sinew/planning/path_timing.h"
#include "sinew/planning/trajectory.h"

namespace sinew::cli {

/// A motion from rest to rest.
struct PlannedMotion {
  PlannedMotion(std::size_t joints, std::size_t phases_max) : path(joints), law(phases_max) {}

  planning::PlannedPath path;
  planning::TimeLaw law;
  planning::LimitTimes limits;
  std::size_t first = 0;  ///< of the moves, from 0
  planning::PathStretch stretch;
};

/// All joints and the tool at one instant of a plan.
struct PlanSample {
  double t = 0;  ///< s
  planning::JointMotion joints;
  Vec3 p_BT;  ///< m
};

struct MotionPlan {
  const RobotModel& model;
  std::vector<PlannedMotion> motions;
  double duration = 0;  ///< s
  double way = 0;       ///< m that the tool moves
  std::vector<PlanSample> samples;
};

std::string plan_text(const MotionPlan& plan);
/// With the trajectory at even steps.
Json plan_json(const MotionPlan& plan);

/// Why a way cannot be gone and where, and what would work instead.
Outcome plan_refusal(const RobotModel& model, const planning::PathRefusal& refusal,
                     const planning::MoveProposal& proposal);

}  // namespace sinew::cli
