#include "sinew/cli/output/plan_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/progress_line.h"
#include "sinew/cli/output/table.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/model/collision_links.h"
#include "sinew/program/plans/row_offers.h"

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
    case LimitKind::kWire:
      return "the wire";
    case LimitKind::kFeed:
      break;
  }
  return "the feed";
}

/// "1", "2..4", "3 home", "2 x 500".
std::string rows_text(const MotionSummary& motion) {
  std::string text = motion.first == motion.last ? fmt::format("{}", motion.first)
                                                 : fmt::format("{}..{}", motion.first, motion.last);
  if (!motion.what.empty()) text += " " + motion.what;
  if (motion.times > 1) text += fmt::format(" x {}", motion.times);
  return text;
}

/// "line 4", or "lines 4..6".
std::string named_rows(const MotionSummary& motion, const MotionPlan& plan) {
  const std::string word = plan.rows == "moves" ? "move" : "line";
  return motion.first == motion.last ? fmt::format("{} {}", word, motion.first)
                                     : fmt::format("{}s {}..{}", word, motion.first, motion.last);
}

/// mm with one decimal, or three digits that count.
std::string way_text(double length) {
  const double mm = to_mm(length);
  constexpr double kNothing = 1e-6;  // what rounding makes of a turn on the spot
  return mm >= 100 || mm < kNothing ? number(mm, 1) : fmt::format("{:.3g}", mm);
}

double share(const MotionSummary& motion) {
  const double total = motion.limits.total();
  return total > 0 ? motion.limits.of(motion.limits.largest()) / total : 0;
}

std::string refused_text(const Error& error, const RobotModel& model) {
  if (error.code != ErrorCode::kCollision || error.measured >= 0) return error_text(error, model);
  return fmt::format("{} and {} overlap by {} mm, and would go on doing so; {} mm are asked for",
                     link_name(model, static_cast<std::size_t>(error.index)),
                     link_name(model, static_cast<std::size_t>(error.other)),
                     number(-to_mm(error.measured), 1), number(to_mm(error.limit), 1));
}

/// Of a refusal: what more there is to know than its error says.
std::string more_text(const planning::PathRefusal& refusal, const RobotModel& model) {
  std::string text;
  const auto& joints = model.joints;
  if (refusal.place.at == 0 && refusal.error.index >= 0 &&
      (refusal.error.code == ErrorCode::kJointLimit ||
       refusal.error.code == ErrorCode::kLegLength)) {
    const auto j = static_cast<std::size_t>(refusal.error.index);
    if (!within_limits(joints[j], refusal.from.q[j])) {
      text += ", which is where it stands: from there only joints lead back in";
    }
  }
  if (refusal.error.code == ErrorCode::kArcCollinear && refusal.error.measured == 0) {
    text += "; where an arc would end where it starts, two of them make a circle";
  }
  if (refusal.nearest_behind) text += behind_text(*refusal.nearest_behind, refusal.place);
  return text;
}

Json values(const planning::JointArray& array, const RobotModel& model) {
  Json json = Json::array();
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    json.push_back(shown_value(array[j], model.joints[j]));
  }
  return json;
}

Json limit_json(const MotionSummary& motion, const RobotModel& model) {
  const PathLimit limit = motion.limits.largest();
  return {{"by", limit_text(limit, model)}, {"share_of_time", share(motion)}};
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

std::vector<std::string> cells(const MotionSummary& motion, const MotionPlan& plan) {
  std::vector<std::string> row{rows_text(motion)};
  if (motion.at_most > 0) {
    row.insert(row.end(), {"", at_most_text(motion.at_most), "", "", ""});
    return row;
  }
  row.push_back(way_text(motion.length));
  row.insert(row.end(), {number(motion.on_wire, 3), number(motion.by_limits, 3),
                         limit_text(motion.limits.largest(), plan.model),
                         fmt::format("{} %", number(share(motion) * 100, 0))});
  return row;
}

/// "12.3 s in all as this device takes it, ..".
std::string total_text(const MotionPlan& plan) {
  const std::string homing =
      plan.homing_max > 0 ? ", and homing: " + at_most_text(plan.homing_max) : "";
  return fmt::format("{} s in all as this device takes it{}; {} s if only the limits counted",
                     number(plan.on_wire, 3), homing, number(plan.by_limits, 3));
}

}  // namespace

std::string place_text(const planning::MovePlace& place) {
  const std::string share = number(place.share * 100, 1) + " %";
  if (!place.metres) return "at " + share;
  return fmt::format("at {} mm ({})", number(to_mm(place.at), 1), share);
}

std::string behind_text(double nearest, const planning::MovePlace& place) {
  const std::string text =
      nearest < 0 ? fmt::format("; on the rest of the way they would overlap by {} mm",
                                number(-to_mm(nearest), 1))
                  : fmt::format("; on the rest of the way they would come within {} mm",
                                number(to_mm(nearest), 1));
  if (!(place.share > 0)) return text;
  const double left = 1 - place.share;
  return text + (place.metres ? fmt::format(", its target is {} mm farther",
                                            number(to_mm(place.at / place.share * left), 1))
                              : fmt::format(", {} % of it are left", number(left * 100, 1)));
}

std::string slowdown_text(const planning::Slowdown& slowdown, const RobotModel& model) {
  const std::string place =
      fmt::format("{} {} allows no more than {:.3g} mm/s", place_text(slowdown.place),
                  limit_text(slowdown.by, model), to_mm(slowdown.tool_speed));
  const bool singular = planning::slows_down(slowdown.near);
  if (!slowdown.place.metres) {
    const std::string slow = fmt::format("{} {} slows the turn down", place_text(slowdown.place),
                                         limit_text(slowdown.by, model));
    return singular ? slow + "; " + error_text(slowdown.near, model) : slow;
  }
  return singular ? place + "; " + error_text(slowdown.near, model) : place;
}

std::vector<std::string> unheard_notes(const program::Plan& orders, const RobotModel& model,
                                       const char* heard) {
  program::Unheard any;
  for (const program::Order& order : orders.orders) {
    const auto* move = std::get_if<program::MoveOrder>(&order.what);
    if (move == nullptr) continue;
    for (const program::Step& row : move->rows) {
      const program::Unheard one = program::unheard(*program::motion_of(row), model);
      any.speed = any.speed || one.speed;
      any.acceleration = any.acceleration || one.acceleration;
      any.blend = any.blend || one.blend;
      any.beyond = any.beyond || one.beyond;
    }
  }
  std::vector<std::string> notes;
  if (any.speed) {
    notes.push_back(fmt::format(
        "these boards have one speed of their own; speed= and time= {} not heard", heard));
  }
  if (any.acceleration) {
    notes.push_back(fmt::format(
        "this device starts and stops its moves in its own way; accel= {} not heard", heard));
  }
  if (any.blend) {
    notes.push_back(
        fmt::format("this device stops at each corner anyway; blend= {} not heard", heard));
  }
  if (any.beyond) {
    notes.emplace_back(
        "more than 100% of a joint's limit is asked for: its wire takes that, no board has shown "
        "it. "
        "A real one makes some 5000 steps a second of all joints, and may take longer than told");
  }
  return notes;
}

std::string plan_text(const MotionPlan& plan) {
  Table table({plan.rows, "tool way mm", "on the wire s", "by the limits s", "held back most by",
               "share of time"});
  table.left(4);
  std::string notes;
  for (const MotionSummary& motion : plan.motions) {
    table.add(cells(motion, plan));
    for (const std::string& note : motion.notes) {
      notes += fmt::format("  {}: {}\n", named_rows(motion, plan), note);
    }
  }
  if (plan.heaviest) notes += load_text(*plan.heaviest, plan) + "\n";
  for (const std::string& note : plan.notes) notes += "  note: " + note + "\n";
  return fmt::format("{}\n{}  {}; nothing was moved\n", table.text(), notes, total_text(plan));
}

Json plan_json(const MotionPlan& plan) {
  const RobotModel& model = plan.model;
  const char* unit = joints_unit_key(model);
  Json json{{"robot", model.id},
            {"duration_s", plan.duration},
            {"by_limits_s", plan.by_limits},
            {"on_wire_s", plan.on_wire},
            {"homing_at_most_s", plan.homing_max},
            {"notes", plan.notes},
            {"tool_way_mm", plan.way * 1e3},
            {"stretches", Json::array()},
            {"samples", Json::array()}};
  const std::string word = plan.rows == "moves" ? "move" : "line";
  for (const MotionSummary& motion : plan.motions) {
    if (motion.at_most > 0) {
      json["stretches"].push_back({{"first_" + word, motion.first},
                                   {"last_" + word, motion.last},
                                   {"what", motion.what},
                                   {"times", motion.times},
                                   {"at_most_s", motion.at_most},
                                   {"notes", motion.notes}});
      continue;
    }
    json["stretches"].push_back({{"first_" + word, motion.first},
                                 {"last_" + word, motion.last},
                                 {"what", motion.what},
                                 {"times", motion.times},
                                 {"duration_s", motion.duration},
                                 {"by_limits_s", motion.by_limits},
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
    ways = program::offers(*refusal.way, model, !file.empty());
    complaint += ", " + place_text(refusal.way->refusal.place);
  }
  complaint += ": " + refused_text(refusal.error, model);
  if (refusal.way) complaint += more_text(refusal.way->refusal, model);
  if (refusal.error.code == ErrorCode::kSegmentTime && !refusal.way) {
    complaint += refusal.error.measured < refusal.error.limit
                     ? fmt::format(": write time={}s, or longer", number(refusal.error.limit, 6))
                     : ": faster, or in several rows, it can be planned";
  }
  if (refusal.way && refusal.way->unsayable) {
    const program::Unsayable& what = *refusal.way->unsayable;
    const Joint& joint = model.joints[what.joint];
    complaint += fmt::format(" ({} at {} {})", joint.name, number(shown_value(what.q, joint), 3),
                             shown_unit(joint));
  }
  if (refusal.way && refusal.way->proposal.at_target) {
    complaint += "; its target: " + error_text(*refusal.way->proposal.at_target, model);
  }
  complaint += "; nothing was moved";
  for (const std::string& way : ways) complaint += "\n  would work: " + way;
  Outcome outcome = could_not(complaint);
  outcome.json["robot"] = model.id;
  Json& json = outcome.json["refusal"];
  json = error_json(refusal.error, model);
  json[file.empty() ? "move" : "line"] = refusal.line;
  if (refusal.way) {
    const planning::PathRefusal& why = refusal.way->refusal;
    if (why.place.metres) json["at_mm"] = to_mm(why.place.at);
    json["share"] = why.place.share;
    if (why.nearest_behind) json["nearest_behind_mm"] = to_mm(*why.nearest_behind);
    json["would_work"] = ways;
    if (refusal.way->proposal.at_target) {
      json["at_target"] = error_json(*refusal.way->proposal.at_target, model);
    }
  }
  return outcome;
}

}  // namespace sinew::cli
