#include "sinew/cli/plan_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/plan_report.h"
#include "sinew/cli/plan_svg.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/cli/targets.h"
#include "sinew/core/quantity.h"
#include "sinew/io/file.h"

namespace sinew::cli {
namespace {

using planning::Move;
using planning::MoveJ;
using planning::MoveL;

constexpr std::string_view kJoints = "joints=";
constexpr double kSampleStep = 0.01;  // s
constexpr std::size_t kSamplesMax = 4000;

planning::JointArray array_of(const JointVector& q) {
  planning::JointArray array{};
  std::ranges::copy(q, array.begin());
  return array;
}

std::expected<Move, std::string> parse_move(const std::string& text, const RobotModel& model) {
  Move move;
  if (text.starts_with(kJoints)) {
    const auto q = parse_joints("--to", text.substr(kJoints.size()), model);
    if (!q) return std::unexpected(q.error());
    move.way = MoveJ{array_of(*q)};
    return move;
  }
  if (std::ranges::count(text, ',') == 2) {
    const auto p = parse_point("--to", text);
    if (!p) return std::unexpected(p.error());
    move.way = MoveL{{{.R = {}, .p = *p}, planning::Asked::kPoint}};
    return move;
  }
  const auto X = parse_pose("--to", text);
  if (!X) return std::unexpected(X.error());
  move.way = MoveL{{*X, planning::Asked::kPose}};
  return move;
}

/// A length (or speed: a length per second), above 0 and below 100 m.
std::expected<double, std::string> parse_amount(const char* option, std::string text, bool speed) {
  if (speed && text.ends_with("/s")) text.resize(text.size() - 2);
  const auto value = parse_quantity(text, Measure::kLength, UnitRule::kOptional);
  if (!value) return std::unexpected(fmt::format("{}: {}", option, value.error()));
  if (!(*value > 0 && *value <= 100)) {
    return std::unexpected(fmt::format("{}: has to be above 0 and at most 100 m", option));
  }
  return *value;
}

struct Wanted {
  JointVector from;
  std::vector<Move> moves;
};

std::expected<Wanted, std::string> parse(const PlanRequest& request, const RobotModel& model) {
  Wanted wanted;
  for (const Joint& joint : model.joints) wanted.from.push_back(joint.home);
  if (request.from) {
    auto from = parse_joints("--from-joints", *request.from, model);
    if (!from) return std::unexpected(from.error());
    wanted.from = *from;
  }
  double speed = std::numeric_limits<double>::infinity();
  double blend = 0;
  if (request.speed) {
    const auto value = parse_amount("--speed", *request.speed, true);
    if (!value) return std::unexpected(value.error());
    speed = *value;
  }
  if (request.blend) {
    const auto value = parse_amount("--blend", *request.blend, false);
    if (!value) return std::unexpected(value.error());
    blend = *value;
  }
  for (const std::string& text : request.to) {
    auto move = parse_move(text, model);
    if (!move) return std::unexpected(move.error());
    move->tool_speed = speed;
    move->blend_radius = blend;
    wanted.moves.push_back(*move);
  }
  return wanted;
}

std::vector<motion::AxisLimits> limits_of(const RobotModel& model) {
  std::vector<motion::AxisLimits> limits;
  const double share = model.device.capability.limits_share;
  for (const Joint& joint : model.joints) {
    limits.push_back(
        {share * joint.velocity_max, share * joint.acceleration_max, share * joint.jerk_max});
  }
  return limits;
}

void add_samples(const PlannedMotion& motion, const planning::ToolSpace& space, double step,
                 MotionPlan& plan) {
  const planning::Trajectory trajectory(motion.path, motion.law);
  const auto count = static_cast<std::size_t>(std::ceil(motion.law.duration() / step));
  planning::PoseBT X = space.home();
  for (std::size_t k = 0; k <= count; ++k) {
    const double t = std::min(static_cast<double>(k) * step, motion.law.duration());
    PlanSample sample;
    sample.t = plan.duration + t;
    trajectory.sample(t, sample.joints);
    const auto tool = space.forward({sample.joints.q.data(), space.size()}, X);
    if (tool) X = *tool;
    sample.p_BT = X.p;
    if (!plan.samples.empty() && k > 0) plan.way += norm(X.p - plan.samples.back().p_BT);
    plan.samples.push_back(sample);
  }
}

Outcome finish(const MotionPlan& plan, const PlanRequest& request) {
  Outcome outcome;
  outcome.json = plan_json(plan);
  outcome.text = plan_text(plan);
  if (!request.plot) return outcome;
  const std::string svg = plan_svg(plan, plan.model.title + ": planned motion");
  if (const auto written = io::replace_file(*request.plot, svg); !written) {
    return could_not("--plot: " + written.error().sentence);
  }
  outcome.text += "  " + *request.plot + "\n";
  return outcome;
}

}  // namespace

Outcome plan(const PlanRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  const RobotModel& model = file->model;
  const auto wanted = parse(request, model);
  if (!wanted) return bad_input(wanted.error());
  if (request.plot) {
    if (const auto fine = io::check_place(*request.plot); !fine) {
      return bad_input("--plot: " + fine.error().sentence);
    }
  }
  const planning::ToolSpace space(model);
  planning::MovePathBuilder builder(space);
  planning::PathTiming timing;
  const auto limits = limits_of(model);
  MotionPlan plan{.model = model, .motions = {}, .duration = 0, .way = 0, .samples = {}};
  auto at = builder.place_at(wanted->from, space.home());
  if (!at) return could_not("--from-joints: " + error_text(at.error(), model));
  for (std::size_t k = 0; k < wanted->moves.size();) {
    PlannedMotion& motion = plan.motions.emplace_back(model.joints.size(), timing.phases_max());
    const auto stretch = builder.build(*at, wanted->moves, k, motion.path);
    if (!stretch) {
      planning::PlannedPath scratch(model.joints.size());
      return plan_refusal(model, stretch.error(),
                          propose(builder, space, stretch.error(), wanted->moves, scratch));
    }
    motion.first = k;
    motion.stretch = *stretch;
    k += stretch->moves;
    *at = stretch->end;
    if (motion.path.joints.empty()) {
      plan.motions.pop_back();
      continue;
    }
    auto trouble = timing.prepare(motion.path, limits);
    if (!trouble) trouble = timing.plan({}, 1, motion.law);
    if (trouble) return could_not(error_text(*trouble, model));
    motion.limits = timing.limit_times();
  }
  double total = 0;
  for (const PlannedMotion& motion : plan.motions) total += motion.law.duration();
  const double step = std::max(kSampleStep, total / kSamplesMax);
  for (const PlannedMotion& motion : plan.motions) {
    add_samples(motion, space, step, plan);
    plan.duration += motion.law.duration();
  }
  return finish(plan, request);
}

}  // namespace sinew::cli
