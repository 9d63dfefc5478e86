#include "sinew/cli/plan_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/plan_report.h"
#include "sinew/cli/plan_svg.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/cli/table.h"
#include "sinew/cli/targets.h"
#include "sinew/core/quantity.h"
#include "sinew/io/file.h"
#include "sinew/model/joint_lookup.h"

namespace sinew::cli {
namespace {

constexpr std::string_view kJoints = "joints=";
constexpr double kSampleStep = 0.01;  // s
constexpr std::size_t kSamplesMax = 4000;
constexpr std::size_t kMotionsShown = 500;

/// One --to as a row of a program.
std::expected<program::Step, std::string> parse_move(const std::string& text, int number,
                                                     const program::MotionOptions& how,
                                                     const RobotModel& model) {
  if (text.starts_with(kJoints)) {
    const auto q = parse_joints("--to", text.substr(kJoints.size()), model);
    if (!q) return std::unexpected(q.error());
    program::JointStep step{.q = *q, .given = 0, .how = how};
    step.given = static_cast<std::uint8_t>((1U << model.joints.size()) - 1);
    return program::Step{number, step};
  }
  program::ToolMoveStep step;
  step.way = program::ToolMoveStep::Way::kLine;
  step.how = how;
  const bool point = std::ranges::count(text, ',') == 2;
  Vec3 p_BT;
  if (point) {
    const auto p = parse_point("--to", text);
    if (!p) return std::unexpected(p.error());
    p_BT = *p;
  } else {
    const auto X_BT = parse_pose("--to", text);
    if (!X_BT) return std::unexpected(X_BT.error());
    p_BT = X_BT->p;
    step.to.R_BT = X_BT->R;
  }
  step.to.p_BT = {p_BT.x, p_BT.y, p_BT.z};
  return program::Step{number, step};
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
  RobotModel model;
  JointVector from;
  program::Program program;
  std::string file;  ///< empty: --to
};

std::expected<program::Program, std::string> parse_moves(const PlanRequest& request,
                                                         const RobotModel& model) {
  program::MotionOptions how;
  if (request.speed) {
    const auto value = parse_amount("--speed", *request.speed, true);
    if (!value) return std::unexpected(value.error());
    how.tool_speed = *value;
  }
  if (request.blend) {
    const auto value = parse_amount("--blend", *request.blend, false);
    if (!value) return std::unexpected(value.error());
    how.blend_radius = *value;
  }
  program::Program program;
  for (const std::string& text : request.to) {
    const auto step = parse_move(text, static_cast<int>(program.steps.size()) + 1, how, model);
    if (!step) return std::unexpected(step.error());
    program.steps.push_back(*step);
  }
  return program;
}

std::expected<Wanted, Outcome> prepare(const PlanRequest& request) {
  const auto refused = [](const std::string& why) { return std::unexpected(bad_input(why)); };
  const bool from_file = request.subject.ends_with(".sinew");
  if (from_file && !request.robot) {
    return refused("--robot is missing: for which robot is " + request.subject + "?");
  }
  if (!from_file && request.robot) {
    return refused("--robot: a program NAME.sinew takes it; " + request.subject + " is none");
  }
  if (from_file && (!request.to.empty() || request.speed || request.blend)) {
    return refused("--to, --speed, --blend: the rows of " + request.subject + " say that");
  }
  if (!from_file && request.to.empty()) return refused("--to is missing: where shall it go?");
  const auto file = find_robot(from_file ? *request.robot : request.subject);
  if (!file) return std::unexpected(file.error());
  Wanted wanted{.model = file->model, .from = {}, .program = {}, .file = {}};
  const RobotModel& model = wanted.model;
  wanted.from = home_joints(model);
  if (request.from) {
    auto from = parse_joints("--from-joints", *request.from, model);
    if (!from) return refused(from.error());
    wanted.from = *from;
  }
  if (request.plot) {
    if (const auto fine = io::check_place(*request.plot); !fine) {
      return refused("--plot: " + fine.error().sentence);
    }
  }
  if (!from_file) {
    auto program = parse_moves(request, model);
    if (!program) return refused(program.error());
    wanted.program = std::move(*program);
    return wanted;
  }
  wanted.file = request.subject;
  const auto text = io::read_file(wanted.file);
  if (!text) return refused(text.error().sentence);
  auto program = program::parse(*text, wanted.file, model);
  if (!program) return std::unexpected(complaints_outcome(program.error()));
  wanted.program = std::move(*program);
  return wanted;
}

/// Collects what is told and drawn while the motions are planned one after the other.
class Recorder {
 public:
  Recorder(MotionPlan& plan, const planning::ToolSpace& space, double step)
      : plan_(plan), space_(space), X_near_(space.home()), step_(step) {}

  void add(const planning::PlannedMotion& motion) {
    const planning::Trajectory trajectory = motion.trajectory();
    const auto count = static_cast<std::size_t>(std::ceil(motion.law.duration() / step_));
    for (std::size_t k = 0; k <= count; ++k) {
      const double t = std::min(static_cast<double>(k) * step_, motion.law.duration());
      PlanSample sample;
      sample.t = plan_.duration + t;
      trajectory.sample(t, sample.joints);
      const auto tool = space_.forward({sample.joints.q.data(), space_.size()}, X_near_);
      if (tool) X_near_ = *tool;
      sample.p_BT = X_near_.p;
      if (!plan_.samples.empty() && k > 0) {
        plan_.way += norm(X_near_.p - plan_.samples.back().p_BT);
      }
      plan_.samples.push_back(sample);
    }
    plan_.duration += motion.law.duration();
  }

  /// The robot stands for a while.
  void wait(double duration) {
    plan_.duration += duration;
    if (plan_.samples.empty()) return;
    PlanSample sample = plan_.samples.back();
    sample.t = plan_.duration;
    sample.joints.qd = sample.joints.qdd = sample.joints.qddd = {};
    plan_.samples.push_back(sample);
  }

 private:
  MotionPlan& plan_;
  const planning::ToolSpace& space_;
  planning::PoseBT X_near_;
  double step_;
};

void summarise(const program::RowMotion& pieces, const planning::PlannedMotion& motion,
               std::span<const program::Step> rows, MotionPlan& plan) {
  if (plan.motions.size() == kMotionsShown) return;
  MotionSummary summary{.first = rows.front().line,
                        .last = rows.back().line,
                        .length = motion.path.joints.length(),
                        .duration = motion.law.duration(),
                        .on_wire = pieces.duration,
                        .pieces = pieces.pieces.size(),
                        .limits = motion.limits,
                        .notes = {}};
  for (const planning::Slowdown& slowdown : motion.stretch.slowdowns) {
    summary.notes.push_back(slowdown_text(slowdown, plan.model));
  }
  const bool stops = plan.model.device.capability.motion == MotionKind::kPointToPoint;
  if (stops && summary.pieces > 1) {
    summary.notes.push_back(
        fmt::format("the device takes whole moves only: {} of them from stop to stop, at most {} "
                    "mm off the way",
                    summary.pieces, number(program::RowPlanner::kWayTolerance * 1e3)));
  }
  plan.motions.push_back(summary);
}

std::expected<void, program::Refusal> follow(const Wanted& wanted, const program::Plan& orders,
                                             MotionPlan& plan) {
  program::RowPlanner planner(wanted.model);
  Recorder recorder(plan, planner.space(), std::max(kSampleStep, orders.duration / kSamplesMax));
  for (const program::Order& order : orders.orders) {
    if (const auto* wait = std::get_if<program::WaitOrder>(&order.what)) {
      recorder.wait(to_seconds(wait->duration));
    }
    const auto* move = std::get_if<program::MoveOrder>(&order.what);
    if (move == nullptr) continue;
    const auto pieces = planner.plan(*move->q_start, move->rows);
    if (!pieces) return std::unexpected(pieces.error());
    if (planner.motion().empty()) continue;
    recorder.add(planner.motion());
    if (order.round == 1) summarise(*pieces, planner.motion(), move->rows, plan);
  }
  return {};
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

/// What the motors have to do for it; nothing where the robot's file does not say enough.
std::expected<void, program::Refusal> weigh(const program::Plan& orders, MotionPlan& plan) {
  const RobotModel& model = plan.model;
  std::vector<planning::DriveTrain> drives;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const auto drive = planning::drive_train(model, j);
    if (!drive) return {};
    drives.push_back(*drive);
  }
  if (model.dynamics.links.empty()) return {};
  const auto loads = program::load_of(orders, model, planning::InverseDynamics(model, 0), drives);
  if (!loads) return std::unexpected(loads.error());
  const auto heaviest = std::ranges::min_element(
      *loads, {}, [](const program::JointLoad& load) { return load.margin(); });
  if (heaviest->peak > 0) {
    plan.heaviest = {static_cast<std::size_t>(heaviest - loads->begin()), *heaviest};
  }
  return {};
}

}  // namespace

Outcome plan(const PlanRequest& request) {
  const auto wanted = prepare(request);
  if (!wanted) return wanted.error();
  const RobotModel& model = wanted->model;
  if (!program::plannable(wanted->from, model)) {
    planning::MotionPlanner planner(model);
    const auto at = planner.place_at({wanted->from.data(), wanted->from.size()});
    if (!at) return could_not("--from-joints: " + error_text(at.error(), model));
  }
  const auto orders = program::make_plan(wanted->program, model, wanted->from);
  if (!orders) return plan_refusal(model, wanted->file, orders.error());
  MotionPlan plan{.model = model, .motions = {}, .samples = {}, .heaviest = {}};
  if (!wanted->file.empty()) plan.rows = "lines";
  if (const auto done = follow(*wanted, *orders, plan); !done) {
    return plan_refusal(model, wanted->file, done.error());
  }
  if (const auto weighed = weigh(*orders, plan); !weighed) {
    return plan_refusal(model, wanted->file, weighed.error());
  }
  return finish(plan, request);
}

}  // namespace sinew::cli
