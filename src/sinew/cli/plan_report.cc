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
std::string rows_text(const MotionSummary& motion) {
  return motion.first == motion.last ? fmt::format("{}", motion.first)
                                     : fmt::format("{}..{}", motion.first, motion.last);
}

double share(const MotionSummary& motion) {
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

Json values(const planning::JointArray& array, const RobotModel& model) {
  Json json = Json::array();
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    json.push_back(shown(array[j], model.joints[j]));
  }
  return json;
}

Json limit_json(const MotionSummary& motion, const RobotModel& model) {
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

std::string load_text(const HeaviestLoad& heaviest, const MotionPlan& plan) {
  const program::JointLoad& load = heaviest.load;
  const double share = load.peak / load.available;
  return fmt::format(
      "  {}'s motors are asked for {} % of what they give ({} {}, without payload){}",
      plan.model.joints[heaviest.joint].name, number(100 * share, 0),
      plan.rows == "moves" ? "move" : "line", load.line,
      share > 1 ? ": they will slip there; sinew torque says what would do" : "");
}

std::vector<std::string> ways_that_work(const planning::MoveProposal& proposal,
                                        const RobotModel& model) {
  std::vector<std::string> ways;
  if (proposal.move_j) {
    ways.push_back("a joint move: joints=" + joints_option(*proposal.move_j, model));
  }
  if (proposal.other_start) {
    ways.push_back("the same way from another branch: from " +
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
  return ways;
}

}  // namespace

std::string slowdown_text(const planning::Slowdown& slowdown, const RobotModel& model) {
  const std::string place = fmt::format(
      "at {} mm ({} %) the joints allow no more than {} mm/s", number(slowdown.place.at * 1e3, 1),
      number(slowdown.place.share * 100, 1), number(slowdown.tool_speed * 1e3, 1));
  return is_near(slowdown.near) ? place + "; " + error_text(slowdown.near, model) : place;
}

std::string plan_text(const MotionPlan& plan) {
  Table table(
      {plan.rows, "tool way mm", "time s", "on the wire s", "held back most by", "share of time"});
  table.left(4);
  std::string notes;
  for (const MotionSummary& motion : plan.motions) {
    table.add({rows_text(motion), number(motion.length * 1e3, 1), number(motion.duration, 3),
               number(motion.on_wire, 3), limit_text(motion.limits.largest(), plan.model),
               fmt::format("{} %", number(share(motion) * 100, 0))});
    for (const std::string& note : motion.notes) {
      notes += fmt::format("  {} {}: {}\n", plan.rows, rows_text(motion), note);
    }
  }
  if (plan.heaviest) notes += load_text(*plan.heaviest, plan) + "\n";
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
  const std::string word = plan.rows == "moves" ? "move" : "line";
  for (const MotionSummary& motion : plan.motions) {
    json["stretches"].push_back({{"first_" + word, motion.first},
                                 {"last_" + word, motion.last},
                                 {"duration_s", motion.duration},
                                 {"on_wire_s", motion.on_wire},
                                 {"pieces", motion.pieces},
                                 {"limited", limit_json(motion, model)},
                                 {"notes", motion.notes}});
  }
  if (plan.heaviest) {
    const program::JointLoad& load = plan.heaviest->load;
    json["heaviest_load"] = {{"joint", model.joints[plan.heaviest->joint].name},
                             {"share_of_available", load.peak / load.available},
                             {"time_s", load.time},
                             {word, load.line}};
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

Outcome plan_refusal(const RobotModel& model, const std::string& file,
                     const program::Refusal& refusal) {
  const std::string row = fmt::format("{}{}", file.empty() ? "move " : file + ":", refusal.line);
  std::string complaint = row;
  std::vector<std::string> ways;
  if (refusal.way) {
    const planning::MovePlace& place = refusal.way->refusal.place;
    ways = ways_that_work(refusal.way->proposal, model);
    complaint +=
        fmt::format(", at {} mm ({} %)", number(place.at * 1e3, 1), number(place.share * 100, 1));
  }
  complaint += ": " + error_text(refusal.error, model) + "; nothing was moved";
  for (const std::string& way : ways) complaint += "\n  would work: " + way;
  Outcome outcome = could_not(complaint);
  outcome.json["robot"] = model.id;
  Json& json = outcome.json["refusal"];
  json = error_json(refusal.error, model);
  json[file.empty() ? "move" : "line"] = refusal.line;
  if (refusal.way) {
    json["at_mm"] = refusal.way->refusal.place.at * 1e3;
    json["share"] = refusal.way->refusal.place.share;
    json["would_work"] = ways;
  }
  return outcome;
}

}  // namespace sinew::cli
