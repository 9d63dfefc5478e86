#include "sinew/cli/plans/jog_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/table.h"
#include "sinew/planning/jog/jog_reason.h"

namespace sinew::cli {
namespace {

using planning::JogReason;

/// What lasts less than this has no row of its own, s.
constexpr double kShort = 0.05;
constexpr std::size_t kStretchesMax = 50;

bool is_idle(JogReason reason) {
  return reason == JogReason::kNoCommand || reason == JogReason::kStopped ||
         reason == JogReason::kExpired;
}

std::string reason_text(const JogStretch& stretch, const JogRecord& record) {
  const RobotModel& model = record.plan.model;
  const int joint = stretch.joint();
  const std::string name =
      joint < 0 ? "a joint" : model.joints[static_cast<std::size_t>(joint)].name;
  switch (stretch.reason) {
    case JogReason::kNone:
      return "as asked";
    case JogReason::kNoCommand:
    case JogReason::kStopped:
    case JogReason::kExpired:
      return stretch.begin < record.let_go ? "stands still: no velocity is asked for"
                                           : "let go: comes to rest";
    case JogReason::kContact:
      return "would touch itself or its table";
    case JogReason::kOverlap:
      return stretch.nearest < 0
                 ? fmt::format("overlaps by {} mm: slow", number(to_mm(-stretch.nearest), 1))
                 : fmt::format("nearer than its margin, {} mm: slow",
                               number(to_mm(stretch.nearest), 1));
    case JogReason::kPoseLimit:
      return joint < 0 ? "the end of what its geometry can do"
                       : "a joint at the end of " + name + " is at its angle";
    case JogReason::kJointLimit:
      return name + " is at its limit";
    case JogReason::kSingular:
      return "singular: a direction is lost";
    case JogReason::kJointSpeed:
      return name + " can go no faster";
    case JogReason::kWire:
      return "the wire carries no more for all of them";
  }
  return {};
}

/// `next` follows; its reason is the one before's.
void absorb(JogStretch& stretch, const JogStretch& next) {
  stretch.end = std::max(stretch.end, next.end);
  stretch.begin = std::min(stretch.begin, next.begin);
  stretch.least = std::min(stretch.least, next.least);
  stretch.most = std::max(stretch.most, next.most);
  if (stretch.reason != next.reason) return;
  stretch.nearest = std::min(stretch.nearest, next.nearest);
  for (std::size_t j = 0; j < stretch.blamed.size(); ++j) stretch.blamed[j] += next.blamed[j];
}

std::vector<JogStretch> joined_stretches(const std::vector<JogStretch>& stretches,
                                         double shortest) {
  std::vector<JogStretch> rows;
  const auto is_short = [&](const JogStretch& stretch) {
    return stretch.end - stretch.begin < shortest;
  };
  for (JogStretch next : stretches) {
    // What was too short begins what comes after it.
    if (!rows.empty() && is_short(rows.back()) && rows.back().reason != next.reason &&
        !is_idle(next.reason) && !is_idle(rows.back().reason)) {
      absorb(next, rows.back());
      rows.pop_back();
    }
    const bool idle = is_idle(next.reason);
    if (rows.empty() || is_idle(rows.back().reason) != idle) {
      rows.push_back(next);
      continue;
    }
    JogStretch& last = rows.back();
    const bool same = last.reason == next.reason;
    const bool one = same && last.joint() == next.joint();
    if (one || is_short(next) || (same && is_short(last))) {
      absorb(last, next);
    } else {
      rows.push_back(next);
    }
  }
  return rows;
}

}  // namespace

int JogStretch::joint() const {
  const auto longest = std::ranges::max_element(blamed);
  return *longest > 0 ? static_cast<int>(longest - blamed.begin()) : -1;
}

void JogRecord::note(double t, double dt, const planning::JogStatus& status) {
  JogStretch next{.begin = t - dt,
                  .end = t,
                  .reason = status.reason,
                  .least = status.share,
                  .most = status.share,
                  .nearest = status.distance};
  if (status.joint >= 0) next.blamed[static_cast<std::size_t>(status.joint)] = dt;
  if (!stretches.empty() && stretches.back().reason == next.reason &&
      stretches.back().joint() == status.joint) {
    return absorb(stretches.back(), next);
  }
  stretches.push_back(next);
}

void JogRecord::join_stretches() {
  double shortest = kShort;
  do {
    stretches = joined_stretches(stretches, shortest);
    shortest *= 2;
  } while (stretches.size() > kStretchesMax);
}

Json jog_json(const JogRecord& record) {
  const RobotModel& model = record.plan.model;
  Json json{{"robot", model.id},
            {"frame", record.frame},
            {"duration_s", record.plan.duration},
            {"let_go_s", record.let_go},
            {"tool_way_mm", to_mm(record.plan.way)},
            {"tool_way_after_mm", to_mm(record.plan.way - record.way_before)},
            {"notes", record.notes},
            {"stretches", Json::array()},
            {"samples", Json::array()}};
  for (const JogStretch& stretch : record.stretches) {
    Json row{{"from_s", stretch.begin},
             {"to_s", stretch.end},
             {"reason", planning::name(stretch.reason)},
             {"share_min", stretch.least},
             {"share_max", stretch.most}};
    if (const int joint = stretch.joint(); joint >= 0) {
      row["joint"] = model.joints[static_cast<std::size_t>(joint)].name;
    }
    if (stretch.reason == JogReason::kOverlap) row["distance_mm"] = to_mm(stretch.nearest);
    json["stretches"].push_back(row);
  }
  for (const PlanSample& at : record.plan.samples) {
    const std::span q(at.joints.q.data(), model.joints.size());
    const std::span qd(at.joints.qd.data(), model.joints.size());
    json["samples"].push_back(
        {{"t_s", at.t},
         {joints_key(model), joints_json(q, model)},
         {fmt::format("velocity_{}_s", joints_unit_key(model)), joints_json(qd, model)},
         {"tool_mm", {to_mm(at.p_BT.x), to_mm(at.p_BT.y), to_mm(at.p_BT.z)}}});
  }
  return json;
}

std::string jog_text(const JogRecord& record) {
  Table table({"from s", "to s", "of the speed asked for", "what holds it back"});
  table.left(3);
  for (const JogStretch& stretch : record.stretches) {
    const std::string share = is_idle(stretch.reason)
                                  ? ""
                                  : fmt::format("{} to {} %", number(100 * stretch.least, 0),
                                                number(100 * stretch.most, 0));
    table.add(
        {number(stretch.begin, 2), number(stretch.end, 2), share, reason_text(stretch, record)});
  }
  std::string text = table.text() + "\n";
  for (const std::string& note : record.notes) text += "  " + note + "\n";
  const double after = record.plan.duration - record.let_go;
  return text + fmt::format(
                    "  {} mm of tool way; let go at {} s, at rest {} s and {} mm later; nothing "
                    "was moved\n",
                    number(to_mm(record.plan.way), 3), number(record.let_go, 2), number(after, 2),
                    number(to_mm(record.plan.way - record.way_before), 3));
}

}  // namespace sinew::cli
