#include "sinew/devices/ideal/ideal_driver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/driver/send_range.h"

namespace sinew {

using namespace ideal;
using Kind = DriverEvent::Kind;

namespace {

/// A measured position is worth so much, rad or m.
constexpr double kResolution = 1e-6;
/// So far a target may be from where a motion was planned to begin.
constexpr double kElsewhere = 1e-5;
constexpr double kBitsPerByte = 10;

/// Numbers count on around 65536: whether `one` comes behind `other`.
bool is_behind(std::uint16_t one, std::uint16_t other) {
  const auto ahead = static_cast<std::uint16_t>(one - other);
  return ahead != 0 && ahead < 0x8000;
}

}  // namespace

IdealDriver::IdealDriver(std::span<const Joint> joints, const std::optional<JawGripper>& gripper,
                         std::uint32_t baud, const IdealTiming& timing)
    : joints_(joints), baud_(baud), timing_(timing) {
  SINEW_ASSERT(!joints.empty() && joints.size() <= kJointsMax && baud > 0);
  if (gripper) width_max_ = gripper->width_max;
  for (const Joint& joint : joints) {
    brake_max_ = std::max(brake_max_, from_seconds(joint.velocity_max / joint.acceleration_max));
  }
  positions_.resize(joints.size());
  timing_.moving_poll = std::max(timing_.moving_poll, 2 * on_the_wire());
  timing_.reply_timeout += 2 * on_the_wire();
  timing_.move_timeout += 2 * on_the_wire();
}

/// The longest line.
Duration IdealDriver::on_the_wire() const {
  return from_seconds(static_cast<double>(kLineMax) * kBitsPerByte / baud_);
}

// Opening and closing

void IdealDriver::open(Instant now) {
  if (activity_ != Activity::kClosed) close(now);
  now_ = now;
  fault_.reset();
  told_silent_ = false;
  goes_on_until_.reset();
  decoder_.reset();
  begin_anew({}, now);
}

/// Asks who it is; what was known of it is worth nothing.
void IdealDriver::begin_anew(const Error& why, Instant now) {
  end_commands(Kind::kFailed, why);
  activity_ = Activity::kOpening;
  known_ = foreign_ = stop_due_ = clear_due_ = clearing_ = false;
  jaws_due_.reset();
  state_.reset();
  asked_.reset();
  output_.clear();
  answered_ = line_;
  poll_due_ = now;
  for (JointPosition& joint : positions_) joint = {};
}

void IdealDriver::close(Instant now) {
  now_ = std::max(now_, now);
  if (activity_ == Activity::kClosed) return;
  begin_anew({ErrorCode::kPortClosed}, now_);
  commands_.end_stop();
  activity_ = Activity::kClosed;
}

DriverState IdealDriver::state() const {
  switch (activity_) {
    case Activity::kClosed:
      return DriverState::kClosed;
    case Activity::kOpening:
      return DriverState::kOpening;
    case Activity::kMoving:
    case Activity::kJaws:
      return DriverState::kMoving;
    case Activity::kStopping:
      return DriverState::kStopping;
    case Activity::kIdle:
      break;
  }
  return fault_ ? DriverState::kFault : DriverState::kReady;
}

std::optional<Instant> IdealDriver::goes_on_until() const {
  return goes_on_until_ && now_ < *goes_on_until_ ? goes_on_until_ : std::nullopt;
}

// What is asked for

Expected<void> IdealDriver::may_begin() const {
  if (activity_ == Activity::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (fault_) return std::unexpected(*fault_);
  if (activity_ != Activity::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  return {};
}

bool IdealDriver::wants_move(Instant /*now*/) const {
  if (fault_) return false;
  if (activity_ == Activity::kIdle) return true;
  return activity_ == Activity::kMoving && !pending_.full() && !pending_.back().rest;
}

/// As the device will take it, and nothing of it beyond the joints' ranges and speeds.
Expected<IdealDriver::Pending> IdealDriver::pending_of(const JointMove& move) const {
  const std::size_t joints = joints_.size();
  if (move.q.size() != joints || move.qd.size() != joints) {
    return std::unexpected(Error{ErrorCode::kUnsendable, -1, static_cast<double>(move.q.size())});
  }
  constexpr auto kLongest = std::chrono::hours(1);
  if (move.duration < std::chrono::milliseconds(1) || move.duration > kLongest) {
    const double limit = move.duration > kLongest ? 3600 : 1e-3;
    return std::unexpected(Error{ErrorCode::kSegmentTime, -1, to_seconds(move.duration), limit});
  }
  Pending one;
  one.rest = true;
  one.move.duration_us = static_cast<std::uint32_t>(
      std::chrono::round<std::chrono::microseconds>(move.duration).count());
  for (std::size_t i = 0; i < joints; ++i) {
    const auto refuse = [&](Error error) {
      error.index = static_cast<std::int8_t>(i);
      return std::unexpected(error);
    };
    if (!std::isfinite(move.qd[i])) return refuse({ErrorCode::kUnsendable, -1, move.qd[i]});
    const Joint& joint = joints_[i];
    const Cubic::State from =
        pending_.empty() ? Cubic::State{positions_[i].q, 0} : pending_.back().end[i];
    const Cubic::State to{move.q[i], move.qd[i]};
    const SendRange range = SendRange(joint).from(from.q);
    if (!range.holds(to.q)) {
      const double limit = to.q < joint.lower ? joint.lower : joint.upper;
      return refuse({ErrorCode::kJointLimit, -1, to.q, limit});
    }
    const segments::CubicPiece piece(from, to, to_seconds(move.duration), range);
    if (const auto fine = piece.check(joint); !fine) return refuse(fine.error());
    one.end.push_back(to);
    one.move.q.push_back(micro(to.q));
    one.move.qd.push_back(micro(to.qd));
    one.rest = one.rest && one.move.qd.back() == 0;
  }
  return one;
}

Expected<void> IdealDriver::move(const JointMove& move, Instant now) {
  poll(now);
  const bool follows = activity_ == Activity::kMoving && wants_move(now);
  if (!follows) {
    if (const auto may = may_begin(); !may) return may;
    for (std::size_t i = 0; i < move.q_start.size(); ++i) {
      const double here = positions_[i].q;
      if (std::abs(here - move.q_start[i]) <= kElsewhere) continue;
      return std::unexpected(
          Error{ErrorCode::kMovedUnasked, static_cast<std::int8_t>(i), here, move.q_start[i]});
    }
  }
  auto one = pending_of(move);
  if (!one) return std::unexpected(one.error());
  one->move.number = ++number_;
  pending_.push_back(*one);
  commands_.accept();
  if (!follows) poll_due_ = now;
  last_move_ = now;
  activity_ = Activity::kMoving;
  say_what_is_due(now);
  return {};
}

Expected<void> IdealDriver::tool(const ToolAction& action, Instant now) {
  poll(now);
  const auto* to = std::get_if<JawsTo>(&action);
  if (to == nullptr || !width_max_) return std::unexpected(Error{ErrorCode::kToolNotFitted});
  if (!(to->width >= 0 && to->width <= *width_max_ + kMicro)) {
    return std::unexpected(Error{ErrorCode::kJawWidth, -1, to->width, *width_max_});
  }
  if (const auto may = may_begin(); !may) return may;
  jaws_due_ = jaws_to_ = micro(std::min(to->width, *width_max_));
  health_.jaws_width.reset();
  commands_.accept();
  activity_ = Activity::kJaws;
  jaws_since_ = poll_due_ = now;
  say_what_is_due(now);
  return {};
}

void IdealDriver::stop(Instant now) {
  poll(now);
  if (activity_ == Activity::kClosed) return;
  commands_.ask_stop();
  // Who opens is about to stop it in any case.
  if (activity_ == Activity::kOpening || activity_ == Activity::kStopping) return;
  begin_stop(now);
  say_what_is_due(now);
}

/// From now on only what answers to the stop, or to what is said behind it, says where it stands.
void IdealDriver::begin_stop(Instant now) {
  pending_.clear();
  jaws_due_.reset();
  asked_.reset();
  stop_due_ = true;
  activity_ = Activity::kStopping;
  poll_due_ = now;
}

Expected<void> IdealDriver::clear_fault(Instant now) {
  poll(now);
  if (activity_ == Activity::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (activity_ != Activity::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  if (!fault_) return {};
  begin_anew({}, now);
  fault_.reset();
  clearing_ = true;
  commands_.accept();
  return {};
}

void IdealDriver::end_commands(Kind kind, const Error& error) {
  commands_.end_all(kind, error);
  pending_.clear();
}

void IdealDriver::come_to_rest(Kind kind, const Error& error) {
  end_commands(kind, error);
  activity_ = Activity::kIdle;
}

void IdealDriver::fail(const Error& error) {
  fault_ = error;
  commands_.fail(error);
  come_to_rest(Kind::kFailed, error);
}

// Time and lines

void IdealDriver::poll(Instant now) {
  now_ = std::max(now_, now);
  if (activity_ == Activity::kClosed) return;
  if (answered_ != line_) {
    const auto oldest = static_cast<std::uint16_t>(answered_ + 1);
    const Instant waits_since = std::max(heard_at_, lines_[oldest % kLinesKept].at);
    if (now_ - waits_since >= timing_.tries * timing_.reply_timeout) fall_silent(now_);
  }
  say_what_is_due(now_);
  update_positions(now_);
}

std::optional<Instant> IdealDriver::next_deadline() const {
  if (activity_ == Activity::kClosed || foreign_) return std::nullopt;
  Instant due = asked_ ? asked_->due : poll_due_;
  if (activity_ == Activity::kMoving) due = std::min(due, poll_due_);
  for (const Pending& one : pending_) {
    if (one.said_at && !one.taken) due = std::min(due, *one.said_at + timing_.move_timeout);
  }
  return std::max(due, now_ + std::chrono::microseconds(100));
}

/// False where the port takes no bytes, or so many lines are without an answer that it is silent.
bool IdealDriver::say(const Request& request, Instant now) {
  const auto out = static_cast<std::uint16_t>(line_ - answered_);
  const auto line = encode(Numbered<Request>{static_cast<std::uint16_t>(line_ + 1), request});
  if (out + 1 >= kLinesKept || output_.size() + line.size() > output_.capacity()) return false;
  ++line_;
  lines_[line_ % kLinesKept] = {now, request};
  for (const std::uint8_t byte : line) output_.push_back(byte);
  ++health_.requests;
  return true;
}

/// Says it, and says it again where no answer comes.
void IdealDriver::ask(const Request& request, Instant now) {
  const bool again = asked_ && asked_->request.index() == request.index();
  if (!say(request, now)) return;
  if (again) {
    ++health_.retries;
    ++health_.timeouts;
  } else {
    asked_ = Asked{request, line_, {}};
  }
  asked_->due = now + timing_.reply_timeout;
}

/// The first that is due of a stop, what ends a hold, the jaws, a look; moves beside them.
void IdealDriver::say_what_is_due(Instant now) {
  if (activity_ == Activity::kClosed || foreign_) return;
  if (asked_) {
    if (now >= asked_->due) ask(Request(asked_->request), now);
  } else if (!known_) {
    if (now >= poll_due_) ask(Hello{}, now);
  } else if (stop_due_) {
    ask(Stop{}, now);
  } else if (clear_due_) {
    ask(Clear{}, now);
  } else if (jaws_due_) {
    ask(Jaws{*jaws_due_}, now);
  } else if (now >= poll_due_ && activity_ != Activity::kMoving) {
    ask(Ask{}, now);
  }
  if (activity_ != Activity::kMoving) return;
  say_moves(now);
  // How far it is has to be known in time however long a line takes there and back.
  if (now >= poll_due_ && say(Ask{}, now)) poll_due_ = now + timing_.moving_poll;
}

/// In their order. One that was not taken in time is said again with all behind it, which the
/// device has refused since.
void IdealDriver::say_moves(Instant now) {
  bool again = false;
  for (Pending& one : pending_) {
    if (one.taken) continue;
    again = again || (one.said_at && now - *one.said_at >= timing_.move_timeout);
    if (one.said_at && !again) continue;
    if (!say(one.move, now)) return;
    if (one.said_at) ++health_.retries;
    one.said_at = now;
  }
}

void IdealDriver::fall_silent(Instant now) {
  const double waited = to_seconds(timing_.tries * timing_.reply_timeout);
  const Error error{ErrorCode::kDeviceSilent, -1, waited, waited};
  if (commands_.open() == 0 && !told_silent_) {
    commands_.tell(activity_ == Activity::kOpening ? Kind::kFailed : Kind::kNotice, error);
  }
  told_silent_ = true;
  // Its deadline is over if it hears nothing either; else it goes to the end of what it has.
  const bool may_move = activity_ != Activity::kOpening && activity_ != Activity::kIdle;
  if (may_move) goes_on_until_ = now + kDeadline + brake_max_;
  begin_anew(error, now);
  commands_.end_stop();
  poll_due_ = now + timing_.silent_retry;
}

/// Its power was away: it counts its moves from 0 again.
void IdealDriver::note_restart(Instant now) {
  const Error error{ErrorCode::kSupplyFlag, 0};
  if (commands_.open() == 0) commands_.tell(Kind::kNotice, error);
  begin_anew(error, now);
}

void IdealDriver::receive(std::span<const std::uint8_t> bytes, Instant now) {
  now_ = std::max(now_, now);
  for (const std::uint8_t byte : bytes) {
    const LineDecoder::Result result = decoder_.push(byte);
    if (result == LineDecoder::Result::kMore || activity_ == Activity::kClosed) continue;
    const auto reply =
        result == LineDecoder::Result::kLine ? decode_reply(decoder_.words()) : std::nullopt;
    // Only to a line that is out; what answers to an older one than has been answered is late.
    const bool answers =
        reply && is_behind(reply->number, answered_) && !is_behind(reply->number, line_);
    if (answers) {
      take(*reply, now_);
    } else {
      ++health_.unexpected;
    }
  }
  poll(now);
}

void IdealDriver::take(const Numbered<Reply>& reply, Instant now) {
  answered_ = reply.number;
  heard_at_ = now;
  const Line line = lines_[reply.number % kLinesKept];
  if (asked_) {
    // An answer behind the request's own first line, of its own kind, is its answer.
    const bool own =
        !is_behind(asked_->first, reply.number) && line.request.index() == asked_->request.index();
    if (own || std::holds_alternative<Ask>(asked_->request)) asked_.reset();
    if (own && std::holds_alternative<Stop>(line.request)) stop_due_ = false;
    if (own && std::holds_alternative<Clear>(line.request)) clear_due_ = false;
    if (own && std::holds_alternative<Jaws>(line.request)) jaws_due_.reset();
  }
  if (const auto* identity = std::get_if<Identity>(&reply.what)) {
    if (std::holds_alternative<Hello>(line.request)) return take_identity(*identity, now);
  } else if (const auto* refusal = std::get_if<Refusal>(&reply.what)) {
    return take_refusal(*refusal, line.request, now);
  } else if (const auto* state = std::get_if<State>(&reply.what)) {
    if (known_ && state->q.size() == joints_.size()) {
      state_asked_ = line.at;
      return take_state(*state, now);
    }
  }
  ++health_.unexpected;
}

void IdealDriver::take_identity(const Identity& identity, Instant now) {
  if (identity.version != kVersion || identity.joints != joints_.size()) {
    const bool version = identity.version != kVersion;
    foreign_ = true;
    return fail(version ? Error{ErrorCode::kVersionMismatch, -1, identity.version * 1.0, kVersion}
                        : Error{ErrorCode::kModelMismatch});
  }
  number_ = identity.taken;
  known_ = true;
  stop_due_ = true;  // whatever a host before has left it doing
  poll_due_ = now;
}

void IdealDriver::take_refusal(const Refusal& refusal, const Request& of, Instant now) {
  poll_due_ = now;  // it is asked why
  if (std::holds_alternative<Jaws>(of) && activity_ == Activity::kJaws) {
    return come_to_rest(Kind::kFailed, {ErrorCode::kToolNotFitted});
  }
  const bool for_good = refusal.why == Why::kLimit || refusal.why == Why::kForm;
  if (!std::holds_alternative<Move>(of) || activity_ != Activity::kMoving || !for_good) return;
  const bool limit = refusal.why == Why::kLimit;
  fault_ = {ErrorCode::kDeviceRefused,
            limit ? static_cast<std::int8_t>(refusal.joint) : std::int8_t{-1}};
  end_commands(Kind::kFailed, *fault_);
  begin_stop(now);
}

void IdealDriver::take_state(const State& state, Instant now) {
  told_silent_ = false;
  const bool started = state.phase == Phase::kHeld && state.held == Held::kStarted;
  if (started && activity_ != Activity::kOpening) return note_restart(now);
  state_ = state;
  for (Pending& one : pending_) {
    one.taken = one.taken || !is_behind(one.move.number, state.taken);
  }
  const bool rests = activity_ == Activity::kIdle;
  if (activity_ != Activity::kMoving) {
    poll_due_ = now + (rests ? timing_.resting_poll : timing_.moving_poll);
  }
  if (state.jaws_um >= 0 && activity_ != Activity::kJaws) {
    health_.jaws_width = state.jaws_um * kMicro;
  }
  switch (activity_) {
    case Activity::kOpening:
      return step_opening();
    case Activity::kMoving:
      return step_moving(now);
    case Activity::kJaws:
      return step_jaws(now);
    case Activity::kStopping:
      return step_stopping();
    default:
      return;
  }
}

void IdealDriver::step_opening() {
  if (stop_due_ || clear_due_ || asked_ || state_->phase == Phase::kStopping) return;
  if (state_->phase == Phase::kHeld) {
    clear_due_ = true;
    return;
  }
  number_ = state_->taken;
  activity_ = Activity::kIdle;
  goes_on_until_.reset();
  if (clearing_) {
    clearing_ = false;
    end_commands(Kind::kDone);
  } else if (!fault_) {
    commands_.tell(Kind::kReady);
  }
  commands_.end_stop();
}

void IdealDriver::step_moving(Instant now) {
  while (!pending_.empty() && !is_behind(pending_[0].move.number, state_->done)) {
    pending_.drop_front(1);
    commands_.done();
  }
  if (pending_.empty()) {
    activity_ = Activity::kIdle;
    return;
  }
  if (state_->phase != Phase::kHeld) return;
  switch (state_->held) {
    case Held::kBlocked:
      return fail({ErrorCode::kStalled, static_cast<std::int8_t>(state_->joint)});
    case Held::kStarved:
      // Nothing is wrong with the device: the next motion may begin.
      end_commands(Kind::kFailed, {ErrorCode::kStreamEnded, -1, to_seconds(now - last_move_)});
      return begin_stop(now);
    default:
      return fail({ErrorCode::kLinkSilent, 0});
  }
}

void IdealDriver::step_jaws(Instant now) {
  if (jaws_due_) return;
  if (std::exchange(jaws_at_, state_->jaws_um) != state_->jaws_um) jaws_since_ = now;
  if (state_->jaws_um != jaws_to_ && now - jaws_since_ < timing_.jaws_stand) return;
  health_.jaws_width = state_->jaws_um * kMicro;
  come_to_rest(Kind::kDone);
}

void IdealDriver::step_stopping() {
  if (stop_due_ || clear_due_ || asked_) return;
  if (state_->phase == Phase::kMoving || state_->phase == Phase::kStopping) return;
  if (state_->phase == Phase::kHeld && !fault_) {
    clear_due_ = true;
    return;
  }
  number_ = state_->taken;
  activity_ = Activity::kIdle;
  commands_.end_stop();
}

void IdealDriver::update_positions(Instant now) {
  if (!state_ || activity_ == Activity::kOpening || activity_ == Activity::kClosed) return;
  const bool stands = activity_ == Activity::kIdle || activity_ == Activity::kJaws;
  const double age = to_seconds(now - state_asked_);
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const double q = state_->q[i] * kMicro;
    const double gone = kResolution + (stands ? 0 : age * joints_[i].velocity_max);
    positions_[i] = {PositionQuality::kMeasured, q, q - gone, q + gone};
  }
}

}  // namespace sinew
