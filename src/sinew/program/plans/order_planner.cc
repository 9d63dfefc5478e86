#include "sinew/program/plans/order_planner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/model/hand.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"
#include "sinew/program/plans/cube_rows.h"

namespace sinew::program {
namespace {

constexpr std::size_t kTurnsMax = 4 * kOrdersMax;
/// Different motions of one program: each takes about a millisecond to plan.
constexpr std::size_t kMotionsMax = 20'000;
/// Places that differ by rounding only are one; rad or m.
constexpr double kSamePlace = 1e-9;

Error too_long() {
  constexpr auto kMax = static_cast<double>(kOrdersMax);
  return {ErrorCode::kProgramTooLong, -1, kMax + 1, kMax};
}

Refusal refused(const Step& step, const Error& error) {
  return {step.line, error, std::nullopt, step.file};
}

/// Why it cannot take cubes; nothing where it can.
std::optional<Error> pick_refusal(const RobotModel& robot) {
  if (can_pick(robot)) return std::nullopt;
  const bool has_jaws = jaws_of(robot) != nullptr;
  return Error{has_jaws ? ErrorCode::kTaskNotSupported : ErrorCode::kToolNotFitted};
}

/// What this robot's tool cannot do; nothing where it can.
std::optional<Error> tool_refusal(const RobotModel& robot, const ToolAction& action) {
  const HandDrive hand = robot.device.capability.hand;
  constexpr double kNozzleMax = kPi;  // 500 to 2500 us
  constexpr double kTolerance = 1e-9;
  if (const auto* jaws = std::get_if<JawsTo>(&action)) {
    const JawGripper* fitted = jaws_of(robot);
    if (fitted == nullptr) return Error{ErrorCode::kToolNotFitted};
    const double widest = fitted->width_max;
    if (jaws->width >= 0 && jaws->width <= widest + kTolerance) return std::nullopt;
    return Error{ErrorCode::kJawWidth, -1, jaws->width, widest};
  }
  if (const auto* gripper = std::get_if<GripperTo>(&action)) {
    if (hand != HandDrive::kServo) return Error{ErrorCode::kToolNotFitted};
    return robot.device.settings->gripper_refusal(*gripper);
  }
  if (hand != HandDrive::kSuction) return Error{ErrorCode::kToolNotFitted};
  const auto* nozzle = std::get_if<NozzleTo>(&action);
  if (nozzle == nullptr) return std::nullopt;
  const double angle = nozzle->angle;
  if (angle >= -kTolerance && angle <= kNozzleMax + kTolerance) return std::nullopt;
  return Error{ErrorCode::kToolAngle, -1, angle, angle < 0 ? 0 : kNozzleMax};
}

bool inside_limits(const JointVector& q, const RobotModel& robot) {
  for (std::size_t i = 0; i < q.size(); ++i) {
    if (!within_limits(robot.joints[i], q[i])) return false;
  }
  return true;
}

/// `home` where there are no end stops to search for: all joints to the robot's home.
Step home_row(const Step& step, const RobotModel& robot) {
  JointStep row{.q = home_joints(robot), .given = 0, .how = {}};
  row.given = static_cast<std::uint8_t>((1U << robot.joints.size()) - 1);
  row.how.time = std::get<HomeStep>(step.what).time;
  return {step.line, row, step.file};
}

/// While a joint is left out only rows move that say where each other joint goes.
std::optional<Error> left_out_refusal(const RobotModel& robot, const Step& step) {
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    if (!is_left_out(robot, i)) continue;
    if (const auto* joint = std::get_if<JointStep>(&step.what)) {
      const bool relative = (joint->relative >> i & 1) != 0;
      const double stays = relative ? 0 : assumed_place(robot.joints[i]);
      if ((joint->given >> i & 1) == 0 || joint->q[i] == stays) continue;
    }
    return Error{ErrorCode::kPositionUnknown, static_cast<std::int8_t>(i)};
  }
  return std::nullopt;
}

/// s, about: a picture, and what is on it.
constexpr double kLookTime = 0.5;
/// s, about: there, down, closing, up, back.
constexpr double kPickTime = 10;
constexpr double kPlaceTime = 6;

/// One loop that is being unrolled.
struct Open {
  std::size_t loop = 0;
  int round = 1;
};

}  // namespace

OrderPlanner::OrderPlanner(const RobotModel& robot, const Standing& start, const Homing& homing)
    : robot_(robot), homing_(homing), stands_{Stand{.q = start.q, .tool = start.tool}} {}

/// Made when it is needed first: it holds workspace.
RowPlanner& OrderPlanner::planner() {
  if (!planner_) planner_ = std::make_unique<RowPlanner>(robot_);
  return *planner_;
}

void OrderPlanner::show_to(const WayLook& look) {
  planner().show_to(look);
}

std::optional<Refusal> OrderPlanner::take_all(const Program& program) {
  table_ = program.table.get();
  std::vector<Open> open;
  std::size_t turns = 0;  // empty loops turn without an order
  for (std::size_t place = 0; place < program.steps.size(); ++place) {
    const Step& step = program.steps[place];
    if (const auto* loop = std::get_if<LoopStep>(&step.what)) {
      open.push_back({place, 1});
      if (!loop->goes_on) continue;
      rounds_.emplace_back();
      if (auto refusal = begin_round(step, *loop->goes_on, place, {1, loop->rounds})) {
        return refusal;
      }
      continue;
    }
    const auto* end = std::get_if<EndStep>(&step.what);
    if (end != nullptr && !std::holds_alternative<IfStep>(program.steps[end->loop].what)) {
      const auto& loop = std::get<LoopStep>(program.steps[open.back().loop].what);
      if (++turns > kTurnsMax) return refused(step, too_long());
      if (open.back().round < loop.rounds) {
        ++open.back().round;
        place = open.back().loop;
        if (!loop.goes_on) continue;
        const Round round{open.back().round, loop.rounds};
        auto refusal = begin_round(program.steps[place], *loop.goes_on, place, round);
        if (refusal) return refusal;
      } else {
        open.pop_back();
        if (!loop.goes_on) continue;
        if (auto refusal = end_rounds(step)) return refusal;
      }
      continue;
    }
    Round round;
    if (!open.empty()) {
      round = {open.back().round, std::get<LoopStep>(program.steps[open.back().loop].what).rounds};
    }
    if (auto refusal = take(step, place, round)) return refusal;
  }
  if (auto refusal = finish()) return refusal;
  plan_.duration_min = std::numeric_limits<double>::infinity();
  for (const Stand& stand : stands_) {
    plan_.duration = std::max(plan_.duration, stand.most);
    plan_.duration_min = std::min(plan_.duration_min, stand.least);
    plan_.homing_max = std::max(plan_.homing_max, stand.homing);
  }
  return std::nullopt;
}

std::optional<Refusal> OrderPlanner::take(const Step& step, std::size_t place, Round round) {
  if (std::holds_alternative<HomeStep>(step.what) && !robot_.device.settings->searches_zeros()) {
    return take(home_row(step, robot_), place, round);
  }
  if (motion_of(step) != nullptr) {
    if (const auto error = left_out_refusal(robot_, step)) {
      if (auto refusal = finish()) return refusal;
      now_ = round;
      return refuse(refused(step, *error), place);
    }
    now_ = round;
    if (rows_.empty()) first_ = round;
    rows_.push_back(step);
    places_.push_back(place);
    // Too many for one motion: what there is goes first.
    const bool more = motion_of(step)->blends() && rows_.size() < RowPlanner::kRowsMax;
    return more ? std::nullopt : finish();
  }
  if (auto refusal = finish()) return refusal;
  now_ = round;
  if (const auto* branch = std::get_if<IfStep>(&step.what))
    return begin_branch(step, *branch, place);
  if (std::holds_alternative<ElseStep>(step.what)) return other_branch(step);
  if (std::holds_alternative<EndStep>(step.what)) return end_branch(step);
  Order order{step.line, step.line, round.round, round.rounds, HomeOrder{}, step.file};
  if (auto refusal = take_alone(step, place, order)) return refuse(*refusal, place);
  return add(std::move(order));
}

/// A row that neither moves along a way nor decides.
std::optional<Refusal> OrderPlanner::take_alone(const Step& step, std::size_t place, Order& order) {
  if (std::holds_alternative<HomeStep>(step.what)) return take_home(step, place, order);
  if (std::holds_alternative<ToolStep>(step.what)) return take_tool(step, place, order);
  if (std::holds_alternative<LookStep>(step.what)) {
    order.what = LookOrder{std::get<LookStep>(step.what).camera, kLookTime};
    pass_time(kLookTime, kLookTime);
    tell_fine(std::span(&place, 1), kLookTime, kLookTime);
    return std::nullopt;
  }
  if (std::holds_alternative<PickCubeStep>(step.what)) return take_pick(step, place, order);
  if (std::holds_alternative<PlaceCubeStep>(step.what)) return take_place(step, place, order);
  const auto& wait = std::get<WaitStep>(step.what);
  if (wait.what == WaitStep::For::kCondition) {
    if (auto refusal = condition_refusal(wait.until, step)) return refusal;
  }
  const double most = to_seconds(wait.duration);
  const double least = wait.what == WaitStep::For::kTime ? most : 0;
  pass_time(least, most);
  order.what = WaitOrder{wait.duration, wait.what, wait.until};
  tell_fine(std::span(&place, 1), least, most);
  return std::nullopt;
}

void OrderPlanner::pass_time(double least, double most) {
  for (Stand& stand : stands_) {
    stand.least += least;
    stand.most += most;
  }
}

/// What will be seen is unknown: a usual cube in the jaws is planned with behind it.
std::optional<Refusal> OrderPlanner::take_pick(const Step& step, std::size_t place, Order& order) {
  if (const auto error = pick_refusal(robot_)) return refused(step, *error);
  for (Stand& stand : stands_) {
    if (!stand.q && !stand.lost_by) return refused(step, {ErrorCode::kPositionUnknown, 0});
    if (jaws_of(robot_) != nullptr) stand.tool = {kUsualCube, kUsualCube};
  }
  pass_time(kLookTime, kPickTime);
  order.what = PickOrder{std::get<PickCubeStep>(step.what), kPickTime};
  tell_fine(std::span(&place, 1), kLookTime, kPickTime);
  return std::nullopt;
}

std::optional<Refusal> OrderPlanner::take_place(const Step& step, std::size_t place, Order& order) {
  if (const auto error = pick_refusal(robot_)) return refused(step, *error);
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (Stand& stand : stands_) {
    if (stand.lost_by) continue;
    if (!stand.q) return refused(step, {ErrorCode::kPositionUnknown, 0});
    const auto rows = planned_place(stand, step, place);
    if (!rows) return rows.error();
    stand.tool = rows->tool;
    stand.least += rows->duration;
    stand.most += rows->duration;
    least = std::min(least, rows->duration);
    most = std::max(most, rows->duration);
  }
  order.what = PlaceOrder{std::get<PlaceCubeStep>(step.what), most};
  tell_fine(std::span(&place, 1), std::min(least, most), most);
  return std::nullopt;
}

/// The same in each round of a loop.
std::expected<OrderPlanner::Placed, Refusal> OrderPlanner::planned_place(const Stand& stand,
                                                                         const Step& step,
                                                                         std::size_t place) {
  const bool in_basket =
      std::holds_alternative<BasketGoal>(std::get<PlaceCubeStep>(step.what).there);
  // Read without a cell: it is looked up where it runs.
  if (in_basket && table_ == nullptr) {
    return Placed{jaws_of(robot_) != nullptr ? ToolState{2 * kUsualCube, {}} : stand.tool,
                  kPlaceTime};
  }
  const Key key{{place}, {stand.q->begin(), stand.q->end()}, stand.tool.jaws, stand.tool.held};
  if (const auto known = placed_.find(key); known != placed_.end()) return known->second;
  const auto rows = rows_to_place(planner(), {*stand.q, stand.tool}, step, table_);
  if (!rows) return std::unexpected(rows.error());
  return placed_.emplace(key, Placed{rows->tool, rows->duration}).first->second;
}

/// Rounds that are predicted: as many as cubes are seen now.
int OrderPlanner::expected_rounds(const Condition& goes_on) const {
  if (table_ == nullptr || !table_->seen) return kSeenRoundsMax;
  const auto counts = [&](const grasping::Cube& cube) {
    return !goes_on.color || cube.color == static_cast<int>(*goes_on.color);
  };
  return static_cast<int>(std::ranges::count_if(table_->seen->cubes, counts));
}

std::optional<Refusal> OrderPlanner::begin_round(const Step& step, const Condition& goes_on,
                                                 std::size_t place, Round round) {
  if (auto refusal = finish()) return refusal;
  now_ = round;
  if (const auto refusal = condition_refusal(goes_on, step)) {
    if (auto told = refuse(*refusal, place)) return told;
  }
  rounds_.back().branches.push_back(plan_.orders.size());
  merge(rounds_.back().ends, stands_);
  if (round.round > expected_rounds(goes_on) && !rounds_.back().longest) {
    double longest = 0;
    for (const Stand& stand : stands_) longest = std::max(longest, stand.most);
    rounds_.back().longest = longest;
    ++unexpected_;
  }
  return add({step.line, step.line, round.round, round.rounds, BranchOrder{goes_on, 0}, step.file});
}

std::optional<Refusal> OrderPlanner::end_rounds(const Step& step) {
  if (auto refusal = finish()) return refusal;
  const OpenRounds rounds = std::move(rounds_.back());
  rounds_.pop_back();
  for (const std::size_t branch : rounds.branches) {
    std::get<BranchOrder>(plan_.orders[branch].what).otherwise = plan_.orders.size();
  }
  merge(stands_, rounds.ends);
  if (rounds.longest) {
    --unexpected_;
    for (Stand& stand : stands_) stand.most = std::min(stand.most, *rounds.longest);
  }
  return check_places(step);
}

std::optional<Refusal> OrderPlanner::check_places(const Step& step) const {
  if (stands_.size() <= kPlacesMax) return std::nullopt;
  return refused(step, {ErrorCode::kTooManyPlaces, -1, static_cast<double>(stands_.size()),
                        static_cast<double>(kPlacesMax)});
}

std::optional<Refusal> OrderPlanner::take_tool(const Step& step, std::size_t place, Order& order) {
  const ToolAction& action = std::get<ToolStep>(step.what).action;
  if (const auto error = tool_refusal(robot_, action)) return refused(step, *error);
  const auto* jaws = std::get_if<JawsTo>(&action);
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (Stand& stand : stands_) {
    const double duration =
        to_seconds(robot_.device.settings->tool_time(robot_, action, stand.tool.jaws));
    if (jaws != nullptr) {
      if (const auto fine = check_jaws(stand, jaws->width); !fine) {
        return refused(step, fine.error());
      }
      stand.tool = {jaws->width, jaws->held};
    }
    stand.least += duration;
    stand.most += duration;
    least = std::min(least, duration);
    most = std::max(most, duration);
  }
  order.what = ToolOrder{action, most};
  tell_fine(std::span(&place, 1), least, most);
  return std::nullopt;
}

/// Closing jaws reach farther: into what lies below them, too.
Expected<void> OrderPlanner::check_jaws(const Stand& stand, double to) {
  if (!stand.q) return {};
  return planner().check_jaws(*stand.q, stand.tool, to);
}

std::optional<Refusal> OrderPlanner::take_home(const Step& step, std::size_t place, Order& order) {
  const auto home = plan_home(step.line);
  if (!home) {
    Refusal refusal = home.error();
    refusal.file = step.file;
    return refusal;
  }
  for (Stand& stand : stands_) {
    stand.homing += home->duration_max;
    stand.q = home->back ? home->back->q_end : home_joints(robot_);
    stand.lost_by.reset();
  }
  std::vector<Stand> stands;
  merge(stands, stands_);
  stands_ = std::move(stands);
  order.what = *home;
  tell_fine(std::span(&place, 1), 0, home->duration_max);
  return std::nullopt;
}

/// Plans the motions that are still waiting for rows to blend with. Where they may begin at several
/// places, the first one decides how many rows an order takes.
std::optional<Refusal> OrderPlanner::finish() {
  Rows rows = rows_;
  Places places = places_;
  while (!rows.empty()) {
    const Start q_start = stands_[0].q;
    const ToolState tool = stands_[0].tool;
    const auto motion = advance(stands_[0], rows, places);
    if (!motion) return motion.error();
    plan_.limits.add(motion->limits);
    const Rows taken = rows.first(motion->rows);
    double slowest = motion->duration;
    for (std::size_t i = 1; i < stands_.size(); ++i) {
      double duration = 0;
      for (std::size_t row = 0; row < taken.size();) {
        const auto part =
            advance(stands_[i], taken.subspan(row), places.subspan(row, taken.size() - row));
        if (!part) return part.error();
        duration += part->duration;
        row += part->rows;
      }
      slowest = std::max(slowest, duration);
    }
    Order order{taken.front().line, taken.back().line, first_.round, first_.rounds, {},
                taken.front().file};
    order.what = MoveOrder{{taken.begin(), taken.end()},
                           q_start,
                           motion->q_end,
                           tool,
                           slowest,
                           motion->stop,
                           motion->stop_saves,
                           motion->first_move,
                           stands_.size()};
    if (auto refusal = add(std::move(order))) return refusal;
    if (stands_.size() > 1) {
      std::vector<Stand> stands;
      merge(stands, stands_);
      stands_ = std::move(stands);
    }
    rows = rows.subspan(motion->rows);
    places = places.subspan(motion->rows);
  }
  rows_.clear();
  places_.clear();
  return std::nullopt;
}

/// One motion from one of the places, which it leaves for its end.
std::expected<OrderPlanner::Planned, Refusal> OrderPlanner::advance(Stand& stand, Rows rows,
                                                                    Places places) {
  if (stand.lost_by) return lost(stand, rows[0], places[0]);
  const auto motion = plan_motion(stand, rows, places);
  if (!motion) {
    const auto& why = motion.error();
    const std::size_t row = why.way ? why.way->refusal.place.move : 0;
    Refusal refusal = why;
    refusal.file = rows[row].file;
    // One that came because there are too many is nobody's row.
    if (verdicts_ == nullptr || why.error.code == ErrorCode::kProgramTooLong) {
      return std::unexpected(refusal);
    }
    // Those before it are planned without it.
    if (row > 0) return advance(stand, rows.first(row), places.first(row));
    refuse(refusal, places[0]);
    recover(stand, rows[0], places[0], refusal);
    return Planned{1, stand.q.value_or(JointVector{}), 0, CornerStopReason::kNone, 0, false};
  }
  stand.q = motion->q_end;
  stand.least += motion->duration;
  stand.most += motion->duration;
  tell_fine(places.first(motion->rows), motion->duration, motion->duration);
  return *motion;
}

std::expected<OrderPlanner::Planned, Refusal> OrderPlanner::plan_motion(const Stand& stand,
                                                                        Rows rows, Places places) {
  const auto slow = [&](const JointVector& q) {
    return Planned{1, q, first_move_duration(robot_), CornerStopReason::kNone, 0, true};
  };
  if (!plannable(stand.q, robot_)) {
    const auto q = first_target(rows[0], stand.q, robot_);
    if (!q) return std::unexpected(q.error());
    return slow(*q);
  }
  Key key{{places.begin(), places.end()},
          {stand.q->begin(), stand.q->end()},
          stand.tool.jaws,
          stand.tool.held};
  if (const auto known = known_.find(key); known != known_.end()) return known->second;
  if (known_.size() == kMotionsMax) {
    constexpr auto kMax = static_cast<double>(kMotionsMax);
    return std::unexpected(
        Refusal{rows[0].line, {ErrorCode::kProgramTooLong, -1, kMax + 1, kMax}, std::nullopt});
  }
  const auto motion = planner().plan(*stand.q, stand.tool, rows);
  if (!motion) {
    if (const auto q = slow_way_back(rows[0], *stand.q, motion.error(), robot_)) return slow(*q);
    return std::unexpected(motion.error());
  }
  const Planned planned{motion->rows,       motion->q_end, motion->duration,         motion->stop,
                        motion->stop_saves, false,         planner().motion().limits};
  known_.emplace(std::move(key), planned);
  return planned;
}

std::expected<HomeOrder, Refusal> OrderPlanner::plan_home(int line) {
  HomeOrder home{std::accumulate(homing_.times.begin(), homing_.times.end(), 0.0), nullptr};
  if (!back_ && homing_.rest) {
    auto back = home_return(robot_, *homing_.rest, line);
    if (!back) return std::unexpected(back.error());
    back_ = std::make_shared<const HomeReturn>(std::move(*back));
  }
  home.back = back_;
  if (back_) home.duration_max += back_->duration;
  return home;
}

std::optional<Refusal> OrderPlanner::begin_branch(const Step& step, const IfStep& branch,
                                                  std::size_t place) {
  if (const auto refusal = condition_refusal(branch.condition, step)) {
    if (auto told = refuse(*refusal, place)) return told;
  }
  open_.push_back({plan_.orders.size(), stands_});
  return add(
      {step.line, step.line, now_.round, now_.rounds, BranchOrder{branch.condition, 0}, step.file});
}

std::optional<Refusal> OrderPlanner::other_branch(const Step& step) {
  OpenIf& open = open_.back();
  open.jump = plan_.orders.size();
  if (auto refusal = add({step.line, step.line, now_.round, now_.rounds, JumpOrder{}, step.file})) {
    return refusal;
  }
  std::get<BranchOrder>(plan_.orders[open.branch].what).otherwise = plan_.orders.size();
  open.then_ends = std::move(stands_);
  stands_ = open.before;
  return std::nullopt;
}

std::optional<Refusal> OrderPlanner::end_branch(const Step& step) {
  const OpenIf open = std::move(open_.back());
  open_.pop_back();
  if (open.jump) {
    std::get<JumpOrder>(plan_.orders[*open.jump].what).to = plan_.orders.size();
    merge(stands_, open.then_ends);
  } else {
    std::get<BranchOrder>(plan_.orders[open.branch].what).otherwise = plan_.orders.size();
    merge(stands_, open.before);
  }
  return check_places(step);
}

/// What a condition asks for and is not known by then.
std::optional<Refusal> OrderPlanner::condition_refusal(const Condition& condition,
                                                       const Step& step) const {
  if (!condition.of_position()) return std::nullopt;
  const auto unknown = [](const Stand& stand) { return !stand.q && !stand.lost_by; };
  if (std::ranges::none_of(stands_, unknown)) return std::nullopt;
  return refused(step, {ErrorCode::kPositionUnknown, static_cast<std::int8_t>(condition.joint)});
}

std::optional<Refusal> OrderPlanner::refuse(const Refusal& refusal, std::size_t place) {
  if (verdicts_ == nullptr) return refusal;
  RowVerdict& verdict = (*verdicts_)[place];
  if (verdict.kind == RowVerdict::Kind::kRefused) return std::nullopt;
  verdict.kind = RowVerdict::Kind::kRefused;
  verdict.refusal = std::make_shared<const Refusal>(refusal);
  verdict.round = now_.round;
  verdict.motion = place;
  return std::nullopt;
}

std::optional<Refusal> OrderPlanner::add(Order order) {
  if (plan_.orders.size() >= kOrdersMax) {
    return Refusal{order.line, too_long(), std::nullopt, order.file};
  }
  order.expected = unexpected_ == 0;
  plan_.orders.push_back(std::move(order));
  return std::nullopt;
}

/// Where a refused row would have left the machine.
void OrderPlanner::recover(Stand& stand, const Step& row, std::size_t place,
                           const Refusal& refusal) {
  const Start from = stand.q;
  stand.q.reset();
  if (from && std::holds_alternative<JointStep>(row.what)) {
    const JointVector q = resolved(std::get<JointStep>(row.what), *from);
    if (inside_limits(q, robot_)) stand.q = q;
  } else if (refusal.way && refusal.way->proposal.move_j) {
    const auto& q = *refusal.way->proposal.move_j;
    stand.q = JointVector(std::span<const double>(q.data(), robot_.joints.size()));
  } else if (from && plannable(from, robot_) && std::holds_alternative<ToolMoveStep>(row.what)) {
    // Its target may be within reach, though not along its way.
    ToolMoveStep there = std::get<ToolMoveStep>(row.what);
    there.way = ToolMoveStep::Way::kJoints;
    there.how = {};
    const Step step{row.line, there, row.file};
    if (const auto motion = planner().plan(*from, stand.tool, std::span(&step, 1)))
      stand.q = motion->q_end;
  }
  if (!stand.q) stand.lost_by = place;
}

/// A row that begins nobody knows where, behind a refused one.
OrderPlanner::Planned OrderPlanner::lost(Stand& stand, const Step& row, std::size_t place) {
  const std::size_t because = *stand.lost_by;
  const auto q = first_target(row, std::nullopt, robot_);
  if (!q && q.error().error.code != ErrorCode::kPositionUnknown) {
    refuse(q.error(), place);
  } else if (RowVerdict& verdict = (*verdicts_)[place];
             verdict.kind == RowVerdict::Kind::kNothing ||
             verdict.kind == RowVerdict::Kind::kFine) {
    verdict.kind = RowVerdict::Kind::kUnchecked;
    verdict.because = because;
    verdict.motion = place;
  }
  if (q) {
    stand.q = *q;
    stand.lost_by.reset();
  }
  return {1, q ? *q : JointVector{}, 0, CornerStopReason::kNone, 0, false};
}

void OrderPlanner::tell_fine(Places places, double least, double most) {
  if (verdicts_ == nullptr) return;
  for (const std::size_t place : places) {
    RowVerdict& verdict = (*verdicts_)[place];
    const bool first = verdict.kind == RowVerdict::Kind::kNothing;
    if (first) verdict.kind = RowVerdict::Kind::kFine;
    if (first) verdict.motion = places[0];
    if (place != places[0] || verdict.kind != RowVerdict::Kind::kFine) continue;
    verdict.time_min = first ? least : std::min(verdict.time_min, least);
    verdict.time_max = std::max(verdict.time_max, most);
  }
}

bool OrderPlanner::same(const Stand& a, const Stand& b) {
  if (a.q.has_value() != b.q.has_value() || !(a.tool == b.tool) || a.lost_by != b.lost_by)
    return false;
  for (std::size_t i = 0; a.q && i < a.q->size(); ++i) {
    if (std::abs((*a.q)[i] - (*b.q)[i]) > kSamePlace) return false;
  }
  return true;
}

void OrderPlanner::merge(std::vector<Stand>& into, const std::vector<Stand>& more) {
  for (const Stand& one : more) {
    const auto known =
        std::ranges::find_if(into, [&](const Stand& other) { return same(one, other); });
    if (known == into.end()) {
      into.push_back(one);
      continue;
    }
    known->least = std::min(known->least, one.least);
    known->most = std::max(known->most, one.most);
    known->homing = std::max(known->homing, one.homing);
  }
}

}  // namespace sinew::program
