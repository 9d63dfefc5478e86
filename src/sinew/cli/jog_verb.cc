#include "sinew/cli/jog_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/plan_report.h"
#include "sinew/cli/plan_svg.h"
#include "sinew/cli/quantity.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/cli/table.h"
#include "sinew/cli/targets.h"
#include "sinew/core/spelling.h"
#include "sinew/io/file.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/planning/jog.h"

namespace sinew::cli {
namespace {

using planning::Jog;
using planning::JogCommand;
using planning::JogFrame;
using planning::JogReason;
using planning::JogStatus;

constexpr double kTime = 3;         // s
constexpr double kTimeMax = 600;    // s
constexpr double kComeToRest = 60;  // s, more than any robot takes
constexpr Duration kCycle = std::chrono::milliseconds(2);
constexpr std::size_t kSamplesMax = 2000;

constexpr auto kFrames =
    std::to_array<std::pair<std::string_view, JogFrame>>({{"joint", JogFrame::kJoint},
                                                          {"base", JogFrame::kBase},
                                                          {"tool", JogFrame::kTool},
                                                          {"platform", JogFrame::kPlatform}});

/// A while with one reason for its speed.
struct Stretch {
  double begin = 0;
  double end = 0;
  JogReason reason = JogReason::kNone;
  int joint = -1;
  double least = 1;
  double most = 0;
};

struct JogRecord {
  MotionPlan plan;
  std::vector<Stretch> stretches;
};

std::string_view reason_name(JogReason reason) {
  switch (reason) {
    case JogReason::kNone:
      return "none";
    case JogReason::kNoCommand:
      return "no_command";
    case JogReason::kStopped:
      return "stopped";
    case JogReason::kExpired:
      return "expired";
    case JogReason::kContact:
      return "contact";
    case JogReason::kPoseLimit:
      return "pose_limit";
    case JogReason::kJointLimit:
      return "joint_limit";
    case JogReason::kSingular:
      return "singular";
    case JogReason::kJointSpeed:
      return "joint_speed";
  }
  return "none";
}

std::string reason_text(JogReason reason, int joint, const RobotModel& model) {
  const std::string name =
      joint < 0 ? "a joint" : model.joints[static_cast<std::size_t>(joint)].name;
  switch (reason) {
    case JogReason::kNone:
      return "as asked";
    case JogReason::kNoCommand:
    case JogReason::kStopped:
    case JogReason::kExpired:
      return "released: comes to rest";
    case JogReason::kContact:
      return "would touch itself or its table";
    case JogReason::kPoseLimit:
      return joint < 0 ? "the end of what its geometry can do"
                       : "a joint at the end of " + name + " is at its angle";
    case JogReason::kJointLimit:
      return name + " is at its limit";
    case JogReason::kSingular:
      return "singular: a direction is lost";
    case JogReason::kJointSpeed:
      return name + " can go no faster";
  }
  return {};
}

std::expected<JogCommand, std::string> parse_command(const JogRequest& request, const Jog& jog,
                                                     const RobotModel& model) {
  JogCommand command;
  const auto* frame =
      std::ranges::find(kFrames, request.frame, &std::pair<std::string_view, JogFrame>::first);
  if (frame == kFrames.end() || !jog.space().has(frame->second)) {
    return std::unexpected("--frame: '" + printable(request.frame) +
                           "' is none of joint, base, tool" +
                           (jog.space().has(JogFrame::kPlatform) ? ", platform" : ""));
  }
  command.frame = frame->second;
  std::string text = request.velocity;
  for (std::size_t at = 0; (at = text.find("/s")) != std::string::npos;) text.erase(at, 2);
  const auto given = static_cast<std::size_t>(std::ranges::count(text, ',')) + 1;
  std::vector<Measure> measures;
  std::vector<std::string> names;
  if (command.frame == JogFrame::kJoint) {
    names = joint_names(model);
    for (const Joint& joint : model.joints) {
      measures.push_back(is_leg(joint) ? Measure::kLength : Measure::kAngle);
    }
  } else {
    const std::size_t all = jog.space().numbers(command.frame);
    names = {"x", "y", "z"};
    measures = {Measure::kLength, Measure::kLength, Measure::kLength};
    if (given > 3 && all > 3) {
      if (all == 5) names.insert(names.end(), {"pitch", "roll"});
      if (all == 6) names.insert(names.end(), {"about x", "about y", "about z"});
      measures.resize(all, Measure::kAngle);
    }
  }
  const auto values = parse_quantities("--velocity", text, measures, names);
  if (!values) return std::unexpected(values.error());
  for (const double value : *values) command.velocity.push_back(value);
  return command;
}

std::expected<double, std::string> parse_time(const std::optional<std::string>& text) {
  if (!text) return kTime;
  const auto time = parse_quantity(*text, Measure::kTime, UnitRule::kOptional);
  if (!time) return std::unexpected("--time: " + time.error());
  if (!(*time > 0 && *time <= kTimeMax)) {
    return std::unexpected(fmt::format("--time: has to be above 0 and at most {} s", kTimeMax));
  }
  return *time;
}

void note(std::vector<Stretch>& stretches, double t, const JogStatus& status) {
  const bool same = !stretches.empty() && stretches.back().reason == status.reason &&
                    stretches.back().joint == status.joint;
  if (!same) stretches.push_back({t, t, status.reason, status.joint, status.share, status.share});
  Stretch& stretch = stretches.back();
  stretch.end = t;
  stretch.least = std::min(stretch.least, status.share);
  stretch.most = std::max(stretch.most, status.share);
}

PlanSample sample(const Jog& jog, double t, double dt, const motion::AxisStates& before) {
  PlanSample sample;
  sample.t = t;
  const motion::AxisStates& now = jog.setpoint();
  for (std::size_t j = 0; j < jog.joints(); ++j) {
    sample.joints.q[j] = now.q[j];
    sample.joints.qd[j] = now.qd[j];
    sample.joints.qdd[j] = now.qdd[j];
    sample.joints.qddd[j] = (now.qdd[j] - before.qdd[j]) / dt;
  }
  sample.p_BT = jog.pose().p;
  return sample;
}

/// Holds the command, lets go, and waits until all is at rest.
void hold(Jog& jog, const JogCommand& command, double seconds, JogRecord& record) {
  const double dt = to_seconds(kCycle);
  const auto held = static_cast<std::size_t>(std::ceil(seconds / dt));
  const auto most = held + static_cast<std::size_t>(kComeToRest / dt);
  const std::size_t every = 1 + held / kSamplesMax;
  JogCommand none = command;
  for (double& number : none.velocity) number = 0;
  Instant now{};
  Vec3 p = jog.pose().p;
  record.plan.samples.push_back(sample(jog, 0, dt, jog.setpoint()));
  for (std::size_t k = 1; k <= most; ++k) {
    const motion::AxisStates before = jog.setpoint();
    static_cast<void>(jog.command(k <= held ? command : none, now));
    now += kCycle;
    static_cast<void>(jog.step(now));
    const double t = static_cast<double>(k) * dt;
    note(record.stretches, t, jog.status());
    record.plan.duration = t;
    record.plan.way += norm(jog.pose().p - p);
    p = jog.pose().p;
    if (k % every == 0) record.plan.samples.push_back(sample(jog, t, dt, before));
    if (k > held && jog.at_rest()) break;
  }
}

Json record_json(const JogRecord& record, const JogRequest& request) {
  const RobotModel& model = record.plan.model;
  Json json{{"robot", model.id},
            {"frame", request.frame},
            {"duration_s", record.plan.duration},
            {"tool_way_mm", to_mm(record.plan.way)},
            {"stretches", Json::array()},
            {"samples", Json::array()}};
  for (const Stretch& stretch : record.stretches) {
    Json row{{"from_s", stretch.begin},
             {"to_s", stretch.end},
             {"reason", reason_name(stretch.reason)},
             {"share_min", stretch.least},
             {"share_max", stretch.most}};
    if (stretch.joint >= 0) {
      row["joint"] = model.joints[static_cast<std::size_t>(stretch.joint)].name;
    }
    json["stretches"].push_back(row);
  }
  for (const PlanSample& at : record.plan.samples) {
    const std::span q(at.joints.q.data(), model.joints.size());
    const std::span qd(at.joints.qd.data(), model.joints.size());
    const char* unit = is_leg(model.joints[0]) ? "velocity_mm_s" : "velocity_deg_s";
    json["samples"].push_back(
        {{"t_s", at.t},
         {joints_key(model), joints_json(q, model)},
         {unit, joints_json(qd, model)},
         {"tool_mm", {to_mm(at.p_BT.x), to_mm(at.p_BT.y), to_mm(at.p_BT.z)}}});
  }
  return json;
}

/// What lasts less than this is not told to people, s.
constexpr double kShort = 0.05;

std::string record_text(const JogRecord& record) {
  Table table({"from s", "to s", "of the speed asked for", "what holds it back"});
  table.left(3);
  for (const Stretch& stretch : record.stretches) {
    if (stretch.end - stretch.begin < kShort) continue;
    table.add(
        {number(stretch.begin, 2), number(stretch.end, 2),
         fmt::format("{} to {} %", number(100 * stretch.least, 0), number(100 * stretch.most, 0)),
         reason_text(stretch.reason, stretch.joint, record.plan.model)});
  }
  return fmt::format("{}\n  {} mm of tool way, at rest after {} s; nothing was moved\n",
                     table.text(), number(to_mm(record.plan.way), 3),
                     number(record.plan.duration, 2));
}

/// Joints of a pose to start from; a hexapod's legs at its home.
std::expected<JointVector, std::string> parse_start(const JogRequest& request, const Jog& jog,
                                                    const RobotModel& model) {
  if (request.from) return parse_joints("--from-joints", *request.from, model);
  const planning::ToolSpace& tool = jog.space().tool();
  if (tool.hexapod() != nullptr) {
    const auto legs = tool.inverse_near(tool.point(tool.home()), {});
    if (legs) return JointVector(std::span<const double>(legs->data(), model.joints.size()));
  }
  return home_joints(model);
}

}  // namespace

Outcome jog(const JogRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  const RobotModel& model = file->model;
  Jog jog(model, {.jaw_width = {}, .avoid_contact = !request.contact});
  const auto command = parse_command(request, jog, model);
  if (!command) return bad_input(command.error());
  const auto time = parse_time(request.time);
  if (!time) return bad_input(time.error());
  const auto start = parse_start(request, jog, model);
  if (!start) return bad_input(start.error());
  if (request.plot) {
    if (const auto fine = io::check_place(*request.plot); !fine) {
      return bad_input("--plot: " + fine.error().sentence);
    }
  }
  std::vector<motion::AxisState> states;
  for (const double q : *start) states.push_back({q, 0, 0});
  if (const auto error = jog.start(states, Instant{})) {
    return could_not("--from-joints: " + error_text(*error, model));
  }
  if (const auto error = jog.command(*command, Instant{})) {
    return bad_input("--velocity: " + error_text(*error, model));
  }
  JogRecord record{.plan = {.model = model, .motions = {}, .samples = {}, .heaviest = {}},
                   .stretches = {}};
  hold(jog, *command, *time, record);
  Outcome outcome;
  outcome.json = record_json(record, request);
  outcome.text = record_text(record);
  if (!request.plot) return outcome;
  const std::string svg = plan_svg(
      record.plan, fmt::format("{}: jog, {} {}", model.title, request.frame, request.velocity));
  if (const auto written = io::replace_file(*request.plot, svg); !written) {
    return could_not("--plot: " + written.error().sentence);
  }
  outcome.json["plot"] = *request.plot;
  outcome.text += "  " + *request.plot + "\n";
  return outcome;
}

}  // namespace sinew::cli
