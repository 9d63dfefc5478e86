#include "sinew/program/runs/program_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/control/piece_motion.h"
#include "sinew/control/position_evidence.h"
#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/left_out.h"
#include "sinew/program/plans/holdable_motion.h"

namespace sinew::program {

using control::MachineState;

namespace {

/// How long and how nearly the joints stay where they are when they have settled.
constexpr Duration kStillFor = std::chrono::milliseconds(200);
constexpr double kStillTurn = from_deg(0.05);   // rad
constexpr double kStillLength = from_mm(0.02);  // m

/// What an order counts in the progress of a run, s.
double weight(const Order& order) {
  if (!order.expected) return 0;
  if (const auto* move = std::get_if<MoveOrder>(&order.what)) return move->duration;
  if (const auto* wait = std::get_if<WaitOrder>(&order.what)) return to_seconds(wait->duration);
  if (const auto* tool = std::get_if<ToolOrder>(&order.what)) return tool->duration;
  if (const auto* home = std::get_if<HomeOrder>(&order.what)) return home->duration_max;
  if (const auto* pick = std::get_if<PickOrder>(&order.what)) return pick->duration;
  if (const auto* place = std::get_if<PlaceOrder>(&order.what)) return place->duration;
  if (const auto* look = std::get_if<LookOrder>(&order.what)) return look->duration;
  return 0;
}

bool needs_eyes(const Order& order) {
  const auto* branch = std::get_if<BranchOrder>(&order.what);
  return std::holds_alternative<LookOrder>(order.what) ||
         std::holds_alternative<PickOrder>(order.what) ||
         (branch != nullptr && branch->condition.subject == Condition::Subject::kSeen);
}

}  // namespace

Run::Run(const Program& program, control::Machine& machine)
    : program_(program), machine_(machine), robot_(machine.robot()) {}

/// Made when it is needed first: it holds workspace.
RowPlanner& Run::planner() {
  if (!planner_) planner_ = std::make_unique<RowPlanner>(robot_);
  return *planner_;
}

void Run::start(Instant now) {
  opened_at_ = now;
  machine_.give(control::TakeLease{.take_over = take_over_});
}

void Run::stop(Instant /*now*/) {
  if (finished() || phase_ == Phase::kStopping) return;
  wait_end_.reset();
  const bool under_way = command_ != 0;
  phase_ = under_way && phase_ == Phase::kRunning ? Phase::kStopping : Phase::kStopped;
  // Also where nothing of ours is under way: a machine may go on by itself.
  machine_.give(control::Stop{});
}

void Run::pause() {
  if (phase_ != Phase::kRunning) return;
  resumes_ = false;
  // A step back is a pause already, and a motion.
  if (paused_ && !back_steps_) return;
  paused_ = true;
  const bool moves = current_ && (std::holds_alternative<MoveOrder>(current_->order->what) ||
                                  (handles() && task_moves_));
  if (moves && command_ != 0) machine_.give(control::Hold{});
}

void Run::resume() {
  if (!paused_) return;
  paused_ = left_ = false;
  resumes_ = command_ != 0;
  paused_by_.reset();
  forget_picture();
  // A person has looked, even between two polls: what came meanwhile is no news.
  watches_anew_ = true;
  if (std::exchange(watched_, false)) eyes_->watch(false, false);
}

bool Run::stands_held() const {
  return command_ != 0 && machine_.state() == MachineState::kHeld;
}

std::optional<Error> Run::fault() const {
  const auto& latched = machine_.latched();
  if (machine_.state() != MachineState::kFault || !latched) return std::nullopt;
  return latched->error;
}

/// Who paused it may have changed what lies there.
void Run::forget_picture() {
  sighting_.reset();
  beside_.reset();
  given_up_.clear();
  if (looks_) eyes_->look(camera_);
}

void Run::poll(Instant now) {
  go_on(now);
  watch_view(now);
}

/// What comes into view while the arm moves pauses the run; what was seen before counts no more.
void Run::watch_view(Instant now) {
  if (eyes_ == nullptr) return;
  const bool moves = phase_ == Phase::kRunning && looked_ && !paused_ && !looks_ && current_ &&
                     (handles() || std::holds_alternative<MoveOrder>(current_->order->what));
  // A person may do something on the table while it waits.
  if (wait_end_) watches_anew_ = true;
  if (std::exchange(watched_, moves) != moves) {
    eyes_->watch(moves, moves && std::exchange(watches_anew_, false));
  }
  const auto why = moves ? eyes_->disturbed() : std::nullopt;
  if (!why) return;
  paused_by_ = why;
  take_notice(*paused_by_, now);
  pause();
}

void Run::go_on(Instant now) {
  count_held(now);
  while (const auto event = machine_.take_event()) take(*event, now);
  if (phase_ == Phase::kOpening) opening(now);
  if (phase_ != Phase::kRunning) return;
  if (stands_held()) {
    if (resumes_) machine_.give(control::Resume{});
    paused_ = !resumes_;
    resumes_ = false;
  }
  if (wait_end_) look_at_wait(now);
  if (looks_ && !paused_) take_sight(now);
  while (phase_ == Phase::kRunning && task_waits_ && !paused_ && command_ == 0 &&
         machine_.state() == MachineState::kReady) {
    task_waits_ = false;
    if (const auto gone_on = next_task(now); !gone_on) fail(gone_on.error(), now);
  }
  const bool again = (room_since_ || searches_again_) && command_ == 0 && current_ && !paused_;
  if (again && machine_.state() == MachineState::kReady) {
    if (std::exchange(searches_again_, false)) asked_ = control::Home{.resumes = true};
    command_ = machine_.give(*asked_);
  }
  const bool waits = current_ && command_ == 0 && !paused_ && !looks_ && !wait_end_;
  if (waits && fault()) return fail(*fault(), now);
  while (phase_ == Phase::kRunning && !current_ && !paused_) {
    if (next_ < plan_.orders.size()) {
      // A doubt of the driver's, or somebody's motion that is still coming to rest.
      if (const auto why = fault()) {
        const Order& next = plan_.orders[next_];
        return fail({next.line, *why, std::nullopt, next.file}, now);
      }
      if (machine_.state() != MachineState::kReady) return;
    }
    issue_next(now);
  }
}

/// Time since the last poll in which nothing of it went on.
void Run::count_held(Instant now) {
  const bool stands = command_ == 0 || machine_.state() == MachineState::kHeld;
  if (phase_ == Phase::kRunning && paused_ && stands) held_ += now - polled_at_;
  polled_at_ = now;
}

void Run::take(const Event& event, Instant now) {
  using Kind = Event::Kind;
  if (event.kind == Kind::kNotice) return take_notice(event.error, now);
  if (finished()) return;
  if (event.kind == Kind::kLease && machine_.lease().epoch == 0) return leave(now);
  if (event.kind == Kind::kRefused && phase_ == Phase::kOpening) return fail(event.error, now);
  if (event.kind == Kind::kFailed && phase_ == Phase::kOpening) return fail(event.error, now);
  if (event.command != command_ || command_ == 0) return;
  if (event.kind == Kind::kStarted) {
    room_since_.reset();
    return;
  }
  command_ = 0;
  resumes_ = false;  // it ended before it was held
  take_end(event, now);
}

/// The controller holds what moves; nothing more can be asked for without a lease.
void Run::leave(Instant now) {
  if (phase_ == Phase::kOpening && had_lease_) return fail(Error{ErrorCode::kLeaseLost}, now);
  if (phase_ != Phase::kRunning) return;
  left_ = paused_ = true;
  resumes_ = false;
}

std::expected<void, Refusal> Run::step_back(Instant /*now*/) {
  const bool between = phase_ == Phase::kRunning && paused_ && !current_ && command_ == 0;
  if (!between) return std::unexpected(Refusal{0, Error{ErrorCode::kWrongState}});
  left_ = false;
  paused_by_.reset();
  forget_picture();
  if (records_.empty()) return std::unexpected(Refusal{0, Error{ErrorCode::kAtBeginning}});
  const Order& last = *records_.back().order;
  const auto refuse = [&](const Error& error) {
    return std::unexpected(Refusal{last.line, error, std::nullopt, last.file});
  };
  if (std::holds_alternative<ToolOrder>(last.what) ||
      std::holds_alternative<HomeOrder>(last.what) ||
      std::holds_alternative<PickOrder>(last.what) ||
      std::holds_alternative<PlaceOrder>(last.what)) {
    return refuse(Error{ErrorCode::kNotUndone});
  }
  const Start& begin = records_.back().q_start;
  const auto place = static_cast<std::size_t>(&last - plan_.orders.data());
  if (!std::holds_alternative<MoveOrder>(last.what)) {
    records_.pop_back();
    next_ = place;
    return {};
  }
  if (!begin || !plannable(begin, robot_) || !plannable(q_, robot_)) {
    return refuse(Error{ErrorCode::kPositionUnknown, 0});
  }
  JointStep back{.q = *begin, .given = 0, .how = {}};
  back.given = static_cast<std::uint8_t>((1U << begin->size()) - 1);
  const Step row{last.line, back, last.file};
  const auto motion = planner().plan(*q_, machine_.tool(), std::span(&row, 1));
  if (!motion) return std::unexpected(motion.error());
  const Record record = records_.back();
  records_.pop_back();
  next_ = place;
  if (motion->pieces.empty()) return {};
  current_ = record;
  current_->q = motion->q_end;
  current_->duration = current_->arrival = 0;
  back_steps_ = true;
  return send(*motion, planner().motion(), planner().robot(), last.line);
}

const Order* Run::next_order() const {
  // From jump to jump at most as often as there are orders: nothing else would end an empty loop.
  std::size_t place = next_;
  for (std::size_t k = 0; k < plan_.orders.size() && place < plan_.orders.size(); ++k) {
    const auto* jump = std::get_if<JumpOrder>(&plan_.orders[place].what);
    if (jump == nullptr) return &plan_.orders[place];
    place = jump->to;
  }
  return nullptr;
}

/// Of the command under way.
void Run::take_end(const Event& event, Instant now) {
  using Kind = Event::Kind;
  if (phase_ == Phase::kStopping) {
    phase_ = Phase::kStopped;
    return;
  }
  if (phase_ != Phase::kRunning) return;
  switch (event.kind) {
    case Kind::kDone:
      if (const auto gone_on = order_done(now); !gone_on) fail(gone_on.error(), now);
      break;
    case Kind::kRefused:
      if (waits_for_room(event.error, now)) return;
      [[fallthrough]];
    case Kind::kFailed:
      fail(event.error, now);
      break;
    case Kind::kStopped: {
      const auto& latched = machine_.latched();
      if (latched) return fail(latched->error, now);
      const bool search =
          current_ && !back_ && std::holds_alternative<HomeOrder>(current_->order->what);
      if (left_ && search) {
        searches_again_ = true;
        return;
      }
      stopped_by_ = event.cause;
      phase_ = Phase::kStopped;
      break;
    }
    default:
      break;
  }
}

void Run::ask(const control::CommandWhat& what) {
  asked_ = what;
  command_ = machine_.give(what);
}

/// Another robot moves where this motion would go: it is asked for again until that one has gone.
/// Nobody waits for a robot that rests, so no two ever wait for each other.
bool Run::waits_for_room(const Error& error, Instant now) {
  if (error.code != ErrorCode::kCellTaken || !asked_ || !current_) return false;
  if (!room_since_) {
    room_since_ = now;
    take_notice(error, now);
  }
  return now - *room_since_ < kRoomPatience;
}

void Run::take_notice(const Error& error, Instant now) {
  ++notices_told_;
  if (notices_.size() == kNoticesMax) return;
  notices_.push_back(
      {now, current_ ? current_->order->line : 0, error, current_ ? current_->order->file : 0});
}

/// Lease, power, position: whatever is missing is asked for, one after the other.
void Run::opening(Instant now) {
  if (machine_.lease().epoch == 0) return;
  had_lease_ = true;
  const MachineState state = machine_.state();
  if (state == MachineState::kFault) {
    return fail(machine_.latched() ? machine_.latched()->error : Error{ErrorCode::kWrongState},
                now);
  }
  if (state == MachineState::kOff && !enabling_) {
    enabling_ = true;
    machine_.give(control::Enable{});
  }
  if (state != MachineState::kReady) return;
  if (declared_ && !declared_told_ && (declared_->has_looked || !machine_.reference())) {
    declared_told_ = true;
    const auto& last = declared_->last_said;
    control::Declare declare{.positions = {}, .moved = declared_->moved};
    if (!declared_->q) {
      const auto shown =
          control::as_shown(robot_, machine_.positions(), {last.data(), last.size()});
      if (!shown) return fail(shown.error(), now);
      declare.positions = *shown;
    } else {
      for (const double q : *declared_->q) {
        declare.positions.push_back({PositionQuality::kCommanded, q, q, q});
      }
    }
    command_ = machine_.give(declare);
    return;
  }
  if (command_ == 0) begin(now);
}

/// The machine's own word on where it is: the plan is made for that.
void Run::begin(Instant now) {
  q_ = machine_.reference();
  if (uses_baskets(program_) && !program_.table) return fail({ErrorCode::kNoBasket}, now);
  auto plan = make_plan(program_, robot_, {q_, machine_.tool()}, homing_, look_);
  if (!plan) {
    failure_ = plan.error();
    phase_ = Phase::kFailed;
    return;
  }
  plan_ = std::move(*plan);
  if (eyes_ == nullptr) {
    const auto looks = std::ranges::find_if(plan_.orders, needs_eyes);
    if (looks != plan_.orders.end()) {
      failure_ = {looks->line, {ErrorCode::kNoCamera}, std::nullopt, looks->file};
      phase_ = Phase::kFailed;
      return;
    }
  }
  records_.reserve(plan_.orders.size());
  phase_ = Phase::kRunning;
}

void Run::issue_next(Instant now) {
  if (next_ == plan_.orders.size()) {
    phase_ = Phase::kDone;
    return;
  }
  if (const auto* jump = std::get_if<JumpOrder>(&plan_.orders[next_].what)) {
    next_ = jump->to;
    return;
  }
  const Order& order = plan_.orders[next_++];
  current_ = Record{.order = &order,
                    .asked = now,
                    .done = now,
                    .q_start = q_,
                    .q = {},
                    .duration = 0,
                    .arrival = 0,
                    .reported = {},
                    .holds = {}};
  held_at_asked_ = held_;
  if (!begun_at_) {
    begun_at_ = now;
    if (feed_ != 1) machine_.give(control::SetFeed{feed_});
  }
  back_.reset();
  grasps_ = 0;
  gave_up_ = 0;
  if (const auto* look = std::get_if<LookOrder>(&order.what)) {
    sighting_.reset();
    camera_ = look->camera;
  }
  if (const auto accepted = issue(order, now); !accepted) fail(accepted.error(), now);
}

std::expected<void, Refusal> Run::issue(const Order& order, Instant now) {
  if (const auto* move = std::get_if<MoveOrder>(&order.what)) {
    rows_left_ = move->rows;
    return issue_move(now);
  }
  if (const auto* wait = std::get_if<WaitOrder>(&order.what)) {
    wait_end_ = now + wait->duration;
    current_->duration = to_seconds(wait->duration);
    still_.reset();
    return {};
  }
  if (const auto* branch = std::get_if<BranchOrder>(&order.what)) return issue_branch(*branch, now);
  if (std::holds_alternative<LookOrder>(order.what)) {
    const auto seen = sees();
    if (!seen) return std::unexpected(seen.error());
    if (*seen) finish_order(now);
    return {};
  }
  if (const auto* pick = std::get_if<PickOrder>(&order.what)) return issue_pick(*pick, now);
  if (const auto* place = std::get_if<PlaceOrder>(&order.what)) return issue_place(*place);
  if (const auto* tool = std::get_if<ToolOrder>(&order.what)) {
    current_->duration = tool->duration;
    command_ = machine_.give(control::UseTool{tool->action});
    return {};
  }
  current_->duration = std::get<HomeOrder>(order.what).duration_max;
  ask(control::Home{});
  return {};
}

std::expected<void, Refusal> Run::issue_move(Instant now) {
  SINEW_ASSERT(!rows_left_.empty());
  const Step& first = rows_left_.front();
  const auto go_slowly = [&](const JointVector& q) {
    const double duration = first_move_duration(robot_);
    rows_left_ = rows_left_.subspan(1);
    current_->q = q;
    current_->arrival = current_->duration + duration;
    current_->duration += duration;
    send_first_move(q, duration);
  };
  if (!plannable(q_, robot_)) {
    const auto q = first_target(first, q_, robot_);
    if (!q) {
      Refusal why = q.error();
      why.file = first.file;
      return std::unexpected(why);
    }
    go_slowly(*q);
    return {};
  }
  // The arm may stand elsewhere than the plan had it: after homing, or after a first move. Then
  // its corners may not blend as they did, and what was one motion takes several.
  const auto motion = planner().plan(*q_, machine_.tool(), rows_left_);
  if (!motion) {
    const auto q = slow_way_back(first, *q_, motion.error(), robot_);
    if (q) {
      go_slowly(*q);
      return {};
    }
    Refusal why = motion.error();
    why.file = rows_left_[why.way ? why.way->refusal.place.move : 0].file;
    return std::unexpected(why);
  }
  rows_left_ = rows_left_.subspan(motion->rows);
  current_->q = motion->q_end;
  current_->arrival = current_->duration + motion->arrival;
  current_->duration += motion->duration;
  if (motion->pieces.empty()) return motion_done(now);
  return send(*motion, planner().motion(), planner().robot(), first.line);
}

/// Decides which orders follow. What it asks for has to be known.
std::expected<void, Refusal> Run::issue_branch(const BranchOrder& branch, Instant now) {
  const bool looks = branch.condition.subject == Condition::Subject::kSeen;
  if (looks) {
    const auto looked = sees();
    if (!looked) return std::unexpected(looked.error());
    if (!*looked) return {};
  }
  const auto answer = looks ? is_seen(branch.condition, now) : holds(branch.condition);
  if (!answer) return std::unexpected(refused(answer.error()));
  current_->holds = *answer;
  if (!*answer) next_ = branch.otherwise;
  finish_order(now);
  return {};
}

/// A wait under way that may be over.
void Run::look_at_wait(Instant now) {
  const auto& wait = std::get<WaitOrder>(current_->order->what);
  using For = WaitStep::For;
  if (paused_) {
    // Nobody has to hurry meanwhile.
    if (wait.what != For::kTime) wait_end_ = now + wait.duration;
    return;
  }
  bool over = wait.what == For::kSettled && settled(now);
  if (wait.what == For::kCondition) {
    const auto answer = holds(wait.until);
    if (!answer) return fail(answer.error(), now);
    over = *answer;
  }
  if (!over && now < *wait_end_) return;
  const bool in_time = over || wait.what == For::kTime;
  wait_end_.reset();
  if (in_time) return finish_order(now);
  fail(Error{ErrorCode::kNotInTime, -1, current_->duration, current_->duration}, now);
}

bool Run::watches() const {
  if (!next_deadline() || !current_) return false;
  const auto* wait = std::get_if<WaitOrder>(&current_->order->what);
  return wait != nullptr && wait->what != WaitStep::For::kTime;
}

std::expected<bool, Error> Run::holds(const Condition& condition) {
  using Subject = Condition::Subject;
  if (!condition.of_position()) {
    const DriverHealth health = health_ ? health_() : DriverHealth{};
    const bool supply = condition.subject == Subject::kSupply;
    const auto measured = supply ? health.supply_volts : health.jaws_width;
    if (!measured) return std::unexpected(Error{ErrorCode::kNotMeasured});
    return condition.holds(*measured);
  }
  const auto positions = machine_.positions();
  JointVector q;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const bool asked = condition.subject != Subject::kJoint || condition.joint == i;
    if (asked && positions[i].quality < PositionQuality::kCommanded) {
      return std::unexpected(Error{ErrorCode::kPositionUnknown, static_cast<std::int8_t>(i)});
    }
    q.push_back(positions[i].q);
  }
  if (condition.subject == Subject::kJoint) return condition.holds(q[condition.joint]);
  const planning::ToolSpace space(robot_, machine_.tool().jaws);
  const auto X_BT = space.forward({q.data(), q.size()}, space.home());
  if (!X_BT) return std::unexpected(X_BT.error());
  const Vec3& p = X_BT->p;
  return condition.holds(condition.subject == Subject::kToolX   ? p.x
                         : condition.subject == Subject::kToolY ? p.y
                                                                : p.z);
}

/// No joint has moved for a while by more than what its sensor leaves open.
bool Run::settled(Instant now) {
  const auto positions = machine_.positions();
  bool still = still_.has_value();
  for (std::size_t i = 0; still && i < positions.size(); ++i) {
    if (is_left_out(robot_, i)) continue;
    const bool turns = robot_.joints[i].kind == JointKind::kRevolute;
    const double open = (positions[i].upper - positions[i].lower) / 2;
    still = positions[i].quality >= PositionQuality::kCommanded &&
            std::abs(positions[i].q - (*still_)[i]) <= open + (turns ? kStillTurn : kStillLength);
  }
  if (still) return now - still_since_ >= kStillFor;
  still_since_ = now;
  still_.emplace();
  for (const JointPosition& position : positions) still_->push_back(position.q);
  return false;
}

/// One slow piece from nobody knows where.
void Run::send_first_move(const JointVector& q, double duration) {
  JointMove move{.q = q, .qd = {}, .duration = from_seconds(duration)};
  move.qd.resize(q.size());
  motion_ = std::make_unique<control::PieceMotion>(q_.value_or(JointVector{}),
                                                   std::vector<JointMove>(1, move), robot_);
  blind_ = true;
  ask(control::Begin{.motion = motion_.get(), .recovers = true});
}

std::expected<void, Refusal> Run::send(const RowMotion& motion,
                                       const planning::PlannedMotion& planned,
                                       const RobotModel& limits, int line,
                                       const std::vector<LinkPair>& overlaps) {
  if (changeable_) {
    auto made = holdable_motion(limits, *q_, motion, planned, feed_, overlaps);
    if (!made) {
      return std::unexpected(Refusal{line, made.error(), std::nullopt, current_->order->file});
    }
    if (limits.device.capability.motion == MotionKind::kStream) {
      const double longer = (*made)->time_left() - planned.law.duration();
      current_->duration += longer;
      current_->arrival += longer;
    }
    motion_ = std::move(*made);
  } else {
    motion_ = std::make_unique<control::PieceMotion>(*q_, motion.pieces, robot_, overlaps);
  }
  ask(control::Begin{.motion = motion_.get()});
  return {};
}

/// What was under way is done: what is left of its order follows, or the next one.
std::expected<void, Refusal> Run::order_done(Instant now) {
  if (back_steps_) {
    back_steps_ = false;
    q_ = current_->q;
    current_.reset();
    paused_ = true;
    return {};
  }
  if (handles() && !task_moves_) {
    task_waits_ = true;
    return {};
  }
  if (handles() || std::holds_alternative<MoveOrder>(current_->order->what)) {
    return motion_done(now);
  }
  if (std::holds_alternative<HomeOrder>(current_->order->what)) return go_home(now);
  finish_order(now);
  return {};
}

/// The search is over, or a leg of the way home behind it.
std::expected<void, Refusal> Run::go_home(Instant now) {
  if (back_) {
    q_ = std::exchange(blind_, false) ? machine_.reference() : current_->q;
    return next_leg(now);
  }
  q_ = machine_.reference();
  back_.emplace();
  leg_ = 0;
  if (!plannable(q_, robot_)) {
    const auto positions = machine_.positions();
    bool lost = false;
    for (std::size_t j = 0; j < positions.size(); ++j) {
      lost |= positions[j].quality == PositionQuality::kLost && !is_left_out(robot_, j);
    }
    if (lost || q_) return next_leg(now);
    // The board knows where the search ended, and does not report it.
    current_->q = home_joints(robot_);
    send_first_move(current_->q, first_move_duration(robot_));
    return {};
  }
  auto back = home_return(robot_, *q_, current_->order->line);
  if (!back) {
    Refusal why = back.error();
    why.file = current_->order->file;
    return std::unexpected(why);
  }
  back_ = std::move(*back);
  if (back_->q_end != home_joints(robot_)) take_notice({ErrorCode::kNoWayHome}, now);
  return next_leg(now);
}

std::expected<void, Refusal> Run::next_leg(Instant now) {
  while (leg_ < back_->legs.size()) {
    const HomeLeg& leg = back_->legs[leg_++];
    current_->q = leg.motion.q_end;
    if (!leg.motion.pieces.empty()) {
      return send(leg.motion, leg.planned, robot_, current_->order->line, leg.overlaps);
    }
    q_ = leg.motion.q_end;
  }
  finish_order(now);
  return {};
}

std::expected<void, Refusal> Run::motion_done(Instant now) {
  q_ = blind_ ? machine_.reference() : current_->q;
  blind_ = false;
  if (!rows_left_.empty()) return issue_move(now);
  if (handles()) {
    task_waits_ = true;
    return {};
  }
  finish_order(now);
  return {};
}

void Run::finish_order(Instant now) {
  SINEW_ASSERT(current_);
  current_->done = now;
  for (const JointPosition& position : machine_.positions()) {
    current_->reported.push_back(position);
  }
  records_.push_back(*current_);
  current_.reset();
  paused_ = paused_ || (single_step_ && next_ < plan_.orders.size());
}

Refusal Run::refused(const Error& error) const {
  if (!current_) return {0, error, std::nullopt, 0};
  return {current_->order->line, error, std::nullopt, current_->order->file};
}

void Run::fail(const Error& error, Instant now) {
  fail(refused(error), now);
}

void Run::fail(const Refusal& refusal, Instant /*now*/) {
  if (phase_ == Phase::kRunning && command_ != 0) machine_.give(control::Stop{});
  failure_ = refusal;
  current_.reset();
  phase_ = Phase::kFailed;
}

double Run::progress(Instant now) const {
  double total = 0;
  double done = 0;
  for (std::size_t place = 0; place < plan_.orders.size(); ++place) {
    const double seconds = weight(plan_.orders[place]);
    total += seconds;
    // Done, or in a branch that was not taken.
    const bool under_way = current_ && current_->order == &plan_.orders[place];
    if (place < next_ && !under_way) done += seconds;
  }
  if (current_ && !back_steps_) {
    const Duration went = now - current_->asked - (held_ - held_at_asked_);
    done += std::clamp(to_seconds(went), 0.0, weight(*current_->order));
  }
  return total > 0 ? done / total : 0;
}

double Run::elapsed(Instant now) const {
  return begun_at_ ? to_seconds(now - *begun_at_ - held_) : 0;
}

}  // namespace sinew::program
