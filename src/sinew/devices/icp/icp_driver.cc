#include "sinew/devices/icp/icp_driver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew {

using namespace icp;

namespace {

constexpr std::uint8_t kAllLegs = (1U << kLegs) - 1;
constexpr Duration kSegmentMax = std::chrono::hours(24);
constexpr Duration kEarlySlack{100'000};  // ns; a clock of a port is some percent off
constexpr int kMeanOf = 16;               // cycles
/// Of quiet before the last question: a computer or a device that was busy has come back by then.
constexpr Duration kLastQuiet = std::chrono::seconds(1);
constexpr Duration kHeldFor{1'000'000};  // ns until it is looked again whether it may ask

template <std::size_t... Index>
std::array<IcpLegClaim, kLegs> make_claims(const IcpDevice& device, std::index_sequence<Index...>) {
  const auto units_per_down = static_cast<std::int64_t>(std::llround(device.units_per_down));
  return {IcpLegClaim(static_cast<std::int8_t>(Index), device.legs[Index], device.units_per_m,
                      units_per_down)...};
}

constexpr std::uint8_t bit_of(std::size_t leg) {
  return static_cast<std::uint8_t>(1U << leg);
}

std::uint8_t motor_of(std::size_t leg) {
  return static_cast<std::uint8_t>(leg + 1);
}

Error leg_error(ErrorCode code, std::size_t leg, double measured = 0, double limit = 0) {
  return {code, static_cast<std::int8_t>(leg), measured, limit};
}

}  // namespace

IcpDriver::IcpDriver(const IcpDevice& device, std::span<const Joint> legs, const IcpTiming& timing)
    : device_(device),
      timing_(timing),
      legs_(make_claims(device, std::make_index_sequence<kLegs>{})),
      cycle_time_(4 * timing.byte_time) {
  SINEW_ASSERT(legs.size() == kLegs && device.tries >= 1 && timing.quiet > Duration::zero());
  for (std::size_t i = 0; i < kLegs; ++i) {
    ranges_[i] = legs[i];
  }
}

void IcpDriver::open(Instant now) {
  fault_.reset();
  begin_opening(now);
}

void IcpDriver::begin_opening(Instant now) {
  opening_ = true;
  read_ = false;
  recovering_ = true;
  leading_out_ = true;
  polls_ = kAllLegs;
  failures_ = 0;
  rereads_ = 0;
  poll_error_.reset();
  supply_lost_ = false;
  kill_suspected_ = false;
  heard_ = now;
  // The device may be inside an exchange, its own or another host's: FF leads out of there, and no
  // bit of it makes a step, as one of a sync byte would.
  listen(now);
}

/// Nothing is said until the line has been silent.
void IcpDriver::listen(Instant now) {
  output_.reset();
  decoder_.expect(ReplyDecoder::Due::kNothing);
  quiet_since_ = now;
  phase_ = Phase::kQuiet;
  deadline_ = now + timing_.quiet;
}

void IcpDriver::close(Instant now) {
  if (phase_ == Phase::kClosed) return;
  if (phase_ == Phase::kStep) {
    const StepMerge::Step step = merge_.next();
    legs_[step.leg].maybe_stepped(step.direction);
    refresh(step.leg);
  }
  if (phase_ == Phase::kSelect) {
    legs_[polled_].status_lost();
    refresh(polled_);
  }
  // Whether the legs did as they were told stays open where nobody has looked since.
  const bool unread = finishing_ || stopping_ || legs_to_read() != 0;
  if (unread || supply_lost_ || (recovering_ && !opening_)) suspect_supply();
  if (stop_asked_) end_stopped(now);
  tell_stopped();
  if (opening_ || !queue_.empty() || command_ != Command::kNone) {
    give_up({ErrorCode::kPortClosed});
  }
  stopping_ = false;
  recovering_ = false;
  polls_ = 0;
  held_since_.reset();
  supply_lost_ = false;
  fault_.reset();
  output_.reset();
  deadline_.reset();
  phase_ = Phase::kClosed;
}

DriverState IcpDriver::state() const {
  if (phase_ == Phase::kClosed) return DriverState::kClosed;
  if (fault_) return DriverState::kFault;
  if (stop_asked_ || stopping_) return DriverState::kStopping;
  if (recovering_) return DriverState::kOpening;
  const bool busy = !queue_.empty() || command_ != Command::kNone;
  return busy ? DriverState::kMoving : DriverState::kReady;
}

Expected<void> IcpDriver::ready() const {
  if (phase_ == Phase::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (fault_) return std::unexpected(*fault_);
  const bool doubtful = opening_ || (recovering_ && queue_.empty());
  if (doubtful || stop_asked_ || stopping_ || command_ != Command::kNone) {
    return std::unexpected(Error{ErrorCode::kBusy});
  }
  return {};
}

std::optional<Instant> IcpDriver::goes_on_until() const {
  return stop_asked_ ? deadline_ : std::nullopt;
}

bool IcpDriver::wants_move(Instant) const {
  return ready().has_value() && queue_.size() < 2;
}

std::optional<Error> IcpDriver::too_uncertain() const {
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (!legs_[i].known() || legs_[i].uncertainty() > timing_.uncertain_units_max) {
      return leg_error(ErrorCode::kPositionUnknown, i);
    }
  }
  return std::nullopt;
}

std::optional<Error> IcpDriver::too_far(std::size_t leg, double length) const {
  const SendRange& range = ranges_[leg];
  if (range.from(positions_[leg]).holds(length)) return std::nullopt;
  const double limit = length < range.lower ? range.lower : range.upper;
  return leg_error(ErrorCode::kLegLength, leg, length, limit);
}

Expected<void> IcpDriver::move(const JointMove& move, Instant now) {
  if (const auto able = ready(); !able) return able;
  if (const auto error = too_uncertain()) return std::unexpected(*error);
  SINEW_ASSERT(move.q.size() == kLegs);
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (const auto error = too_far(i, move.q[i])) return std::unexpected(*error);
  }
  if (move.duration < Duration::zero() || move.duration > kSegmentMax) {
    return std::unexpected(
        Error{ErrorCode::kSegmentTime, -1, to_seconds(move.duration), to_seconds(kSegmentMax)});
  }
  return accept({.q = move.q, .duration = move.duration}, now);
}

Expected<void> IcpDriver::jog(std::size_t leg, std::int64_t steps, Instant now) {
  SINEW_ASSERT(leg < kLegs);
  if (const auto able = ready(); !able) return able;
  const double most = kJogMax * device_.units_per_m;
  if (steps == 0 || std::abs(static_cast<double>(steps)) > most) {
    return std::unexpected(leg_error(ErrorCode::kStepRange, leg, static_cast<double>(steps), most));
  }
  if (legs_[leg].known()) {
    const double q = positions_[leg].q + legs_[leg].way_of(steps);
    if (const auto error = too_far(leg, q)) return std::unexpected(*error);
  }
  Move jog;
  jog.jog[leg] = steps;
  return accept(jog, now);
}

Expected<void> IcpDriver::nudge(std::size_t leg, double way, Duration duration, Instant now) {
  SINEW_ASSERT(leg < kLegs);
  const double unit = std::abs(legs_[leg].way_of(way < 0 ? -1 : 1));
  // Written so that NaN is refused too.
  if (!(std::abs(way) >= unit / 2 && std::abs(way) <= kJogMax)) {
    return std::unexpected(leg_error(ErrorCode::kNudgeRange, leg, way, kJogMax));
  }
  const auto begun = jog(leg, std::llround(way / unit), now);
  if (begun) queue_.back().duration = std::min(duration, kSegmentMax);
  return begun;
}

Expected<void> IcpDriver::accept(const Move& move, Instant now) {
  if (queue_.full()) return std::unexpected(Error{ErrorCode::kBusy});
  queue_.push_back(move);
  if (queue_.size() > 1) return {};
  SINEW_ASSERT(phase_ == Phase::kIdle);
  begin_move(now);
  next_of_move(now);
  return {};
}

void IcpDriver::begin_move(Instant start) {
  StepMerge::Counts counts = queue_[0].jog;
  if (!queue_[0].q.empty()) {
    for (std::size_t i = 0; i < kLegs; ++i) counts[i] = legs_[i].steps_to(queue_[0].q[i]);
  }
  merge_ = StepMerge(counts);
  move_start_ = start;
}

void IcpDriver::stop(Instant now) {
  if (stop_asked_) return;
  if (stopping_) {
    stops_owed_ = std::max<std::size_t>(stops_owed_, 1);
    return;
  }
  if (queue_.empty()) {
    const bool told = !events_.empty() && events_.back().kind == DriverEvent::Kind::kStopped;
    if (!told) tell(DriverEvent::Kind::kStopped);
    return;
  }
  // A step that is on its way is waited for; anything else moves nothing.
  stop_asked_ = true;
  if (phase_ != Phase::kStep) end_stopped(now);
}

/// Nothing moves any more. It is told when the legs have been read: who hears it may leave.
void IcpDriver::end_stopped(Instant now) {
  stops_owed_ += queue_.size();
  queue_.clear();
  merge_ = {};
  finishing_ = false;
  stop_asked_ = false;
  polls_ = static_cast<std::uint8_t>(polls_ | legs_to_read());
  stopping_ = true;
  if (phase_ == Phase::kPause) next(now);
}

void IcpDriver::tell_stopped() {
  for (; stops_owed_ > 0; --stops_owed_) tell(DriverEvent::Kind::kStopped);
}

/// All, where one has moved: a low supply may have let go of the others alone.
std::uint8_t IcpDriver::legs_to_read() const {
  const bool moved =
      std::any_of(legs_.begin(), legs_.end(), [](const IcpLegClaim& leg) { return leg.moved(); });
  return moved ? kAllLegs : std::uint8_t{0};
}

std::uint8_t IcpDriver::tagged_legs() const {
  std::uint8_t tagged = 0;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (legs_[i].tagged()) tagged = static_cast<std::uint8_t>(tagged | bit_of(i));
  }
  return tagged;
}

Expected<void> IcpDriver::clear_fault(Instant now) {
  if (phase_ == Phase::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (!fault_) return {};
  fault_.reset();
  begin_opening(now);
  return {};
}

Expected<void> IcpDriver::service(DeviceService what, Instant now) {
  if (what == DeviceService::kWake) return wake(now);
  if (what == DeviceService::kShutDown) return kill(now);
  return std::unexpected(Error{ErrorCode::kNoSuchService});
}

void IcpDriver::declare_positions(std::span<const JointPosition> positions) {
  SINEW_ASSERT(positions.size() == kLegs);
  if (!queue_.empty() || stopping_) return;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (phase_ == Phase::kClosed) {
      legs_[i].declare(positions[i]);
    } else {
      legs_[i].declare_standing(positions[i]);
    }
    refresh(i);
  }
}

void IcpDriver::remember(const DriverMemory& memory) {
  for (std::size_t i = 0; i < kLegs; ++i) {
    if ((memory.counted >> i & 1U) != 0) legs_[i].expect_tag();
  }
}

Expected<void> IcpDriver::begin_command(Command command, std::uint8_t polls, Instant now) {
  if (const auto able = ready(); !able) return able;
  if (!queue_.empty()) return std::unexpected(Error{ErrorCode::kBusy});
  command_ = command;
  polls_ = polls;
  begin_exchange(now);
  return {};
}

Expected<void> IcpDriver::wake(Instant now) {
  // C0 clears the flags of all modules: they are read before it.
  return begin_command(Command::kWake, kAllLegs, now);
}

Expected<void> IcpDriver::kill(Instant now) {
  return begin_command(Command::kKill, 0, now);
}

// --- exchanges ---

void IcpDriver::send(const Request& request, Phase phase, Instant now) {
  using Due = ReplyDecoder::Due;
  output_ = encode_request(request);
  phase_ = phase;
  read_ = read_ || phase == Phase::kSelect || phase == Phase::kWake;
  asked_ = now;
  earliest_ = now + 2 * timing_.byte_time - kEarlySlack;
  const bool silent = phase == Phase::kQuiet || phase == Phase::kKill;
  const bool block = phase == Phase::kSelect;
  Due due = block ? Due::kBlock : Due::kByte;
  if (silent) due = Due::kNothing;
  decoder_.expect(due);
  const auto bytes = block ? 2 + kStatusSize : std::size_t{2};
  const Duration wire = static_cast<std::int64_t>(bytes) * timing_.byte_time;
  deadline_ = now + (silent ? timing_.byte_time + timing_.quiet : wire + device_.reply_timeout);
}

bool IcpDriver::looks() const {
  const bool open = phase_ != Phase::kClosed && !fault_;
  return open && (polls_ != 0 || recovering_ || command_ == Command::kWake);
}

/// A status is due. Its flags are cleared by reading, so who keeps records writes first that they
/// are read.
void IcpDriver::hold(Instant now) {
  if (!held_since_) held_since_ = now;
  if (now - *held_since_ > timing_.look_limit) {
    suspect_supply();
    return give_up({ErrorCode::kNotRecorded});
  }
  phase_ = Phase::kHeld;
  deadline_ = now + kHeldFor;
}

void IcpDriver::begin_exchange(Instant now) {
  if (looks() && !looks_allowed_) return hold(now);
  held_since_.reset();
  if (!recovering_ && now - heard_ >= timing_.idle_limit) kill_suspected_ = true;
  ++health_.requests;
  began_ = now;
  send(Init{}, Phase::kInit, now);
}

/// The device waits for a command: only now is it decided which.
void IcpDriver::send_command(Instant now) {
  if (!recovering_ && polls_ == 0) {
    if (command_ == Command::kKill) return send(Kill{}, Phase::kKill, now);
    if (command_ == Command::kWake) return send(Wake{}, Phase::kWake, now);
    if (running() && !merge_.done()) {
      const StepMerge::Step step = merge_.next();
      const bool direction = legs_[step.leg].wire_bit(step.direction);
      return send(Step{motor_of(step.leg), direction}, Phase::kStep, now);
    }
    // Stopped in between: out of the exchange by a question that moves nothing.
    polls_ = bit_of(0);
  }
  send(StatusRequest{}, Phase::kRequest, now);
}

void IcpDriver::receive(std::span<const std::uint8_t> bytes, Instant now) {
  // What was due before these bytes came is late, whoever called first. But an answer is one as
  // long as nothing was sent behind its request: who was late may have been this host, which looked
  // away.
  if (deadline_ && now > *deadline_ && !awaits_answer()) poll(now);
  for (const std::uint8_t byte : bytes) {
    if (phase_ == Phase::kClosed) return;
    on_byte(byte, now);
  }
}

bool IcpDriver::awaits_answer() const {
  return phase_ == Phase::kInit || phase_ == Phase::kStep || phase_ == Phase::kRequest ||
         phase_ == Phase::kSelect || phase_ == Phase::kWake;
}

void IcpDriver::on_byte(std::uint8_t byte, Instant now) {
  heard_ = now;
  kill_suspected_ = false;
  if (fault_) {
    ++health_.unexpected;
    return;
  }
  if (phase_ == Phase::kQuiet) {
    ++health_.unexpected;
    if (now - quiet_since_ > timing_.quiet_limit) {
      suspect_silence();
      return give_up({ErrorCode::kUnaskedReply, -1, 1.0 * byte});
    }
    deadline_ = now + timing_.quiet;
    return;
  }
  const bool early = timing_.refuse_early && now < earliest_;
  const auto reply = decoder_.push(byte);
  if (early || (reply && !*reply)) {
    ++health_.unexpected;
    const bool unasked = early || byte == kAck;
    return doubt(unasked ? Error{ErrorCode::kUnaskedReply, -1, 1.0 * byte}
                         : Error{ErrorCode::kUnexpectedReply, -1, 1.0 * byte, 1.0 * kAck},
                 now);
  }
  if (reply) on_reply(**reply, now);
}

void IcpDriver::on_reply(const Reply& reply, Instant now) {
  if (std::holds_alternative<Refused>(reply)) return on_refusal(now);
  if (const auto* status = std::get_if<Status>(&reply)) return on_status(*status, now);
  switch (phase_) {
    case Phase::kInit:
      return send_command(now);
    case Phase::kStep:
      step_made(now);
      if (stop_asked_) end_stopped(now);
      return next(now);
    case Phase::kRequest: {
      polled_ = static_cast<std::size_t>(std::countr_zero(polls_));
      const std::uint8_t motor = motor_of(polled_);
      const Request plain = Select{motor};
      return send(selector_is_step_ ? Request{Step{motor, false}} : plain, Phase::kSelect, now);
    }
    case Phase::kWake:
      command_ = Command::kStatus;
      polls_ = kAllLegs;
      return next(now);
    default:
      break;
  }
}

void IcpDriver::on_refusal(Instant now) {
  if (phase_ == Phase::kWake) {
    // A firmware without C0: a status wakes a module as well.
    command_ = Command::kStatus;
    polls_ = kAllLegs;
    return next(now);
  }
  if (phase_ == Phase::kInit) {
    // It was inside an exchange, and left it with this answer.
    recovering_ = true;
    if (polls_ == 0) polls_ = bit_of(0);
  }
  if (stop_asked_) end_stopped(now);
  ++health_.retries;
  // Behind a doubt that is what the FF is for, and no failure of its own.
  if (phase_ == Phase::kInit && std::exchange(leading_out_, false)) return listen(now);
  count_failure();
  if (failures_ < device_.tries) {
    // It may have been the answer to something older: then all that follow would be too.
    return recovering_ ? listen(now) : next(now);
  }
  if (phase_ == Phase::kSelect && !selector_is_step_) {
    selector_is_step_ = true;
    failures_ = 0;
    return next(now);
  }
  give_up({ErrorCode::kDeviceRefused});
}

void IcpDriver::on_status(const Status& status, Instant now) {
  facts_.legs[polled_].status = {status, now};
  failures_ = 0;
  Error error;
  const IcpLegClaim::Verdict verdict = legs_[polled_].judge(status, error);
  if (verdict == IcpLegClaim::Verdict::kDoubtful && ++rereads_ < device_.tries) {
    ++health_.retries;
    return begin_exchange(now);
  }
  rereads_ = 0;
  if (tmc222::tells_trouble(status.one.flags)) facts_.legs[polled_].troubled = {status, now};
  if (verdict == IcpLegClaim::Verdict::kGood) {
    legs_[polled_].confirm(status);
  } else {
    supply_lost_ = supply_lost_ || legs_[polled_].shows_supply_loss(status);
    legs_[polled_].withdraw(status);
    if (!poll_error_) poll_error_ = error;
  }
  refresh(polled_);
  polls_ = static_cast<std::uint8_t>(polls_ & ~unsigned{bit_of(polled_)});
  if (polls_ == 0 && !poll_error_) {
    for (std::size_t i = 0; i < kLegs; ++i) {
      legs_[i].round_passed();
      refresh(i);
    }
  }
  next(now);
}

void IcpDriver::step_made(Instant now) {
  const StepMerge::Step step = merge_.next();
  merge_.advance();
  legs_[step.leg].stepped(step.direction);
  refresh(step.leg);
  failures_ = 0;
  cycle_time_ += (now - began_ - cycle_time_) / kMeanOf;
}

// --- what comes next ---

/// The device is in its loop and nothing is on its way.
void IcpDriver::next(Instant now) {
  phase_ = Phase::kIdle;
  deadline_.reset();
  if (polls_ != 0) return begin_exchange(now);
  if (poll_error_) {
    if (supply_lost_) suspect_supply();
    return give_up(*std::exchange(poll_error_, std::nullopt));
  }
  const bool recovered = std::exchange(recovering_, false);
  const bool at_rest = queue_.empty() && command_ == Command::kNone && !stopping_;
  if (std::exchange(opening_, false) || (recovered && at_rest)) tell(DriverEvent::Kind::kReady);
  stopping_ = false;
  tell_stopped();
  if (command_ == Command::kStatus) {
    command_ = Command::kNone;
    return tell(DriverEvent::Kind::kDone);
  }
  if (command_ != Command::kNone) return begin_exchange(now);
  if (queue_.empty()) return;
  if (finishing_) return finish(now);
  next_of_move(now);
}

void IcpDriver::next_of_move(Instant now) {
  const Move& move = queue_[0];
  if (const auto error = too_uncertain(); error && !move.q.empty()) {
    fail_all(*error);
    polls_ = legs_to_read();
    stopping_ = polls_ != 0;
    return next(now);
  }
  const double share = merge_.done() ? 1
                                     : static_cast<double>(merge_.total() - merge_.remaining()) /
                                           static_cast<double>(merge_.total());
  const Instant due = move_start_ + from_seconds(to_seconds(move.duration) * share);
  if (now < due) {
    phase_ = Phase::kPause;
    deadline_ = due;
    return;
  }
  if (!merge_.done()) {
    // Whether the power was away in the meantime must be seen before a step hides it.
    if (now - heard_ > timing_.trust) polls_ = tagged_legs();
    return begin_exchange(now);
  }
  if (queue_.size() == 1) {
    finishing_ = true;
    polls_ = legs_to_read();
    return next(now);
  }
  finish(now);
}

/// The first move of the queue is carried out.
void IcpDriver::finish(Instant now) {
  finishing_ = false;
  const Instant end = move_start_ + queue_[0].duration;
  queue_.drop_front(1);
  tell(DriverEvent::Kind::kDone);
  if (queue_.empty()) return;
  // In time: the next one's time begins where this one's ended, so that nothing adds up.
  begin_move(now - end < cycle_time_ ? end : now);
  next_of_move(now);
}

// --- doubts ---

void IcpDriver::doubt(const Error& error, Instant now) {
  const Phase was = phase_;
  if (was == Phase::kStep) {
    const StepMerge::Step step = merge_.next();
    merge_.advance();
    legs_[step.leg].maybe_stepped(step.direction);
    refresh(step.leg);
  }
  if (was == Phase::kSelect) {
    legs_[polled_].status_lost();
    refresh(polled_);
  }
  if (was == Phase::kKill) {
    command_ = Command::kNone;
    tell(DriverEvent::Kind::kFailed, error);
  }
  // All of them: what silenced the controller may have taken the modules' power as well, and a
  // step more would hide that.
  polls_ = kAllLegs;
  recovering_ = true;
  leading_out_ = true;
  if (stop_asked_) {
    phase_ = Phase::kQuiet;
    end_stopped(now);
  }
  count_failure();
  // Before its power is blamed it is asked once more.
  const bool silent = error.code == ErrorCode::kDeviceSilent && !opening_ && !stopping_;
  if (failures_ >= device_.tries + (silent ? 1 : 0)) {
    suspect_silence();
    if (error.code != ErrorCode::kDeviceSilent) return give_up(error);
    return give_up(kill_suspected_ ? Error{ErrorCode::kDeviceKilled} : silence(now));
  }
  ++health_.retries;
  listen(now);
  if (failures_ >= device_.tries) deadline_ = now + kLastQuiet;
  // Where a selector is due, no bit of a sync byte makes a step of it; elsewhere it could.
  if (was == Phase::kSelect || was == Phase::kKill) send(Sync{}, Phase::kQuiet, now);
}

void IcpDriver::count_failure() {
  if (failures_++ == 0) failing_since_ = asked_;
}

/// As a person has waited for it: all the tries, not the last one.
Error IcpDriver::silence(Instant now) const {
  constexpr double kTenths = 10;
  const Duration patience = device_.tries * (2 * timing_.byte_time + device_.reply_timeout);
  const double limit = std::ceil(to_seconds(patience) * kTenths) / kTenths;
  return {ErrorCode::kDeviceSilent, -1, to_seconds(now - failing_since_), limit};
}

/// A status tells of the supply, which all six share.
void IcpDriver::suspect_supply() {
  for (std::size_t i = 0; i < kLegs; ++i) {
    legs_[i].suspect_supply();
    refresh(i);
  }
}

/// What silences the controller, or one module, may have taken the current from all six.
void IcpDriver::suspect_silence() {
  // Who never was heard has lost nothing of what its modules will say when it is.
  if (opening_ && !read_) return;
  for (std::size_t i = 0; i < kLegs; ++i) {
    legs_[i].suspect_silence();
    refresh(i);
  }
}

void IcpDriver::give_up(const Error& error) {
  fault_ = error;
  fail_all(error);
  phase_ = Phase::kIdle;
  deadline_.reset();
  decoder_.expect(ReplyDecoder::Due::kNothing);
  output_.reset();
  recovering_ = false;
  stopping_ = false;
  polls_ = 0;
  held_since_.reset();
  poll_error_.reset();
  failures_ = 0;
  rereads_ = 0;
  supply_lost_ = false;
}

void IcpDriver::fail_all(const Error& error) {
  const bool nobody = queue_.empty() && command_ == Command::kNone && !opening_;
  tell_stopped();
  for (std::size_t i = 0; i < queue_.size(); ++i) tell(DriverEvent::Kind::kFailed, error);
  if (std::exchange(command_, Command::kNone) != Command::kNone) {
    tell(DriverEvent::Kind::kFailed, error);
  }
  if (std::exchange(opening_, false)) tell(DriverEvent::Kind::kFailed, error);
  if (nobody) tell(DriverEvent::Kind::kNotice, error);
  queue_.clear();
  merge_ = {};
  finishing_ = false;
}

// --- time and bytes ---

void IcpDriver::poll(Instant now) {
  // Each deadline is followed by a later one or none.
  for (int i = 0; i < 4 && deadline_ && now >= *deadline_; ++i) on_deadline(now);
}

void IcpDriver::on_deadline(Instant now) {
  switch (phase_) {
    case Phase::kQuiet:
    case Phase::kHeld:
      return begin_exchange(now);
    case Phase::kPause:
      return next(now);
    case Phase::kKill:
      command_ = Command::kNone;
      tell(DriverEvent::Kind::kDone);
      fault_ = Error{ErrorCode::kDeviceKilled};
      phase_ = Phase::kIdle;
      return deadline_.reset();
    default:
      break;
  }
  // F0 and C0 are one bit from E0. Behind a silent FF the suspicion stays as it was.
  const bool special = phase_ == Phase::kRequest || phase_ == Phase::kWake;
  if (phase_ != Phase::kInit) kill_suspected_ = special;
  ++health_.timeouts;
  doubt({ErrorCode::kDeviceSilent, -1, to_seconds(now - asked_), to_seconds(*deadline_ - asked_)},
        now);
}

std::int64_t IcpDriver::steps_left() const {
  std::int64_t steps = merge_.remaining();
  for (std::size_t i = 1; i < queue_.size(); ++i) {
    for (std::size_t leg = 0; leg < kLegs; ++leg) {
      steps += std::abs(queue_[i].jog[leg]);
      if (queue_[i].q.empty() || queue_[i - 1].q.empty()) continue;
      steps +=
          std::llround(std::abs(queue_[i].q[leg] - queue_[i - 1].q[leg]) * device_.units_per_m);
    }
  }
  return steps;
}

std::size_t IcpDriver::take_output(std::span<std::uint8_t> out) {
  if (!output_ || out.empty()) return 0;
  out[0] = *output_;
  output_.reset();
  return 1;
}

std::optional<DriverEvent> IcpDriver::take_event() {
  return events_.take_front();
}

void IcpDriver::tell(DriverEvent::Kind kind, const Error& error) {
  // What ends no command may be lost where nobody listens.
  const bool ends = kind != DriverEvent::Kind::kNotice && kind != DriverEvent::Kind::kReady;
  if (events_.full() && !ends) return;
  SINEW_ASSERT(!events_.full());
  events_.push_back({kind, error});
}

}  // namespace sinew
