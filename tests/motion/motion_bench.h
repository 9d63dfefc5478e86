#pragma once

#include <array>
#include <memory>

#include "motion/motion_sums.h"
#include "motion/random_moves.h"
#include "sinew/planning/collision/collision.h"
#include "sinew/planning/jog/jog_test_robot.h"
#include "sinew/planning/motion_planner.h"
#include "sinew/planning/timing/path_follower.h"

namespace sinew::planning {

/// A plan that several sequences begin with: planning is what costs most.
struct ReadyPlan {
  RobotPlace from;
  PlannedMotion motion;
};

/// One robot and all that moves it, made once; sequences run on it one after the other.
class MotionBench {
 public:
  explicit MotionBench(std::string_view id);

  /// New plans for the sequences that come next, from this randomness alone.
  /// @return what is wrong with a refusal; empty where nothing is
  std::string deal_plans(test::Random& random, MotionSums& sums);
  std::span<const ReadyPlan> plans() const { return {plans_.data(), ready_}; }

  /// Somewhere that the robot can be, away from everything by its margin where it finds that.
  RobotPlace free_place(test::Random& random) const;
  double distance(const JointArray& q, const PoseBT& X_near) const;
  std::span<const double> joints(const JointArray& q) const { return robot.joints(q); }

  PathRobot robot;
  MoveDealer dealer;
  MotionPlanner planner;
  CollisionModel collision;
  std::vector<motion::AxisLimits> limits;
  PathFollower follower;
  JogRun jog;
  /// For plans that one sequence makes: one under way, the other to plan into.
  std::array<PlannedMotion, 2> fresh;

 private:
  static constexpr std::size_t kPlans = 3;
  std::vector<ReadyPlan> plans_;
  std::size_t ready_ = 0;
};

/// What is wrong with a refusal: a code without a row, a number that is none though none was asked
/// for, a place outside of what was asked. Empty where nothing is.
std::string fault_of(const Error& error, bool asked_nonsense);
std::string fault_of(const PathRefusal& refusal, std::size_t moves, bool asked_nonsense);

}  // namespace sinew::planning
