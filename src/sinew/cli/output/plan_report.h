#pragma once

#include <string>
#include <vector>

#include "sinew/cli/output/outcome.h"
#include "sinew/model/robot_model.h"
#include "sinew/planning/timing/path_timing.h"
#include "sinew/planning/timing/trajectory.h"
#include "sinew/program/plans/program_load.h"
#include "sinew/program/plans/program_plan.h"

namespace sinew::cli {

/// What a plan tells of one motion from rest to rest, or of the search for the joints' zeros.
struct MotionSummary {
  int first = 0;  ///< move from 1, or line of the program
  int last = 0;
  std::string what{};     ///< beside the number: "home", "to home"; mostly empty
  std::size_t times = 1;  ///< that it is made, in loops
  double at_most = 0;     ///< s, of a search; then nothing else is known
  double length = 0;      ///< m of the tool's way, with its blends
  double duration = 0;    ///< s, as the limits and the wire's speed allow
  double by_limits = 0;   ///< s, as the limits alone would allow
  double on_wire = 0;     ///< s, as the device takes it
  std::size_t pieces = 0;
  planning::LimitTimes limits{};
  std::vector<std::string> notes{};
};

/// All joints and the tool at one instant of a plan.
struct PlanSample {
  double t = 0;  ///< s
  planning::JointMotion joints;
  Vec3 p_BT;  ///< m
};

/// The joint whose drive is loaded most on the way, without payload.
struct HeaviestLoad {
  std::size_t joint = 0;
  program::JointLoad load;
};

struct MotionPlan {
  const RobotModel& model;
  std::vector<MotionSummary> motions;
  std::string rows = "moves";        ///< what first and last count: "moves" or "lines"
  double duration = 0;               ///< s, as the limits and the wire allow
  double sampled = 0;                ///< s, of the samples: where a device takes whole moves, as
                                     ///< it makes them, else the same
  double by_limits = 0;              ///< s, as the limits alone would allow
  double on_wire = 0;                ///< s, as the device takes it, the search of homing aside
  double homing_max = 0;             ///< s, of all homing, the way home behind it not counted
  std::vector<std::string> notes{};  ///< of all of it
  double way = 0;                    ///< m that the tool moves
  std::vector<PlanSample> samples;
  std::optional<HeaviestLoad> heaviest;  ///< nothing where the robot's file has no masses or drives
};

/// What its rows ask for and the device cannot be told, each in a sentence.
/// @param heard  "is" before, "was" behind a run
std::vector<std::string> unheard_notes(const program::Plan& orders, const RobotModel& model,
                                       const char* heard);

std::string plan_text(const MotionPlan& plan);
/// With the trajectory at even steps.
Json plan_json(const MotionPlan& plan);

/// "at 40 mm (25 %) the joints allow no more than 12 mm/s", and what is near.
std::string slowdown_text(const planning::Slowdown& slowdown, const RobotModel& model);

/// "at 40 mm (25 %)"; turns and joints' ways have no millimetres.
std::string place_text(const planning::MovePlace& place);
/// How near bodies come behind there, m, and how far it is to the target: "; on the rest ..".
std::string behind_text(double nearest, const planning::MovePlace& place);

/// Why a way cannot be gone and where, and what would work instead.
/// @param file  whose line refuses; empty where it is a move of the command line
Outcome plan_refusal(const RobotModel& model, const std::string& file,
                     const program::Refusal& refusal);

}  // namespace sinew::cli
