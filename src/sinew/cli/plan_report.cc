#include "sinew/cli/plan_report.h"

#include <fmt/format.h>

#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/table.h"
#include "sinew/core/units.h"

namespace sinew::cli {
namespace {

using planning::LimitKind;
using planning::PathLimit;

std::string limit_text(const PathLimit& limit, const RobotModel& model) {
  const std::string joint =
      limit.joint < 0 ? "" : model.joints[static_cast<std::size_t>(limit.joint)].name + "'s ";
  switch (limit.kind) {
    case LimitKind::kJointVelocity:
      return joint + "velocity";
    case LimitKind::kJointAcceleration:
      return joint + "acceleration";
    case LimitKind::kJointJerk:
      return joint + "jerk";
    case LimitKind::kToolSpeed:
      return "the tool speed asked for";
    case LimitKind::kToolAcceleration:
      return "the tool acceleration asked for";
    case LimitKind::kFeed:
      break;
  }
  return "the feed";
}

/// "1", or "2..4".
std::string moves_text(const PlannedMotion& motion) {
  const std::size_t last = motion.first + motion.stretch.moves;
  return last == motion.first + 1 ? fmt::format("{}", last)
                                  : fmt::format("{}..{}", motion.first + 1, last);
}

double share(const PlannedMotion& motion) {
  const double total = motion.limits.total();
  return total > 0 ? motion.limits.of(motion.limits.largest()) / total : 0;
}

/// The singularity is what slows the tool, and not only the nearest one that there is.
bool is_near(const Error& singularity) {
  constexpr double kNearSine = 0.2;
  constexpr double kNearDistance = 0.03;  // m
  const bool distance = singularity.code == ErrorCode::kShoulderSingular;
  return singularity.measured < (distance ? kNearDistance : kNearSine);
}

std::string slowdown_text(const planning::Slowdown& slowdown, const RobotModel& model) {
  const std::string place =
      fmt::format("move {}: at {} mm ({} %) the joints allow no more than {} mm/s",
                  slowdown.place.move + 1, number(slowdown.place.at * 1e3, 1),
                  number(slowdown.place.share * 100, 1), number(slowdown.tool_speed * 1e3, 1));
  return is_near(slowdown.near) ? place + "; " + error_text(slowdown.near, model) : place;
}

Json values(const planning::JointArray& array, const RobotModel& model) {
  Json json = Json::array();
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    json.push_back(shown(array[j], model.joints[j]));
  }
  return json;
}

Json limit_json(const PlannedMotion& motion, const RobotModel& model) {
  const PathLimit limit = motion.limits.largest();
  return {{"by", limit_text(limit, model)}, {"share_of_time", share(motion)}};
}

std::string joints_option(const planning::JointArray& q, const RobotModel& model) {
  std::string text;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    text += (j > 0 ? "," : "") + number(shown(q[j], model.joints[j]));
  }
  return text;
}

}  // namespace

std::string plan_text(const MotionPlan& plan) {
  Table table({"moves", "tool way mm", "time s", "held back most by", "share of time"});
  table.left(3);
  std::string notes;
  for (const PlannedMotion& motion : plan.motions) {
    table.add({moves_text(motion), number(motion.path.joints.length() * 1e3, 1),
               number(motion.law.duration(), 3), limit_text(motion.limits.largest(), plan.model),
               fmt::format("{} %", number(share(motion) * 100, 0))});
    for (const planning::Slowdown& slowdown : motion.stretch.slowdowns) {
      notes += "  " + slowdown_text(slowdown, plan.model) + "\n";
    }
  }
  return fmt::format("{}\n{}  {} s in all, from rest to rest; nothing was moved\n", table.text(),
                     notes, number(plan.duration, 3));
}

Json plan_json(const MotionPlan& plan) {
  const RobotModel& model = plan.model;
  const char* unit = is_leg(model.joints[0]) ? "mm" : "deg";
  Json json{{"robot", model.id},
            {"duration_s", plan.duration},
            {"tool_way_mm", plan.way * 1e3},
            {"stretches", Json::array()},
            {"samples", Json::array()}};
  for (const PlannedMotion& motion : plan.motions) {
    json["stretches"].push_back({{"first_move", motion.first + 1},
                                 {"moves", motion.stretch.moves},
                                 {"duration_s", motion.law.duration()},
                                 {"limited", limit_json(motion, model)}});
  }
  for (const PlanSample& sample : plan.samples) {
    Json row{{"t_s", sample.t}};
    row[joints_key(model)] = values(sample.joints.q, model);
    row[fmt::format("velocity_{}_s", unit)] = values(sample.joints.qd, model);
    row[fmt::format("acceleration_{}_s2", unit)] = values(sample.joints.qdd, model);
    row[fmt::format("jerk_{}_s3", unit)] = values(sample.joints.qddd, model);
    row["tool_mm"] = {sample.p_BT.x * 1e3, sample.p_BT.y * 1e3, sample.p_BT.z * 1e3};
    json["samples"].push_back(row);
  }
  return json;
}

Outcome plan_refusal(const RobotModel& model, const planning::PathRefusal& refusal,
                     const planning::MoveProposal& proposal) {
  std::vector<std::string> ways;
  if (proposal.move_j) {
    ways.push_back("a joint move: --to joints=" + joints_option(*proposal.move_j, model));
  }
  if (proposal.other_start) {
    ways.push_back("the same line from another branch: --from-joints " +
                   joints_option(*proposal.other_start, model));
  }
  if (proposal.tilted) {
    ways.push_back(fmt::format("the same line with the tool tilted by {} deg",
                               number(to_deg(proposal.tilted->tilt), 1)));
  }
  if (proposal.nearest) {
    const Vec3 rpy = fixed_xyz(proposal.nearest->X_BT.R);
    ways.push_back(fmt::format("the nearest orientation that it can have: {},{},{} deg",
                               number(to_deg(rpy.x)), number(to_deg(rpy.y)),
                               number(to_deg(rpy.z))));
  }
  Outcome outcome;
  outcome.exit = ExitCode::kCouldNot;
  outcome.complaint = fmt::format(
      "move {}, at {} mm ({} %): {}", refusal.place.move + 1, number(refusal.place.at * 1e3, 1),
      number(refusal.place.share * 100, 1), error_text(refusal.error, model));
  for (const std::string& way : ways) outcome.complaint += "\n  would work: " + way;
  outcome.json = {{"robot", model.id}, {"refusal", error_json(refusal.error, model)}};
  outcome.json["refusal"]["move"] = refusal.place.move + 1;
  outcome.json["refusal"]["at_mm"] = refusal.place.at * 1e3;
  outcome.json["refusal"]["share"] = refusal.place.share;
  outcome.json["refusal"]["would_work"] = ways;
  return outcome;
}

}  // namespace sinew::cli
