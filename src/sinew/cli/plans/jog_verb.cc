#include "sinew/cli/plans/jog_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/plan_svg.h"
#include "sinew/cli/output/quantity.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/targets.h"
#include "sinew/cli/plans/jog_report.h"
#include "sinew/core/error_code.h"
#include "sinew/core/spelling.h"
#include "sinew/io/file.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/joint_value.h"
#include "sinew/planning/jog/jog.h"

namespace sinew::cli {
namespace {

using planning::Jog;
using planning::JogCommand;
using planning::JogFrame;

constexpr double kTime = 3;         // s
constexpr double kTimeMax = 600;    // s
constexpr double kComeToRest = 60;  // s, more than any robot takes
constexpr Duration kCycle = std::chrono::milliseconds(2);
constexpr std::size_t kJogSamplesMax = 2000;

constexpr auto kFrames =
    std::to_array<std::pair<std::string_view, JogFrame>>({{"joint", JogFrame::kJoint},
                                                          {"base", JogFrame::kBase},
                                                          {"tool", JogFrame::kTool},
                                                          {"platform", JogFrame::kPlatform}});

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
      measures.push_back(measure_of(joint));
    }
  } else {
    const std::size_t all = jog.space().numbers(command.frame);
    names = {"x", "y", "z"};
    measures = {Measure::kLength, Measure::kLength, Measure::kLength};
    if (given > 3 && all > 3) {
      if (all == 4) names.insert(names.end(), {"about z"});
      if (all == 5) names.insert(names.end(), {"pitch", "roll"});
      if (all == 6) names.insert(names.end(), {"about x", "about y", "about z"});
      measures.resize(all, Measure::kAngle);
    }
  }
  const auto values = parse_quantities("--velocity", text, measures, names);
  if (!values) return std::unexpected(values.error());
  for (std::size_t k = 0; k < values->size(); ++k) {
    const double value = (*values)[k];
    if (!(std::abs(value) <= Jog::kSpeedMax)) {
      const bool turns = measures[k] == Measure::kAngle;
      return std::unexpected(fmt::format(
          "--velocity: {} is {} {}; no jog is faster than {} {}", names[k],
          number(turns ? to_deg(value) : value), turns ? "deg/s" : "m/s",
          number(turns ? to_deg(Jog::kSpeedMax) : Jog::kSpeedMax), turns ? "deg/s" : "m/s"));
    }
    command.velocity.push_back(value);
  }
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
  const std::size_t every = 1 + held / kJogSamplesMax;
  record.let_go = static_cast<double>(held) * dt;
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
    record.note(t, dt, jog.status());
    record.plan.duration = t;
    record.plan.way += norm(jog.pose().p - p);
    p = jog.pose().p;
    if (k == held) record.way_before = record.plan.way;
    const bool last = k > held && jog.at_rest();
    if (k % every == 0 || last) record.plan.samples.push_back(sample(jog, t, dt, before));
    if (last) break;
  }
  record.join_stretches();
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

/// Less than this outside of a limit is where a person's hand or an arm's own weight left it.
double slack_of(const Joint& joint) {
  return joint.slides() ? 1e-3 : from_deg(1);
}

/// Joints that stand outside of their limits.
std::vector<Error> outside(const JointVector& q, const RobotModel& model) {
  std::vector<Error> errors;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (!within_limits(joint, q[j])) errors.push_back(beyond_limit(joint, j, q[j]));
  }
  return errors;
}

/// As a plan refuses it, but a little; its own joints may be driven back from wherever they are.
std::optional<Error> far_outside(const std::vector<Error>& errors, const RobotModel& model) {
  for (const Error& error : errors) {
    const Joint& joint = model.joints[static_cast<std::size_t>(error.index)];
    if (std::abs(error.measured - error.limit) > slack_of(joint)) return error;
  }
  return std::nullopt;
}

/// What is to be known of where it starts.
std::vector<std::string> start_notes(const std::vector<Error>& errors, const Jog& jog,
                                     const JogCommand& command, const RobotModel& model) {
  std::vector<std::string> notes;
  for (const Error& error : errors) {
    const Joint& joint = model.joints[static_cast<std::size_t>(error.index)];
    const char* unit = shown_unit(joint);
    notes.push_back(
        fmt::format("{} starts {} {} outside of its limit ({} {}): it moves inwards only",
                    joint.name, joint_text(std::abs(error.measured - error.limit), joint), unit,
                    joint_text(error.limit, joint), unit));
  }
  if (jog.overlap() && command.frame != JogFrame::kJoint) {
    notes.push_back(
        fmt::format("starts nearer to itself or its table than its margin ({} mm): --frame joint "
                    "moves its joints slowly, whichever way",
                    number(to_mm(*jog.overlap()), 1)));
  }
  return notes;
}

}  // namespace

Outcome jog(const JogRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  const RobotModel& model = file->model;
  Jog jog(model, {.avoid_contact = !request.contact});
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
  const auto beyond = outside(*start, model);
  if (const auto error = far_outside(beyond, model); error && command->frame != JogFrame::kJoint) {
    return could_not("--from-joints: " + error_text(*error, model) +
                     "; --frame joint brings it in");
  }
  std::vector<motion::AxisState> states;
  for (const double q : *start) states.push_back({q, 0, 0});
  if (const auto error = jog.start(states, Instant{})) {
    return could_not("--from-joints: " + error_text(*error, model));
  }
  if (const auto error = jog.command(*command, Instant{})) {
    return bad_input("--velocity: " + error_text(*error, model));
  }
  JogRecord record{
      .plan = {.model = model, .motions = {}, .notes = {}, .samples = {}, .heaviest = {}},
      .frame = request.frame,
      .stretches = {},
      .notes = start_notes(beyond, jog, *command, model)};
  hold(jog, *command, *time, record);
  Outcome outcome;
  outcome.json = jog_json(record);
  outcome.text = jog_text(record);
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
