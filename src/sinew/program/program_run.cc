#include "sinew/program/program_run.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::program {
namespace {

/// While a motion is streamed the driver is asked this often whether it takes the next segment.
constexpr Duration kFeedInterval = std::chrono::milliseconds(2);

}  // namespace

Run::Run(const Program& program, const RobotModel& robot, Driver& driver, Duration opening_limit)
    : program_(program),
      robot_(robot),
      driver_(driver),
      opening_limit_(opening_limit),
      trouble_(silence()) {}

Error Run::silence() const {
  return {.code = ErrorCode::kDeviceSilent, .limit = to_seconds(opening_limit_)};
}

void Run::start(Instant now) {
  opened_at_ = now;
  driver_.open(now);
}

void Run::stop(Instant now) {
  if (finished() || phase_ == Phase::kStopping) return;
  wait_end_.reset();
  pieces_.clear();
  if (phase_ == Phase::kOpening || outstanding_ == 0) {
    phase_ = Phase::kStopped;
    return;
  }
  phase_ = Phase::kStopping;
  driver_.stop(now);
}

void Run::poll(Instant now) {
  while (const auto event = driver_.take_event()) {
    if (event->kind == DriverEvent::Kind::kNotice) take_notice(event->error, now);
    if (!finished()) take(*event, now);
  }
  if (phase_ == Phase::kOpening && now - opened_at_ > opening_limit_) fail(trouble_, now);
  if (phase_ != Phase::kRunning) return;
  if (wait_end_ && now >= *wait_end_) {
    wait_end_.reset();
    finish_order(now);
  }
  const bool idle = outstanding_ == 0 && pieces_sent_ < pieces_.size();
  if (idle && in_doubt(now)) return;
  if (const auto fed = feed(now); !fed) return fail(fed.error(), now);
  while (phase_ == Phase::kRunning && !current_) {
    if (next_ < plan_.orders.size() && in_doubt(now)) return;
    issue_next(now);
  }
}

void Run::take_notice(const Error& error, Instant now) {
  ++notices_told_;
  if (driver_.state() == DriverState::kOpening) trouble_ = error;
  if (notices_.size() == kNoticesMax) return;
  notices_.push_back({now, current_ ? current_->order->line : 0, error});
}

/// Nothing is under way, and the driver cannot take anything yet: it looks for its device again.
bool Run::in_doubt(Instant now) {
  const DriverState state = driver_.state();
  const bool unready = state == DriverState::kReady && !driver_.wants_move(now);
  if (state != DriverState::kOpening && !unready) {
    doubt_since_.reset();
    return false;
  }
  if (!doubt_since_) doubt_since_ = now;
  if (now - *doubt_since_ <= opening_limit_) return true;
  if (unready && !current_) return false;  // it says why it takes nothing
  const Order& due = current_ ? *current_->order : plan_.orders[next_];
  fail({due.line, trouble_, std::nullopt}, now);
  return true;
}

void Run::take(const DriverEvent& event, Instant now) {
  using Kind = DriverEvent::Kind;
  if (phase_ == Phase::kOpening) {
    if (event.kind == Kind::kReady) begin();
    if (event.kind == Kind::kFailed) {
      const bool final =
          event.error.code == ErrorCode::kPortClosed || driver_.state() == DriverState::kFault;
      if (final) return fail(event.error, now);
      // A device may be deaf or talk nonsense for a while; the driver asks again.
      if (event.error.code != ErrorCode::kDeviceSilent) trouble_ = event.error;
    }
    return;
  }
  switch (event.kind) {
    case Kind::kDone:
      outstanding_ = std::max(0, outstanding_ - 1);
      if (phase_ == Phase::kRunning && current_ && outstanding_ == 0 &&
          pieces_sent_ == pieces_.size()) {
        if (const auto gone_on = order_done(now); !gone_on) fail(gone_on.error(), now);
      }
      break;
    case Kind::kStopped:
      outstanding_ = 0;
      if (phase_ == Phase::kStopping) phase_ = Phase::kStopped;
      break;
    case Kind::kFailed:
      return fail(event.error, now);
    case Kind::kReady:
    case Kind::kNotice:
      break;
  }
}

Start Run::known_positions() const {
  JointVector q;
  for (const JointPosition& position : driver_.positions()) {
    if (position.quality < PositionQuality::kCommanded) return std::nullopt;
    q.push_back(position.q);
  }
  return q;
}

/// The machine's own word on where it is: the plan is made for that.
void Run::begin() {
  trouble_ = silence();
  q_ = known_positions();
  if (!q_ && declared_) {
    FixedVector<JointPosition, kMaxJoints> positions;
    for (const double q : *declared_) {
      positions.push_back({PositionQuality::kCommanded, q, q, q});
    }
    driver_.declare_positions({positions.data(), positions.size()});
    q_ = known_positions();
  }
  auto plan = make_plan(program_, robot_, q_, homing_);
  if (!plan) {
    failure_ = plan.error();
    phase_ = Phase::kFailed;
    return;
  }
  plan_ = std::move(*plan);
  records_.reserve(plan_.orders.size());
  phase_ = Phase::kRunning;
}

void Run::issue_next(Instant now) {
  if (next_ == plan_.orders.size()) {
    phase_ = Phase::kDone;
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
                    .reported = {}};
  if (!begun_at_) begun_at_ = now;
  pieces_.clear();
  pieces_sent_ = 0;
  back_.reset();
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
    return {};
  }
  const auto* tool = std::get_if<ToolOrder>(&order.what);
  if (tool != nullptr) current_->duration = tool->duration;
  if (const auto* home = std::get_if<HomeOrder>(&order.what)) {
    current_->duration = home->duration_max;
  }
  const auto accepted = tool != nullptr ? driver_.tool(tool->action, now) : driver_.home(now);
  if (!accepted) return std::unexpected(Refusal{order.line, accepted.error(), std::nullopt});
  ++outstanding_;
  return {};
}

std::expected<void, Refusal> Run::issue_move(Instant now) {
  SINEW_ASSERT(!rows_left_.empty());
  const Step& first = rows_left_.front();
  pieces_.clear();
  pieces_sent_ = 0;
  if (!plannable(q_, robot_)) {
    const auto q = first_target(first, q_, robot_);
    if (!q) return std::unexpected(q.error());
    JointMove move{.q = *q, .qd = {}, .duration = from_seconds(first_move_duration(robot_))};
    move.qd.resize(q->size());
    pieces_.assign(1, move);
    rows_left_ = rows_left_.subspan(1);
    current_->q = *q;
    current_->arrival = current_->duration + first_move_duration(robot_);
    current_->duration += first_move_duration(robot_);
  } else {
    // The arm may stand elsewhere than the plan had it: after homing, or after a first move. Then
    // its corners may not blend as they did, and what was one motion takes several.
    if (!planner_) planner_ = std::make_unique<RowPlanner>(robot_);
    auto motion = planner_->plan(*q_, rows_left_);
    if (!motion) return std::unexpected(motion.error());
    pieces_ = std::move(motion->pieces);
    rows_left_ = rows_left_.subspan(motion->rows);
    current_->q = motion->q_end;
    current_->arrival = current_->duration + motion->arrival;
    current_->duration += motion->duration;
  }
  if (pieces_.empty()) return motion_done(now);
  return send_first(now, first.line);
}

/// As much of a motion as the driver takes at once.
std::expected<void, Refusal> Run::send_first(Instant now, int line) {
  const bool streamed = robot_.device.capability.motion == MotionKind::kStream;
  // Whoever cannot take a whole move now says why.
  const bool fed = streamed && plannable(q_, robot_) && !doubt_since_;
  const auto accepted = fed ? feed(now) : send_piece(now);
  if (!accepted) return std::unexpected(Refusal{line, accepted.error(), std::nullopt});
  return {};
}

/// What was under way is done: what is left of its order follows, or the next one.
std::expected<void, Refusal> Run::order_done(Instant now) {
  if (std::holds_alternative<MoveOrder>(current_->order->what)) return motion_done(now);
  if (std::holds_alternative<HomeOrder>(current_->order->what)) return go_home(now);
  finish_order(now);
  return {};
}

/// The search is over, or a leg of the way home behind it.
std::expected<void, Refusal> Run::go_home(Instant now) {
  if (back_) {
    q_ = current_->q;
    return next_leg(now);
  }
  q_ = known_positions();
  back_.emplace();
  leg_ = 0;
  // Who does not know where homing has ended goes on from there with a slow first move.
  if (plannable(q_, robot_)) {
    auto back = home_return(robot_, *q_, current_->order->line);
    if (!back) return std::unexpected(back.error());
    back_ = std::move(*back);
  }
  return next_leg(now);
}

std::expected<void, Refusal> Run::next_leg(Instant now) {
  pieces_.clear();
  pieces_sent_ = 0;
  while (leg_ < back_->legs.size()) {
    const RowMotion& leg = back_->legs[leg_++].motion;
    current_->q = leg.q_end;
    if (leg.pieces.empty()) {
      q_ = leg.q_end;
      continue;
    }
    pieces_ = leg.pieces;
    return send_first(now, current_->order->line);
  }
  finish_order(now);
  return {};
}

std::expected<void, Refusal> Run::motion_done(Instant now) {
  q_ = current_->q;
  pieces_.clear();
  pieces_sent_ = 0;
  if (!rows_left_.empty()) return issue_move(now);
  finish_order(now);
  return {};
}

Expected<void> Run::send_piece(Instant now) {
  JointMove piece = pieces_[pieces_sent_];
  // Behind another one that is under way it begins where that one ends.
  if (outstanding_ == 0) {
    const bool first = pieces_sent_ == 0;
    piece.q_start = first ? q_.value_or(JointVector{}) : pieces_[pieces_sent_ - 1].q;
  }
  if (auto accepted = driver_.move(piece, now); !accepted) return accepted;
  ++outstanding_;
  ++pieces_sent_;
  return {};
}

/// The next pieces, as many as the driver takes.
Expected<void> Run::feed(Instant now) {
  while (pieces_sent_ < pieces_.size() && driver_.wants_move(now)) {
    if (auto accepted = send_piece(now); !accepted) return accepted;
  }
  return {};
}

void Run::finish_order(Instant now) {
  SINEW_ASSERT(current_);
  current_->done = now;
  for (const JointPosition& position : driver_.positions()) {
    current_->reported.push_back(position);
  }
  records_.push_back(*current_);
  current_.reset();
}

void Run::fail(const Error& error, Instant now) {
  fail({current_ ? current_->order->line : 0, error, std::nullopt}, now);
}

void Run::fail(const Refusal& refusal, Instant now) {
  // Segments that were handed over already must not be the last word.
  if (phase_ == Phase::kRunning && outstanding_ > 0) driver_.stop(now);
  failure_ = refusal;
  current_.reset();
  pieces_.clear();
  phase_ = Phase::kFailed;
}

std::optional<Instant> Run::next_deadline(Instant now) const {
  if (pieces_sent_ < pieces_.size()) return now + kFeedInterval;
  return wait_end_;
}

double Run::progress(Instant now) const {
  double total = 0;
  double done = 0;
  const auto weight = [](const Order& order) {
    if (const auto* move = std::get_if<MoveOrder>(&order.what)) return move->duration;
    if (const auto* wait = std::get_if<WaitOrder>(&order.what)) return to_seconds(wait->duration);
    if (const auto* tool = std::get_if<ToolOrder>(&order.what)) return tool->duration;
    if (const auto* home = std::get_if<HomeOrder>(&order.what)) return home->duration_max;
    return 0.0;
  };
  for (const Order& order : plan_.orders) total += weight(order);
  for (const Record& record : records_) done += weight(*record.order);
  if (current_) {
    done += std::clamp(to_seconds(now - current_->asked), 0.0, weight(*current_->order));
  }
  return total > 0 ? done / total : 0;
}

}  // namespace sinew::program
