#include "sinew/cli/plans/plan_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <tuple>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/plan_report.h"
#include "sinew/cli/output/plan_svg.h"
#include "sinew/cli/output/program_folder.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/targets.h"
#include "sinew/cli/output/verb_options.h"
#include "sinew/cli/plans/dry_run.h"
#include "sinew/core/error_code.h"
#include "sinew/core/quantity.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"
#include "sinew/model/collision_links.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/planning/paths/motion_limits.h"
#include "sinew/program/plans/whole_moves.h"
#include "sinew/runtime/homing_time.h"
#include "sinew/runtime/links/robot_variant.h"

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
  const auto commas = std::ranges::count(text, ',');
  if (commas != 2 && commas != 5) {
    return std::unexpected("--to: " + text +
                           ": x,y,z (mm) are wanted, or x,y,z,rx,ry,rz (mm, deg), or joints=..");
  }
  const bool point = commas == 2;
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

/// As in a row of a program; mm and mm/s where no unit is given.
std::expected<double, std::string> parse_speed(const std::string& text) {
  const auto value = parse_quantity(text, Measure::kSpeed, UnitRule::kOptional);
  if (!value) return std::unexpected("--speed: " + value.error());
  if (!(*value >= 1e-6 && *value <= 100)) {
    return std::unexpected("--speed: has to be 0.001 mm/s to 100 m/s");
  }
  return *value;
}

std::expected<double, std::string> parse_blend(const std::string& text) {
  const auto value = parse_quantity(text, Measure::kLength, UnitRule::kOptional);
  if (!value) return std::unexpected("--blend: " + value.error());
  if (!(*value > 0 && *value <= 1)) {
    return std::unexpected("--blend: has to be above 0 and at most 1 m");
  }
  return *value;
}

struct Wanted {
  RobotModel model;
  JointVector from;
  bool declared = false;  ///< somebody said where it stands
  program::Program program;
  std::string file;  ///< empty: --to
};

std::expected<program::Program, std::string> parse_moves(const PlanRequest& request,
                                                         const RobotModel& model) {
  program::MotionOptions how;
  if (request.speed) {
    const auto value = parse_speed(*request.speed);
    if (!value) return std::unexpected(value.error());
    how.tool_speed = *value;
  }
  if (request.blend) {
    const auto value = parse_blend(*request.blend);
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

/// Why a file cannot be planned that is no program; empty where it is a robot's.
std::string no_program(const PlanRequest& request) {
  const std::string& name = request.subject;
  if (name.ends_with(".toml")) {
    if (!request.robot) return {};
    return "--robot: " + name + " is a robot's file itself; write sinew plan " + name +
           " --to .., or sinew plan NAME.sinew --robot " + name;
  }
  if (!io::read_file(name)) {
    return "--robot: a program NAME.sinew takes it; " + name + " is none";
  }
  return name +
         ": a program is a file NAME.sinew (or .txt, .gcode, .pos), a robot's a file NAME.toml";
}

std::expected<Wanted, Outcome> prepare(const PlanRequest& request) {
  const auto refused = [](const std::string& why) { return std::unexpected(bad_input(why)); };
  const bool from_file =
      request.subject.ends_with(".sinew") || program::form_of_file(request.subject) != nullptr;
  if (from_file && !request.robot) {
    return refused("--robot is missing: for which robot is " + request.subject + "?");
  }
  if (!from_file && (request.robot || io::read_file(request.subject))) {
    if (const auto why = no_program(request); !why.empty()) return refused(why);
  }
  if (from_file && (!request.to.empty() || request.speed || request.blend)) {
    return refused("--to, --speed, --blend: the rows of " + request.subject + " say that");
  }
  if (!from_file && request.to.empty()) return refused("--to is missing: where shall it go?");
  const auto file = find_robot(from_file ? *request.robot : request.subject);
  if (!file) return std::unexpected(file.error());
  Wanted wanted{.model = file->model, .from = {}, .program = {}, .file = {}};
  if (request.profile || request.wire || !request.without.empty()) {
    auto variant = runtime::variant_of(file->model, request.profile, request.wire, request.without);
    if (!variant) return refused(variant.error());
    wanted.model = std::move(*variant);
  }
  wanted.declared = request.from.has_value();
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
  auto program = read_program(wanted.file, model);
  if (!program) return std::unexpected(program.error());
  wanted.program = std::move(*program);
  return wanted;
}

/// Collects what is told and drawn while the motions are planned one after the other.
class Recorder {
 public:
  Recorder(MotionPlan& plan, const planning::ToolSpace& space, double step)
      : plan_(plan), space_(space), X_near_(space.home()), step_(step) {}

  /// A motion along its way, or as a device makes it that takes whole moves.
  void add(const JointVector& q_start, const program::RowMotion& pieces,
           const planning::PlannedMotion& motion) {
    plan_.duration += motion.law.duration();
    const bool whole = plan_.model.device.capability.motion == MotionKind::kPointToPoint;
    if (whole && !pieces.pieces.empty()) {
      const double share = motion.path.sections.front().joint_share;
      add(program::WholeMoves(q_start, pieces, share, plan_.model));
    } else {
      add(motion.trajectory());
    }
  }

  /// How far from q the tool ends, m.
  double off(const JointVector& q) const {
    const auto X_BT = space_.forward({q.data(), q.size()}, X_near_);
    return X_BT ? norm(X_BT->p - X_near_.p) : 0;
  }

  /// The robot stands for a while.
  void wait(double duration) {
    plan_.duration += duration;
    plan_.sampled += duration;
    if (plan_.samples.empty()) return;
    PlanSample sample = plan_.samples.back();
    sample.t = plan_.sampled;
    sample.joints.qd = sample.joints.qdd = sample.joints.qddd = {};
    plan_.samples.push_back(sample);
  }

 private:
  template <class Motion>
  void add(const Motion& motion) {
    const double duration = motion.duration();
    const auto count = static_cast<std::size_t>(std::ceil(duration / step_));
    for (std::size_t k = 0; k <= count; ++k) {
      const double t = std::min(static_cast<double>(k) * step_, duration);
      PlanSample sample;
      sample.t = plan_.sampled + t;
      motion.sample(t, sample.joints);
      const auto tool = space_.forward({sample.joints.q.data(), space_.size()}, X_near_);
      if (tool) X_near_ = *tool;
      sample.p_BT = X_near_.p;
      plan_.samples.push_back(sample);
    }
    plan_.sampled += duration;
  }

  MotionPlan& plan_;
  const planning::ToolSpace& space_;
  planning::PoseBT X_near_;
  double step_;
};

/// How far the tool goes on a path.
class ToolLength {
 public:
  explicit ToolLength(const planning::ToolSpace& space) : space_(space), X_near_(space.home()) {}

  /// @return  m
  double length(const planning::PlannedPath& path) {
    const double whole = path.joints.length();
    // Chords: between two of some hundred looks a way is straight, but for arcs of many turns.
    const auto looks =
        static_cast<double>(std::clamp<std::size_t>(4 * path.joints.size(), 256, 4096));
    double sum = 0;
    planning::PathPoint at;
    std::optional<Vec3> last;
    for (double k = 0; k <= looks; ++k) {
      path.joints.sample(whole * k / looks, at);
      const auto X_BT = space_.forward({at.q.data(), space_.size()}, X_near_);
      if (X_BT) X_near_ = *X_BT;
      if (last) sum += norm(X_near_.p - *last);
      last = X_near_.p;
    }
    return sum;
  }

 private:
  const planning::ToolSpace& space_;
  planning::PoseBT X_near_;
};

/// How long motions would take if their wire carried any speed.
class TimeByLimits {
 public:
  explicit TimeByLimits(const RobotModel& model) : limits_(planning::motion_limits(model)) {
    if (std::isfinite(planning::shared_velocity(model))) {
      timing_ = std::make_unique<planning::PathTiming>();
      law_ = std::make_unique<planning::TimeLaw>(timing_->phases_max());
    }
  }

  /// @return  s
  double duration(const planning::PlannedMotion& motion) {
    if (!timing_) return motion.law.duration();
    const bool timed = !timing_->prepare(motion.path, limits_) && !timing_->plan({}, 1, *law_);
    return timed ? law_->duration() : motion.law.duration();
  }

 private:
  std::vector<motion::AxisLimits> limits_;
  std::unique_ptr<planning::PathTiming> timing_;  ///< null where the wire counts for nothing
  std::unique_ptr<planning::TimeLaw> law_;
};

/// Why a motion stops where a blend was asked for; empty where none was.
std::string stop_text(const program::MoveOrder& move) {
  using Reason = program::CornerStopReason;
  switch (move.stop) {
    case Reason::kNone:
      return {};
    case Reason::kCostsTime:
      return fmt::format(
          "stops at its end: with the blend asked for there it would take {} s "
          "longer",
          number(move.stop_saves, 3));
    case Reason::kNoWay:
      return "stops at its end: no blend, since this row or the next one goes nowhere";
    case Reason::kNoFit:
      break;
  }
  return "stops at its end: no blend fits there, neither the one asked for nor a smaller one, that "
         "keeps the joints and the tool inside what they may do";
}

MotionSummary summary_of(const program::RowMotion& pieces, const planning::PlannedMotion& motion,
                         const RobotModel& model) {
  MotionSummary summary{.duration = motion.law.duration(),
                        .on_wire = pieces.duration,
                        .pieces = pieces.pieces.size(),
                        .limits = motion.limits};
  for (const planning::Slowdown& slowdown : motion.stretch.slowdowns) {
    summary.notes.push_back(slowdown_text(slowdown, model));
  }
  const bool stops = model.device.capability.motion == MotionKind::kPointToPoint;
  if (stops && summary.pieces > 1) {
    summary.notes.push_back(
        fmt::format("the device takes whole moves only: {} of them from stop to stop, at most {} "
                    "mm off the way",
                    summary.pieces, number(program::RowPlanner::kWayTolerance * 1e3)));
  }
  return summary;
}

std::string overlap_text(const planning::Clearance& overlap, const RobotModel& model) {
  const auto name = [&](std::uint8_t shape) {
    const bool table = shape == planning::kTableShape;
    return std::string(link_name(model, table ? kTableLink : model.collision.shapes[shape].link));
  };
  const std::string pair = name(overlap.first) + " and " + name(overlap.second);
  if (overlap.distance >= 0) {
    return fmt::format("{} are {} mm apart there", pair, number(to_mm(overlap.distance), 1));
  }
  return fmt::format("by the robot's file {} overlap by {} mm there", pair,
                     number(-to_mm(overlap.distance), 1));
}

/// Follows a plan's orders, motion by motion.
class Follower {
 public:
  Follower(const Wanted& wanted, const program::Plan& orders, MotionPlan& plan)
      : wanted_(wanted),
        planner_(wanted.model),
        recorder_(plan, planner_.space(), std::max(kSampleStep, orders.duration / kSamplesMax)),
        by_limits_(wanted.model),
        way_(planner_.space()),
        plan_(plan) {}

  std::expected<void, program::Refusal> follow(const program::Order& order) {
    if (const auto* wait = std::get_if<program::WaitOrder>(&order.what)) {
      recorder_.wait(to_seconds(wait->duration));
      plan_.by_limits += to_seconds(wait->duration);
    } else if (const auto* home = std::get_if<program::HomeOrder>(&order.what)) {
      search(order, *home);
    } else if (const auto* pick = std::get_if<program::PickOrder>(&order.what)) {
      handle(order, "pick", pick->duration);
    } else if (const auto* place = std::get_if<program::PlaceOrder>(&order.what)) {
      handle(order, "place", place->duration);
    } else if (const auto* move = std::get_if<program::MoveOrder>(&order.what)) {
      if (move->first_move) {
        first_move(order, *move);
        return {};
      }
      const auto pieces = planner_.plan(*move->q_start, move->tool, move->rows);
      if (!pieces) return std::unexpected(pieces.error());
      if (planner_.motion().empty()) return {};
      recorder_.add(*move->q_start, *pieces, planner_.motion());
      auto summary = summarise(*pieces, planner_.motion());
      if (const std::string why = stop_text(*move); !why.empty()) summary.notes.push_back(why);
      tell(std::move(summary), order, *move->q_start);
    }
    return {};
  }

 private:
  /// One slow piece back, of which the plan knows only how long it takes.
  void first_move(const program::Order& order, const program::MoveOrder& move) {
    MotionSummary summary{.at_most = move.duration};
    summary.notes.push_back(
        "it begins outside the limits, where the robot has no pose, or hits something on its way "
        "by "
        "the model: slowly, in one piece, and nothing on the way is checked");
    recorder_.wait(move.duration);
    plan_.by_limits += move.duration;
    tell(std::move(summary), order, *move.q_start);
  }

  /// What a camera decides; it ends where it begins.
  void handle(const program::Order& order, const char* what, double duration) {
    recorder_.wait(duration);
    plan_.by_limits += duration;
    tell({.what = what, .at_most = duration}, order, {});
  }

  /// The search for the zeros, and the way home behind it.
  void search(const program::Order& order, const program::HomeOrder& home) {
    MotionSummary search{.what = "home", .at_most = home.duration_max};
    search.notes.push_back(
        "nobody knows where homing begins, so nobody can check it: watch the "
        "arm, and the switch that stops it");
    if (home.back) search.at_most -= home.back->duration;
    if (home.back && home.back->overlap) {
      search.notes.push_back("the joints rest beside their end stops behind it; " +
                             overlap_text(*home.back->overlap, wanted_.model) +
                             ", and it cannot be told whether they meet on the way");
    }
    if (home.back && home.back->q_end != home_joints(wanted_.model)) {
      search.notes.push_back(error_text({ErrorCode::kNoWayHome}, wanted_.model));
    }
    tell(std::move(search), order, {});
    if (!home.back) return;
    plan_.homing_max -= home.back->duration;
    plan_.on_wire += home.back->duration;
    JointVector q = home.back->q_start;
    for (const program::HomeLeg& leg : home.back->legs) {
      recorder_.add(q, leg.motion, leg.planned);
      q = leg.motion.q_end;
      auto summary = summarise(leg.motion, leg.planned);
      summary.what = "to home";
      if (leg.slow) summary.notes.push_back("slowly, out of where the model has it overlap");
      tell(std::move(summary), order, leg.motion.q_end);
    }
  }

  MotionSummary summarise(const program::RowMotion& pieces, const planning::PlannedMotion& motion) {
    auto summary = summary_of(pieces, motion, wanted_.model);
    summary.length = way_.length(motion.path);
    plan_.way += summary.length;
    constexpr double kRounded = 0.05e-3;  // m
    if (const double off = recorder_.off(pieces.q_end); off > kRounded) {
      summary.notes.push_back(fmt::format(
          "as the wire rounds its places the tool ends {} mm beside it", number(to_mm(off), 1)));
    }
    summary.by_limits = by_limits_.duration(motion);
    plan_.by_limits += summary.by_limits;
    return summary;
  }

  /// Rounds of a loop that are all the same are told once.
  void tell(MotionSummary summary, const program::Order& order, const JointVector& q) {
    summary.first = order.line;
    summary.last = order.last_line;
    Key key{order.line, order.last_line, summary.what, {}};
    constexpr double kSame = 1e-6;  // rad, m: what rounds of a loop differ by is rounding
    for (const double value : q) std::get<3>(key).push_back(std::round(value / kSame));
    if (const auto known = told_.find(key); known != told_.end()) {
      ++plan_.motions[known->second].times;
      return;
    }
    if (plan_.motions.size() == kMotionsShown) return;
    told_.emplace(key, plan_.motions.size());
    plan_.motions.push_back(std::move(summary));
  }

  using Key = std::tuple<int, int, std::string, std::vector<double>>;

  const Wanted& wanted_;
  program::RowPlanner planner_;
  Recorder recorder_;
  TimeByLimits by_limits_;
  ToolLength way_;
  MotionPlan& plan_;
  std::map<Key, std::size_t> told_;  ///< and where in the plan
};

std::string refused_from_nowhere(int line, const char* otherwise) {
  return fmt::format(
      "planned from its home pose; an arm that does not know where it stands refuses line {} "
      "unless sinew run --standing-at says it{}",
      line, otherwise);
}

/// Boards that have just been switched on take no move before they were homed.
void tell_unhomed(const program::Plan& orders, MotionPlan& plan) {
  for (const program::Order& order : orders.orders) {
    if (std::holds_alternative<program::HomeOrder>(order.what)) return;
    if (!std::holds_alternative<program::MoveOrder>(order.what)) continue;
    plan.notes.push_back(refused_from_nowhere(order.line, ", or a row home stands before it"));
    return;
  }
}

/// An open-loop arm does not know where it stands: its first move is another one than if it did.
void tell_first_move(const Wanted& wanted, const program::Plan& known,
                     const program::Homing& homing, MotionPlan& plan) {
  if (wanted.declared || wanted.file.empty()) return;
  if (!boards_of(plan.model.device).empty()) return tell_unhomed(known, plan);
  const DeviceSettings& device = *plan.model.device.settings;
  const bool reports = plan.model.device.capability.feedback != PositionFeedback::kNone;
  if (reports || device.shows_power_loss() || device.counts_from_power_up()) return;
  const auto orders = program::make_plan(wanted.program, plan.model, std::nullopt, homing);
  if (!orders) {
    plan.notes.push_back(refused_from_nowhere(orders.error().line, ""));
    return;
  }
  plan.on_wire = orders->duration;
  for (const program::Order& order : orders->orders) {
    const auto* move = std::get_if<program::MoveOrder>(&order.what);
    if (move == nullptr || !move->first_move) continue;
    plan.notes.push_back(
        fmt::format("the arm does not know where it stands: line {} takes {} s, slowly; sinew run "
                    "--standing-at says where it is",
                    order.line, number(move->duration, 2)));
  }
}

/// What a motion is planned with is less than what the robot's file allows.
void tell_share(MotionPlan& plan) {
  const double share = plan.model.device.capability.limits_share;
  if (share == 1) return;
  plan.notes.push_back(fmt::format(
      "planned with {} % of the limits: the device needs the rest to catch up and to round",
      number(share * 100, 1)));
}

/// Both branches of an `if` are shown, one behind the other; the device takes one of them.
void tell_branches(const program::Plan& orders, MotionPlan& plan) {
  const auto branches = [](const program::Order& order) {
    return std::holds_alternative<program::BranchOrder>(order.what);
  };
  if (std::ranges::none_of(orders.orders, branches)) return;
  plan.notes.push_back(fmt::format(
      "an if decides when the run comes there: both of its branches are checked and shown, the run "
      "takes {} to {} s",
      number(orders.duration_min, 3), number(orders.duration, 3)));
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
  if (request.cell) return dry_run(request);
  const auto wanted = prepare(request);
  if (!wanted) return wanted.error();
  const RobotModel& model = wanted->model;
  const program::Homing homing = runtime::homing_of(model);
  const auto orders = program::make_plan(wanted->program, model, wanted->from, homing);
  if (!orders) {
    const std::string file = file_of(wanted->program, orders.error().file, wanted->file);
    return plan_refusal(model, file, orders.error());
  }
  MotionPlan plan{.model = model, .motions = {}, .notes = {}, .samples = {}, .heaviest = {}};
  if (!wanted->file.empty()) plan.rows = "lines";
  plan.on_wire = orders->duration;
  plan.homing_max = orders->homing_max;
  plan.notes = unheard_notes(*orders, model, "is");
  for (const program::ProgramNote& one : wanted->program.notes) {
    plan.notes.push_back(fmt::format("line {}: {}", one.line, one.sentence));
  }
  tell_branches(*orders, plan);
  tell_share(plan);
  Follower follower(*wanted, *orders, plan);
  for (const program::Order& order : orders->orders) {
    if (const auto done = follower.follow(order); !done) {
      return plan_refusal(model, wanted->file, done.error());
    }
  }
  tell_first_move(*wanted, *orders, homing, plan);
  if (const auto weighed = weigh(*orders, plan); !weighed) {
    return plan_refusal(model, wanted->file, weighed.error());
  }
  return finish(plan, request);
}

void add_plan(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<PlanRequest>();
  PlanRequest& request = *own;
  CLI::App* verb = add_verb(
      app, call, "plan", "a motion along a way, checked and timed; nothing moves",
      "sinew plan robot-arm-2 --from-joints 0,-30,-30,0,30,0 --to 400,150,300 --to 400,-150,300 "
      "--speed 80mm/s --plot plan.svg");
  verb->add_option("ROBOT", request.subject, "id or .toml file; or a program NAME.sinew")
      ->required();
  verb->add_option("--robot", request.robot, "of a program: id or .toml file");
  add_variant(*verb, request);
  verb->add_option("--to", request.to,
                   "x,y,z or x,y,z,rx,ry,rz: a straight line of the tool; joints=a,b,..: a joint "
                   "move; again for each further move")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  verb->add_option("--from-joints", request.from, "where it starts; home where left out");
  verb->add_option("--speed", request.speed,
                   "of the tool, as in 80mm/s; what it can where left out");
  verb->add_option("--blend", request.blend,
                   "how far from a corner the tool may leave its line, as in 10mm; a stop where "
                   "left out");
  verb->add_option("--plot", request.plot, "SVG file: joints against their limits, the tool's way");
  verb->add_option("--in-cell", request.cell, "CELL.toml: a dry run with its camera's picture");
  verb->callback([&call, own] { call.verb = [own] { return plan(*own); }; });
}

}  // namespace sinew::cli
