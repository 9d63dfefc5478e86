#include "sinew/devices/ideal/ideal_driver.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/driver/send_range.h"

namespace sinew {

using namespace ideal;
using Kind = DriverEvent::Kind;

namespace {

constexpr double kMicro = 1e-6;
/// A measured position is worth so much, rad or m; and as far a target may be from where a motion
/// was planned to begin.
constexpr double kResolution = 1e-6;
constexpr double kBitsPerByte = 10;
/// More moves than these would only make a stop later.
constexpr std::size_t kMovesAhead = 3;

std::int32_t micro(double value) {
  return static_cast<std::int32_t>(std::lround(value / kMicro));
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
}

// Opening and closing

void IdealDriver::open(Instant now) {
  if (activity_ != Activity::kClosed) close(now);
  now_ = now;
  fault_.reset();
  told_silent_ = false;
  decoder_.reset();
  begin_anew({}, now);
}

/// Asks who it is; what was known of it is worth nothing.
void IdealDriver::begin_anew(const Error& why, Instant now) {
  end_commands(Kind::kFailed, why);
  activity_ = Activity::kOpening;
  since_ = now;
  known_ = stop_due_ = clear_due_ = clearing_ = false;
  jaws_due_.reset();
  state_.reset();
  said_.reset();
  output_.clear();
  poll_due_ = now;
  lose_positions();
}

void IdealDriver::close(Instant now) {
  now_ = std::max(now_, now);
  if (activity_ == Activity::kClosed) return;
  begin_anew({ErrorCode::kPortClosed}, now_);
  activity_ = Activity::kClosed;
}

void IdealDriver::lose_positions() {
  for (JointPosition& joint : positions_) joint = {};
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
  if (activity_ != Activity::kStopping) return std::nullopt;
  return since_ + std::chrono::milliseconds(100) + brake_max_;
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
  return activity_ == Activity::kMoving && pending_.size() < kMovesAhead && !pending_.back().rest;
}

/// As the device will take it, and no piece of it beyond the joints' ranges and speeds.
Expected<Move> IdealDriver::line_of(const JointMove& move) const {
  const std::size_t joints = joints_.size();
  if (move.q.size() != joints || move.qd.size() != joints) {
    return std::unexpected(Error{ErrorCode::kUnsendable, -1, static_cast<double>(move.q.size())});
  }
  constexpr auto kLongest = std::chrono::hours(1);
  if (move.duration < std::chrono::milliseconds(1) || move.duration > kLongest) {
    const double limit = move.duration > kLongest ? 3600 : 1e-3;
    return std::unexpected(Error{ErrorCode::kSegmentTime, -1, to_seconds(move.duration), limit});
  }
  Move line;
  line.duration_us = static_cast<std::uint32_t>(
      std::chrono::round<std::chrono::microseconds>(move.duration).count());
  for (std::size_t i = 0; i < joints; ++i) {
    const auto refuse = [&](Error error) {
      error.index = static_cast<std::int8_t>(i);
      return std::unexpected(error);
    };
    if (!std::isfinite(move.qd[i])) return refuse({ErrorCode::kUnsendable, -1, move.qd[i]});
    const Joint& joint = joints_[i];
    const bool follows = !pending_.empty();
    const axis_link::Setpoint from = follows
                                         ? axis_link::Setpoint{pending_.back().move.q[i] * kMicro,
                                                               pending_.back().move.qd[i] * kMicro}
                                         : axis_link::Setpoint{positions_[i].q, 0};
    const SendRange range = SendRange(joint).from(from.q);
    if (!range.holds(move.q[i])) {
      const double limit = move.q[i] < joint.lower ? joint.lower : joint.upper;
      return refuse({ErrorCode::kJointLimit, -1, move.q[i], limit});
    }
    const axis_link::CubicPiece piece(from, {move.q[i], move.qd[i]}, line.duration_us * kMicro,
                                      range);
    if (const auto fine = piece.check(joint); !fine) return refuse(fine.error());
    line.q.push_back(micro(move.q[i]));
    line.qd.push_back(micro(move.qd[i]));
  }
  return line;
}

Expected<void> IdealDriver::move(const JointMove& move, Instant now) {
  poll(now);
  const bool follows = activity_ == Activity::kMoving && wants_move(now);
  if (!follows) {
    if (const auto may = may_begin(); !may) return may;
    for (std::size_t i = 0; i < move.q_start.size(); ++i) {
      const double here = positions_[i].q;
      if (std::abs(here - move.q_start[i]) <= 10 * kResolution) continue;
      return std::unexpected(
          Error{ErrorCode::kMovedUnasked, static_cast<std::int8_t>(i), here, move.q_start[i]});
    }
  }
  auto line = line_of(move);
  if (!line) return std::unexpected(line.error());
  line->number = ++number_;
  Pending one;
  one.move = *line;
  one.duration = move.duration;
  one.rest = std::ranges::all_of(line->qd, [](std::int32_t speed) { return speed == 0; });
  pending_.push_back(one);
  ++commands_;
  if (!follows) since_ = now;
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
  ++commands_;
  activity_ = Activity::kJaws;
  since_ = now;
  say_what_is_due(now);
  return {};
}

void IdealDriver::stop(Instant now) {
  poll(now);
  if (activity_ == Activity::kClosed || activity_ == Activity::kStopping) return;
  if (activity_ == Activity::kOpening) {  // it is stopped there in any case
    commands_ = std::max<std::size_t>(commands_, 1);
    return end_commands(Kind::kStopped);
  }
  commands_ = std::max<std::size_t>(commands_, 1);
  // A line that waits for its answer is out already; the stop comes right behind it, and its own
  // answer is the only one that counts from now on.
  said_.reset();
  begin_stop(now);
  say_what_is_due(now);
}

void IdealDriver::begin_stop(Instant now) {
  pending_.clear();
  jaws_due_.reset();
  stop_due_ = true;
  activity_ = Activity::kStopping;
  since_ = now;
}

Expected<void> IdealDriver::clear_fault(Instant now) {
  poll(now);
  if (activity_ == Activity::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (activity_ != Activity::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  if (!fault_) return {};
  begin_anew({}, now);
  fault_.reset();
  clearing_ = true;
  ++commands_;
  return {};
}

void IdealDriver::tell(Kind kind, const Error& error) {
  if (!events_.full()) events_.push_back({kind, error});
}

void IdealDriver::end_commands(Kind kind, const Error& error) {
  for (; commands_ > 0; --commands_) tell(kind, error);
  pending_.clear();
}

void IdealDriver::come_to_rest(Kind kind, const Error& error) {
  end_commands(kind, error);
  activity_ = Activity::kIdle;
  since_ = now_;
}

void IdealDriver::fail(const Error& error) {
  fault_ = error;
  commands_ = std::max<std::size_t>(commands_, 1);
  come_to_rest(Kind::kFailed, error);
}

// Time and bytes

void IdealDriver::poll(Instant now) {
  now_ = std::max(now_, now);
  if (activity_ == Activity::kClosed) return;
  if (said_ && now_ >= answer_due_) say_again(now_);
  say_what_is_due(now_);
  update_positions(now_);
}

std::optional<Instant> IdealDriver::next_deadline() const {
  if (activity_ == Activity::kClosed) return std::nullopt;
  return std::max(said_ ? answer_due_ : poll_due_, now_ + std::chrono::microseconds(100));
}

void IdealDriver::say(const Request& request, Instant now) {
  said_ = request;
  said_at_ = now;
  ++line_;
  tries_left_ = timing_.tries - 1;
  ++health_.requests;
  send(now);
}

void IdealDriver::send(Instant now) {
  const Line line = encode(Numbered<Request>{line_, *said_});
  if (output_.size() + line.size() > output_.capacity()) output_.clear();  // it takes no bytes
  for (const std::uint8_t byte : line) output_.push_back(byte);
  const double on_the_wire = static_cast<double>(2 * kLineMax) * kBitsPerByte / baud_;
  answer_due_ = now + timing_.reply_timeout + from_seconds(on_the_wire);
}

void IdealDriver::say_again(Instant now) {
  ++health_.timeouts;
  if (tries_left_ == 0) return fall_silent(now);
  --tries_left_;
  ++health_.retries;
  send(now);
}

void IdealDriver::fall_silent(Instant now) {
  const Error error{ErrorCode::kDeviceSilent, -1, to_seconds(timing_.reply_timeout) * timing_.tries,
                    to_seconds(timing_.reply_timeout)};
  const bool waited_for = commands_ > 0;
  if (!waited_for && !told_silent_) {
    tell(activity_ == Activity::kOpening ? Kind::kFailed : Kind::kNotice, error);
  }
  told_silent_ = true;
  begin_anew(error, now);
  poll_due_ = now + timing_.silent_retry;
}

/// One line at a time; the first that is due of a stop, what ends a hold, a move, the jaws, a look.
void IdealDriver::say_what_is_due(Instant now) {
  if (said_ || activity_ == Activity::kClosed) return;
  const bool looks = now >= poll_due_;
  if (activity_ == Activity::kOpening && !known_) {
    if (looks) say(Hello{}, now);
    return;
  }
  if (stop_due_) return say(Stop{}, now);
  if (clear_due_) return say(Clear{}, now);
  for (const Pending& one : pending_) {
    if (!one.sent) return say(one.move, now);
  }
  if (jaws_due_) return say(Jaws{*jaws_due_}, now);
  if (looks) say(Ask{}, now);
}

/// Its power was away: it counts its moves from 0 again.
void IdealDriver::note_restart(Instant now) {
  const Error error{ErrorCode::kSupplyFlag, 0};
  if (commands_ == 0) tell(Kind::kNotice, error);
  begin_anew(error, now);
}

void IdealDriver::receive(std::span<const std::uint8_t> bytes, Instant now) {
  now_ = std::max(now_, now);
  for (const std::uint8_t byte : bytes) {
    const LineDecoder::Result result = decoder_.push(byte);
    if (result == LineDecoder::Result::kMore || activity_ == Activity::kClosed) continue;
    const auto reply =
        result == LineDecoder::Result::kLine ? decode_reply(decoder_.words()) : std::nullopt;
    if (!reply || !said_ || reply->number != line_) {
      ++health_.unexpected;
      // Its answer came damaged: no need to wait for another one.
      if (said_ && result == LineDecoder::Result::kDamaged) answer_due_ = now_;
      continue;
    }
    take(reply->what, now_);
  }
  poll(now);
}

void IdealDriver::take(const Reply& reply, Instant now) {
  std::visit([&](const auto& one) { take(one, now); }, reply);
}

void IdealDriver::take(const Identity& identity, Instant now) {
  if (!std::holds_alternative<Hello>(*said_)) return static_cast<void>(++health_.unexpected);
  said_.reset();
  if (identity.version != kVersion || identity.joints != joints_.size()) {
    const bool version = identity.version != kVersion;
    return fail(version ? Error{ErrorCode::kVersionMismatch, -1, identity.version * 1.0, kVersion}
                        : Error{ErrorCode::kModelMismatch});
  }
  number_ = identity.taken;
  known_ = true;
  stop_due_ = true;  // whatever a host before has left it doing
  poll_due_ = now;
}

void IdealDriver::take(const Refusal& refusal, Instant now) {
  const bool of_jaws = std::holds_alternative<Jaws>(*said_);
  said_.reset();
  const auto joint = static_cast<std::int8_t>(refusal.joint);
  if (refusal.why == Why::kNumber) return note_restart(now);
  if (of_jaws) return come_to_rest(Kind::kFailed, {ErrorCode::kToolNotFitted});
  fault_ = {ErrorCode::kDeviceRefused, refusal.why == Why::kLimit ? joint : std::int8_t{-1}};
  end_commands(Kind::kFailed, *fault_);
  begin_stop(now);
}

void IdealDriver::take(const State& state, Instant now) {
  if (std::holds_alternative<Hello>(*said_) || state.q.size() != joints_.size()) {
    return static_cast<void>(++health_.unexpected);
  }
  if (std::holds_alternative<Stop>(*said_)) stop_due_ = false;
  if (std::holds_alternative<Clear>(*said_)) clear_due_ = false;
  if (std::holds_alternative<Jaws>(*said_)) jaws_due_.reset();
  std::uint16_t taken = number_;
  for (Pending& one : pending_) {
    const auto* move = std::get_if<Move>(&*said_);
    one.sent = one.sent || (move != nullptr && move->number == one.move.number);
    if (!one.sent) --taken;
  }
  state_asked_ = said_at_;
  said_.reset();
  told_silent_ = false;
  // A stop takes what was behind it, so its count says nothing then.
  if (state.taken != taken && activity_ != Activity::kStopping && known_ && state_) {
    return note_restart(now);
  }
  number_ = static_cast<std::uint16_t>(number_ - taken + state.taken);
  state_ = state;
  const bool rests = activity_ == Activity::kIdle;
  poll_due_ = now + (rests ? timing_.resting_poll : timing_.moving_poll);
  if (state.jaws_um >= 0 && activity_ != Activity::kJaws)
    health_.jaws_width = state.jaws_um * kMicro;
  switch (activity_) {
    case Activity::kOpening:
      return step_opening(now);
    case Activity::kMoving:
      return step_moving(now);
    case Activity::kJaws:
      return step_jaws(now);
    case Activity::kStopping:
      return step_stopping(now);
    default:
      return;
  }
}

void IdealDriver::step_opening(Instant now) {
  if (stop_due_ || clear_due_ || state_->phase == Phase::kStopping) return;
  if (state_->phase == Phase::kHeld) {
    clear_due_ = true;
    poll_due_ = now;
    return;
  }
  activity_ = Activity::kIdle;
  since_ = now;
  update_positions(now);
  if (clearing_) {
    clearing_ = false;
    return end_commands(Kind::kDone);
  }
  tell(Kind::kReady);
}

void IdealDriver::step_moving(Instant now) {
  while (!pending_.empty() && pending_[0].sent) {
    const auto behind = static_cast<std::uint16_t>(state_->done - pending_[0].move.number);
    if (behind >= 0x8000) break;  // not done yet
    pending_.drop_front(1);
    --commands_;
    tell(Kind::kDone);
    if (pending_.empty()) {
      activity_ = Activity::kIdle;
      since_ = now;
      return update_positions(now);
    }
  }
  if (state_->phase != Phase::kHeld) return;
  switch (state_->held) {
    case Held::kBlocked:
      return fail({ErrorCode::kStalled, static_cast<std::int8_t>(state_->joint)});
    case Held::kStarved: {
      // The next motion may begin: nothing is wrong with the device.
      const double time = to_seconds(pending_[0].duration);
      clear_due_ = true;
      return come_to_rest(Kind::kFailed, {ErrorCode::kSegmentTime, -1, time, time});
    }
    default:
      return fail({ErrorCode::kLinkSilent, 0});
  }
}

void IdealDriver::step_jaws(Instant now) {
  if (jaws_due_) return;
  if (state_->jaws_um != jaws_to_ && now - since_ < timing_.jaws_timeout) return;
  health_.jaws_width = state_->jaws_um * kMicro;
  come_to_rest(Kind::kDone);
}

void IdealDriver::step_stopping(Instant now) {
  if (stop_due_ || clear_due_ || state_->phase == Phase::kStopping) return;
  if (state_->phase == Phase::kHeld && !fault_) {
    clear_due_ = true;
    poll_due_ = now;
    return;
  }
  come_to_rest(Kind::kStopped);
  update_positions(now);
}

void IdealDriver::update_positions(Instant now) {
  if (!state_ || activity_ == Activity::kOpening || activity_ == Activity::kClosed) return;
  const bool moves =
      state_->phase == Phase::kMoving || state_->phase == Phase::kStopping || !pending_.empty();
  const double age = to_seconds(now - state_asked_);
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const double q = state_->q[i] * kMicro;
    const double gone = kResolution + (moves ? age * joints_[i].velocity_max : 0);
    positions_[i] = {PositionQuality::kMeasured, q, q - gone, q + gone};
  }
}

}  // namespace sinew
