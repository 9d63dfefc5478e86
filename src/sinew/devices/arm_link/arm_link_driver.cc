#include "sinew/devices/arm_link/arm_link_driver.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew {

using namespace bigrobotarm;
using arm_link::Channel;
using arm_link::Kind;
using mcu::arm_link::Fault;
using mcu::arm_link::Reference;
using Event = DriverEvent::Kind;

namespace {

constexpr double kUnits = mcu::kUnitsPerStep;
constexpr double kServoUnits = mcu::kServoUnitsPerDegree;
constexpr double kMs = 1e-3;  // s
using Milliseconds = std::chrono::milliseconds;
/// No stop of the board takes longer.
constexpr Duration kBrakingMost = Milliseconds(mcu::kStopMsMax);

Words words_of(const mcu::arm_link::Reply& reply) {
  Words words{};
  for (std::size_t i = 0; i < kJoints; ++i) words[i] = (reply.positions[i] + 128) >> 8;
  return words;
}

/// Why the board has stopped by itself.
Error error_of(Fault fault) {
  switch (fault) {
    case Fault::kNone:
    case Fault::kStopAsked:
      return {ErrorCode::kForeignMotion};
    case Fault::kHostSilent:
      return {ErrorCode::kLinkSilent};
    case Fault::kUnderrun:
      return {ErrorCode::kStreamEnded};
    case Fault::kStopLine:
      return {ErrorCode::kEmergencyStop};
    case Fault::kRefused:
      return {ErrorCode::kDeviceRefused};
    case Fault::kRestart:
      break;
  }
  return {ErrorCode::kDeviceRestarted};
}

}  // namespace

ArmLinkDriver::ArmLinkDriver(const ArmLinkDevice& device, std::span<const Joint> joints,
                             const ArmLinkTiming& timing)
    : device_(device), timing_(timing), channel_(timing.wire), belief_(device.arm.joints) {
  SINEW_ASSERT(joints.size() == kJoints);
  for (const Joint& joint : joints) joints_.push_back(joint);
}

double ArmLinkDriver::units_of(std::size_t joint, double q) const {
  return (q - belief_.offset()[joint]) * device_.arm.joints[joint].steps_per_rad * kUnits;
}

double ArmLinkDriver::angle_of(std::size_t joint, std::int32_t units) const {
  return belief_.offset()[joint] + units / kUnits / device_.arm.joints[joint].steps_per_rad;
}

// Opening and closing

void ArmLinkDriver::open(Instant now) {
  if (activity_ != Activity::kClosed) close(now);
  belief_.reopen();
  begin_anew({}, now);
}

/// The longest that the arm goes on by what it was sent, and then brakes.
Duration ArmLinkDriver::braking() const {
  double longest = 0;
  for (const Joint& joint : joints_) {
    longest = std::max(longest, joint.velocity_max / joint.acceleration_max);
  }
  return std::min(from_seconds(longest), kBrakingMost) + Milliseconds(50);
}

/// Where the arm may come to rest from here on: at the ends of what was sent, and on the way to
/// rest from anywhere before, in which all joints brake as long as the slowest one.
std::array<JointInterval, kJoints> ArmLinkDriver::reach() const {
  double longest = 0;  // s
  for (const End& end : ends_) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      longest = std::max(longest, end.peak[i] / joints_[i].acceleration_max);
    }
  }
  std::array<JointInterval, kJoints> all{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    JointInterval way{shown_[i].lower, shown_[i].upper};
    double peak = 0;
    for (const End& end : ends_) {
      way.lower = std::min(way.lower, end.way[i].lower - (rest_[i].q - rest_[i].lower));
      way.upper = std::max(way.upper, end.way[i].upper + (rest_[i].upper - rest_[i].q));
      peak = std::max(peak, end.peak[i]);
    }
    all[i] = {way.lower - peak * longest / 2, way.upper + peak * longest / 2};
  }
  return all;
}

/// The motion goes on unseen.
void ArmLinkDriver::leave_motion() {
  goes_on_until_ = now_ + device_.deadline + timing_.ahead + braking();
  show();
  const auto all = activity_ == Activity::kStopping ? stop_reach_ : reach();
  left_ = shown_;
  for (std::size_t i = 0; i < kJoints; ++i) {
    JointPosition& joint = (*left_)[i];
    joint.under_way = false;
    if (joint.quality == PositionQuality::kLost) continue;
    joint.quality = PositionQuality::kUncertain;
    joint.lower = std::min(joint.lower, all[i].lower);
    joint.upper = std::max(joint.upper, all[i].upper);
  }
}

/// Finds the board, from the beginning.
void ArmLinkDriver::begin_anew(const Error& why, Instant now) {
  now_ = poll_due_ = now;
  const bool moved = activity_ == Activity::kMoving || activity_ == Activity::kStopping;
  if (moved) leave_motion();
  if (activity_ != Activity::kOpening) opened_at_ = now, told_silent_ = false;
  if (commands_.open() > 0) {
    commands_.end_all(Event::kFailed, why);
  } else if (activity_ == Activity::kIdle && why.code == ErrorCode::kDeviceSilent) {
    commands_.tell(Event::kNotice, why);
  }
  activity_ = Activity::kOpening;
  step_ = Step::kHello;
  fault_.reset();
  clearing_ = stop_due_ = false;
  due_.reset();
  say_due_.reset();
  nudge_.reset();
  queue_.clear();
  pieces_.clear();
  ends_.clear();
  channel_.reset();
  show();
}

void ArmLinkDriver::close(Instant now) {
  now_ = std::max(now_, now);
  if (activity_ == Activity::kClosed) return;
  const bool opening = activity_ == Activity::kOpening && !told_silent_;
  begin_anew({ErrorCode::kPortClosed}, now_);
  if (opening) commands_.tell(Event::kFailed, {ErrorCode::kPortClosed});
  commands_.end_stop();
  activity_ = Activity::kClosed;
}

DriverState ArmLinkDriver::state() const {
  switch (activity_) {
    case Activity::kClosed:
      return DriverState::kClosed;
    case Activity::kOpening:
      return DriverState::kOpening;
    case Activity::kMoving:
    case Activity::kAsking:
      return DriverState::kMoving;
    case Activity::kStopping:
      return DriverState::kStopping;
    case Activity::kIdle:
      break;
  }
  return fault_ ? DriverState::kFault : DriverState::kReady;
}

std::optional<Instant> ArmLinkDriver::goes_on_until() const {
  return goes_on_until_ && now_ < *goes_on_until_ ? goes_on_until_ : std::nullopt;
}

DriverHealth ArmLinkDriver::health() const {
  DriverHealth health;
  health.requests = channel_.requests;
  health.retries = channel_.retries;
  health.timeouts = channel_.timeouts;
  health.unexpected = channel_.unexpected;
  return health;
}

DeviceFacts ArmLinkDriver::facts() const {
  ArmLinkFacts facts = facts_;
  facts.wants_declaration = wants_declaration();
  return DeviceFacts(facts);
}

void ArmLinkDriver::say_hello(Instant now) {
  Request hello{};
  hello.kind = Kind::kHello;
  hello.deadline_ms = static_cast<std::uint16_t>(device_.deadline / std::chrono::milliseconds(1));
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double steps =
        joints_[i].acceleration_max * std::abs(device_.arm.joints[i].steps_per_rad);
    hello.brakings[i] = static_cast<std::uint16_t>(std::clamp(steps, 1.0, 65535.0));
  }
  channel_.send(hello, now);
}

void ArmLinkDriver::take_opening(const Channel::Answered& answered) {
  const Reply& reply = answered.reply;
  if (step_ == Step::kHello) {
    step_ = Step::kRest;
    return ask(Kind::kIdentity);
  }
  if (step_ == Step::kRest) {
    // Another host's motion ends first.
    if (reply.moving) goes_on_until_ = now_ + braking();
    if (reply.moving || reply.queued_ms > 0) return;
    judge(reply);
    if (reply.reference != Reference::kSaid) say_due_ = now_ + timing_.said;
    step_ = Step::kRelease;
    if (reply.fault != Fault::kNone) return ask(Kind::kRelease);
  } else if (due_ || answered.request.kind == Kind::kRead || asked_again(answered)) {
    return;
  }
  if (reply.fault != Fault::kNone) fault_ = error_of(reply.fault);
  become_ready();
}

void ArmLinkDriver::judge(const Reply& reply) {
  left_.reset();
  bigrobotarm::Status status;
  status.positions = words_of(reply);
  BigRobotArmStart start = BigRobotArmStart::kNone;
  if (reply.reference != Reference::kSaid) {
    const bool anew = reply.reference == Reference::kPowerUp && status.positions == Words{};
    start = anew ? BigRobotArmStart::kAnew : BigRobotArmStart::kKept;
  }
  belief_.judge(status, start);
  if (reply.reference == Reference::kKeptMoving) belief_.lose();
  if (const auto counted = belief_.take_contradiction()) {
    commands_.tell(Event::kNotice, *counted);
  }
}

void ArmLinkDriver::become_ready() {
  activity_ = Activity::kIdle;
  goes_on_until_.reset();
  told_silent_ = false;
  if (fault_) {
    commands_.tell(Event::kFailed, *fault_);
  } else {
    commands_.tell(Event::kReady);
  }
  commands_.end_stop();
  show();
}

// What is asked for

Expected<void> ArmLinkDriver::may_begin() const {
  if (activity_ == Activity::kClosed) return std::unexpected(Error{ErrorCode::kPortClosed});
  if (fault_) return std::unexpected(*fault_);
  if (activity_ != Activity::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  return {};
}

bool ArmLinkDriver::wants_move(Instant /*now*/) const {
  if (fault_ || ends_.full() || queue_.full()) return false;
  if (activity_ == Activity::kIdle) return true;
  if (activity_ != Activity::kMoving || rests_ || nudge_) return false;
  const int queued = facts_.state ? facts_.state->what.queued_ms : 0;
  return stream_ - Milliseconds(sent_ms_ - queued) < timing_.ahead;
}

Expected<void> ArmLinkDriver::move(const JointMove& move, Instant now) {
  poll(now);
  const bool follows = activity_ == Activity::kMoving && wants_move(now);
  if (!follows) {
    if (const auto may = may_begin(); !may) return may;
    if (const auto unknown = belief_.unknown()) {
      return std::unexpected(
          Error{ErrorCode::kPositionUnknown, static_cast<std::int8_t>(*unknown)});
    }
    for (std::size_t i = 0; i < kJoints; ++i) target_[i] = {shown_[i].q, 0};
  }
  if (const auto harsh = too_harsh(move)) return std::unexpected(*harsh);
  const Duration begin = follows ? stream_ : Duration::zero();
  const auto pushed =
      queue_.push(move, {joints_.data(), kJoints}, {target_.data(), kJoints}, Instant{} + begin);
  if (!pushed) return pushed;
  if (!follows) begin_motion();
  rests_ = queue_.back().ends_at_rest;
  stream_ = begin + move.duration;
  std::array<Cubic, kJoints> pieces;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const segments::Setpoint end = queue_.back().pieces[i].end();
    pieces[i] = Cubic(target_[i], end, to_seconds(move.duration));
    target_[i] = end;
  }
  add_end(stream_, pieces);
  commands_.accept();
  Words end{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    end[i] = static_cast<std::int32_t>(std::lround(units_of(i, target_[i].q) / kUnits));
  }
  belief_.go(end);
  make_pieces();
  poll(now);
  return {};
}

void ArmLinkDriver::add_end(Duration at, const std::array<Cubic, kJoints>& pieces) {
  End end{.at = at};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double from = pieces[i].at(0).q, to = pieces[i].end().q;
    JointInterval& way = end.way[i];
    way = {std::min(from, to), std::max(from, to)};
    pieces[i].for_turns([&](double q) {
      way.lower = std::min(way.lower, q);
      way.upper = std::max(way.upper, q);
    });
    end.peak[i] = pieces[i].peak_speed();
  }
  ends_.push_back(end);
}

/// Motors that are asked for more than they have lose steps, and no sensor tells.
std::optional<Error> ArmLinkDriver::too_harsh(const JointMove& move) const {
  constexpr double kJerkedMost = 0.1;  // s
  const double seconds = to_seconds(move.duration);
  if (seconds < kMs) return Error{ErrorCode::kSegmentTime, -1, seconds, kMs};
  for (std::size_t i = 0; i < kJoints && i < move.q.size() && i < move.qd.size(); ++i) {
    // The cubic accelerates by change / T -+ 6 aside / T^2 at its ends. It may lie beside the
    // smooth motion that it is a piece of by what its jerk explains, and half a step beside that.
    const double change = move.qd[i] - target_[i].qd;
    const double aside = move.q[i] - target_[i].q - seconds * (target_[i].qd + move.qd[i]) / 2;
    const double jerked = joints_[i].jerk_max * std::min(seconds, kJerkedMost) / 2;
    const double most = 1.5 * joints_[i].acceleration_max + jerked;
    const double aside_most = most * seconds * seconds / 6 + device_.resolution(i) / 2;
    const double share =
        std::max(std::abs(change) / (most * seconds), std::abs(aside) / aside_most);
    if (!(share > 1)) continue;  // what is no number is refused below
    return Error{ErrorCode::kAccelerationLimit, static_cast<std::int8_t>(i), share, 1};
  }
  return std::nullopt;
}

void ArmLinkDriver::begin_motion() {
  activity_ = Activity::kMoving;
  rest_ = shown_;
  stream_ = {};
  made_ms_ = sent_ms_ = 0;
  pieces_.clear();
  ends_.clear();
  goes_on_until_.reset();
  poll_due_ = now_;
}

Expected<void> ArmLinkDriver::nudge(std::size_t joint, double way, Duration duration, Instant now) {
  SINEW_ASSERT(joint < kJoints);
  poll(now);
  if (const auto may = may_begin(); !may) return may;
  const double steps = std::round(way * device_.arm.joints[joint].steps_per_rad);
  // Written so that NaN is refused too.
  if (!(std::abs(steps) >= 1 && std::abs(way) <= BigRobotArmDevice::kNudgeMax) || !facts_.state) {
    return std::unexpected(Error{ErrorCode::kNudgeRange, static_cast<std::int8_t>(joint), way,
                                 BigRobotArmDevice::kNudgeMax});
  }
  // As the joint may at most: a cubic's peak speed is 1.5 times its mean, and it begins with 6 way
  // / T^2.
  const double least = 1.5 * std::abs(way) / joints_[joint].velocity_max;
  const double gentle = std::sqrt(6 * std::abs(way) / joints_[joint].acceleration_max);
  const double seconds = std::max({to_seconds(duration), least, gentle, 0.05});
  const double from = words_of(facts_.state->what)[joint] * kUnits;
  begin_motion();
  nudge_ = Nudge{joint, Cubic({from, 0}, {from + steps * kUnits, 0}, seconds)};
  rests_ = true;
  stream_ = from_seconds(seconds);
  std::array<Cubic, kJoints> pieces;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double to = shown_[i].q + (i == joint ? way : 0);
    pieces[i] = Cubic({shown_[i].q, 0}, {to, 0}, seconds);
    target_[i] = {to, 0};
  }
  add_end(stream_, pieces);
  commands_.accept();
  Words end = belief_.steps();
  end[joint] += static_cast<std::int32_t>(steps);
  belief_.go(end);
  make_pieces();
  poll(now);
  return {};
}

Expected<void> ArmLinkDriver::tool(const ToolAction& action, Instant now) {
  poll(now);
  const auto* gripper = std::get_if<GripperTo>(&action);
  if (gripper == nullptr) return std::unexpected(Error{ErrorCode::kToolNotFitted});
  if (const auto may = may_begin(); !may) return may;
  const double before = facts_.state ? facts_.state->what.gripper / kServoUnits : 0;
  const double degrees = gripper->angle ? to_deg(*gripper->angle) : before;
  if (gripper->angle && !(degrees >= -0.5 && degrees <= device_.arm.gripper_max + 0.5)) {
    return std::unexpected(
        Error{ErrorCode::kGripperRange, -1, degrees, 1.0 * device_.arm.gripper_max});
  }
  ask(Kind::kGripper);
  due_->gripper_on = gripper->enabled;
  due_->gripper = static_cast<std::uint16_t>(std::lround(std::max(0.0, degrees) * kServoUnits));
  return begin_asking(now);
}

Expected<void> ArmLinkDriver::zero_counters(Instant now) {
  poll(now);
  if (const auto may = may_begin(); !may) return may;
  ask(Kind::kPositions);
  return begin_asking(now);
}

Expected<void> ArmLinkDriver::clear_fault(Instant now) {
  poll(now);
  if (!fault_) return {};
  if (activity_ != Activity::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  ask(Kind::kRelease);
  clearing_ = true;
  return begin_asking(now);
}

void ArmLinkDriver::ask(Kind kind) {
  due_.emplace();
  due_->kind = kind;
  asks_left_ = kAsksMax;
}

/// A command that is what was asked for last.
Expected<void> ArmLinkDriver::begin_asking(Instant now) {
  activity_ = Activity::kAsking;
  commands_.accept();
  poll(now);
  return {};
}

/// What was not carried out, since its number was not the next one, is asked again.
bool ArmLinkDriver::asked_again(const Channel::Answered& answered) {
  if (Channel::carried_out(answered) || asks_left_ == 0) return false;
  --asks_left_;
  due_ = answered.request;
  return true;
}

void ArmLinkDriver::stop(Instant now) {
  poll(now);
  const bool dead = activity_ == Activity::kOpening && told_silent_;
  if (activity_ == Activity::kClosed || activity_ == Activity::kIdle || dead) {
    return commands_.tell_stopped();
  }
  commands_.ask_stop();
  if (activity_ != Activity::kMoving) return;
  stop_due_ = true;
  begin_stop();
  // It does not wait for a reply that may be lost.
  channel_.abandon();
  poll(now);
}

void ArmLinkDriver::begin_stop() {
  show();
  stop_reach_ = reach();
  activity_ = Activity::kStopping;
  nudge_.reset();
  queue_.clear();
  pieces_.clear();
  ends_.clear();
  due_.reset();
}

void ArmLinkDriver::declare_positions(std::span<const JointPosition> positions) {
  if (activity_ == Activity::kMoving || activity_ == Activity::kStopping) return;
  left_.reset();
  belief_.declare(positions);
  show();
}

// The board

void ArmLinkDriver::receive(std::span<const std::uint8_t> bytes, Instant now) {
  if (activity_ == Activity::kClosed) return;
  now_ = std::max(now_, now);
  for (const std::uint8_t byte : bytes) {
    channel_.receive({&byte, 1}, now_);
    if (const auto answered = channel_.take_answer()) take(*answered, now_);
  }
  poll(now);
}

void ArmLinkDriver::take(const Channel::Answered& answered, Instant now) {
  const Reply& reply = answered.reply;
  if (reply.session != channel_.session() || reply.session == 0) {
    // The board has started again, or another host has it.
    const bool restarted = reply.reference == Reference::kKept ||
                           reply.reference == Reference::kKeptMoving ||
                           reply.fault == Fault::kRestart;
    // Who else may have had it counts in a frame of his own.
    if (!restarted && reply.fault != Fault::kHostSilent) belief_.reopen();
    const Error why = restarted                           ? Error{ErrorCode::kDeviceRestarted}
                      : reply.fault == Fault::kHostSilent ? Error{ErrorCode::kLinkSilent}
                                                          : Error{ErrorCode::kForeignMotion};
    return begin_anew(why, now);
  }
  if (reply.kind == Kind::kIdentity || reply.kind == Kind::kStatistics) return take_facts(reply);
  facts_.state = {reply, answered.asked};
  switch (activity_) {
    case Activity::kOpening:
      take_opening(answered);
      break;
    case Activity::kMoving:
      take_motion(answered);
      break;
    case Activity::kAsking:
      take_asking(answered);
      break;
    case Activity::kStopping:
      take_stopping(answered);
      break;
    case Activity::kIdle:
      if (reply.fault != Fault::kNone && !fault_) {
        fault_ = error_of(reply.fault);
        commands_.tell(Event::kNotice, *fault_);
      }
      break;
    case Activity::kClosed:
      break;
  }
  show();
}

/// What a board says beside its state.
void ArmLinkDriver::take_facts(const Reply& reply) {
  if (reply.kind == Kind::kStatistics) {
    facts_.statistics = {reply, now_};
    return;
  }
  ImageIdentity bytes{};
  std::copy_n(reply.identity, bytes.size(), bytes.begin());
  if (const auto image = decode_identity(bytes)) facts_.image = {*image, now_};
}

void ArmLinkDriver::take_motion(const Channel::Answered& answered) {
  const Reply& reply = answered.reply;
  if (answered.request.kind == Kind::kSegment && Channel::carried_out(answered)) {
    sent_ms_ += pieces_[0].ms;
    pieces_.drop_front(1);
    make_pieces();
  }
  if (reply.fault != Fault::kNone) {
    const Error why = error_of(reply.fault);
    commands_.fail(why);
    if (reply.fault == Fault::kStopLine) fault_ = why;
    return begin_stop();
  }
  const int executed = sent_ms_ - reply.queued_ms;
  while (ends_.size() > (rests_ ? 1 : 0) && ends_[0].at <= Milliseconds(executed)) {
    ends_.drop_front(1);
    commands_.done();
  }
  const bool all_sent = pieces_.empty() && queue_.empty() && sent_ms_ == made_ms_;
  if (!rests_ || !all_sent || reply.moving || reply.queued_ms > 0) return;
  come_to_rest(reply);
  for (; !ends_.empty(); ends_.drop_front(1)) commands_.done();
  activity_ = Activity::kIdle;
}

void ArmLinkDriver::take_asking(const Channel::Answered& answered) {
  if (due_ || answered.request.kind == Kind::kRead || asked_again(answered)) return;
  const bool done = Channel::carried_out(answered);
  const bool zeroed = answered.request.kind == Kind::kPositions;
  const auto& counted = answered.reply.positions;
  activity_ = Activity::kIdle;
  std::optional<Error> why;
  if (!done || (zeroed && !std::equal(std::begin(counted), std::end(counted),
                                      std::begin(answered.request.positions)))) {
    why = Error{ErrorCode::kDeviceRefused};
  } else if (zeroed) {
    belief_.zero();
    say_due_.reset();
  }
  if (std::exchange(clearing_, false)) {
    const Fault fault = answered.reply.fault;
    fault_ = fault == Fault::kNone ? std::nullopt : std::optional(error_of(fault));
    why = fault_;
  }
  if (why) {
    commands_.fail(*why);
  } else {
    commands_.done();
  }
  commands_.end_stop();
}

void ArmLinkDriver::take_stopping(const Channel::Answered& answered) {
  const Reply& reply = answered.reply;
  if (stop_due_ || due_ || reply.moving || reply.queued_ms > 0) return;
  const bool released = answered.request.kind == Kind::kRelease;
  // What the stop line has stopped is released by people.
  if (reply.fault == Fault::kStopLine) fault_ = error_of(reply.fault);
  if (reply.fault != Fault::kNone && !fault_ && !released) return ask(Kind::kRelease);
  if (released && asked_again(answered)) return;
  come_to_rest(reply);
  activity_ = Activity::kIdle;
  commands_.end_stop();
}

/// The counters say where: every pulse that was planned is made.
void ArmLinkDriver::come_to_rest(const Reply& reply) {
  belief_.go(words_of(reply));
  belief_.arrive();
  nudge_.reset();
}

void ArmLinkDriver::poll(Instant now) {
  now_ = std::max(now_, now);
  if (activity_ == Activity::kClosed) return;
  channel_.poll(now_);
  if (channel_.silent()) {
    if (activity_ != Activity::kOpening) {
      const double waited = to_seconds(timing_.wire.reply) * timing_.wire.tries;
      return begin_anew({ErrorCode::kDeviceSilent, -1, waited, waited}, now_);
    }
    channel_.reset();
    step_ = Step::kHello;
    due_.reset();
    poll_due_ = now_;
  }
  if (activity_ == Activity::kOpening && !told_silent_ &&
      now_ - opened_at_ >= timing_.opening_limit) {
    told_silent_ = true;
    const double limit = to_seconds(timing_.opening_limit);
    commands_.tell(Event::kFailed, {ErrorCode::kDeviceSilent, -1, limit, limit});
    commands_.end_stop();
  }
  if (!channel_.busy()) ask_next(now_);
  show();
}

/// What is most urgent goes first; where there is nothing, the state is asked for now and then,
/// which also keeps the board's deadline away.
void ArmLinkDriver::ask_next(Instant now) {
  const bool moving = activity_ == Activity::kMoving || activity_ == Activity::kStopping;
  const Duration period = moving ? timing_.moving_poll : timing_.resting_poll;
  if (stop_due_) {
    stop_due_ = false;
    Request request{};
    request.kind = Kind::kStop;
    channel_.send(request, now);
  } else if (activity_ == Activity::kOpening && step_ == Step::kHello) {
    if (now < poll_due_) return;
    say_hello(now);
  } else if (due_) {
    channel_.send(*std::exchange(due_, std::nullopt), now);
  } else if (facts_.state && say_due_ &&
             ((activity_ == Activity::kMoving && sent_ms_ == 0) ||
              (activity_ == Activity::kIdle && now >= *say_due_))) {
    say_due_.reset();
    Request request{};
    request.kind = Kind::kPositions;
    std::ranges::copy(facts_.state->what.positions, std::begin(request.positions));
    channel_.send(request, now);
  } else if (activity_ == Activity::kMoving && !pieces_.empty() &&
             (!facts_.state || facts_.state->what.queue_room > 0)) {
    Request request{};
    request.kind = Kind::kSegment;
    request.segment = pieces_[0];
    channel_.send(request, now);
  } else {
    if (now < poll_due_) return;
    Request request{};
    request.kind = Kind::kRead;
    if (activity_ == Activity::kIdle && now >= statistics_due_) {
      request.kind = Kind::kStatistics;
      statistics_due_ = now + timing_.statistics;
    }
    channel_.send(request, now);
  }
  poll_due_ = now + period;
}

std::optional<Instant> ArmLinkDriver::next_deadline() const {
  if (activity_ == Activity::kClosed) return std::nullopt;
  std::optional<Instant> next = channel_.busy() ? channel_.next_deadline() : poll_due_;
  if (activity_ == Activity::kOpening && !told_silent_) {
    const Instant limit = opened_at_ + timing_.opening_limit;
    next = next ? std::min(*next, limit) : limit;
  }
  return next;
}

/// Pieces of whole milliseconds out of what was asked for: of 20 to 39 ms, or of 40 where the wire
/// is slow and much waits. What is left of a stream waits for more.
void ArmLinkDriver::make_pieces() {
  const auto whole = std::chrono::floor<Milliseconds>(stream_);
  const int limit = static_cast<int>((whole < stream_ && rests_ ? whole + Milliseconds(1) : whole) /
                                     Milliseconds(1));
  while (!pieces_.full() && made_ms_ < limit) {
    const int left = limit - made_ms_;
    if (!rests_ && left < kPieceMs && !queue_.full() && !ends_.full()) return;
    const int slow = left >= 4 * kPieceMs ? 2 * kPieceMs : kPieceMs;
    const int ms = left < 2 * kPieceMs ? left : slow;
    const bool last = rests_ && ms == left;
    pieces_.push_back(piece_to(made_ms_ + ms, last));
    pieces_.back().ms = static_cast<std::uint8_t>(ms);
    made_ms_ += ms;
    while (!queue_.empty() && queue_.front().end <= Instant{} + Milliseconds(made_ms_)) {
      queue_.pop_front();
    }
  }
  if (rests_ && made_ms_ >= limit) queue_.clear();
}

/// @param last  of a motion that ends at rest: on a whole step
mcu::ArmSegment ArmLinkDriver::piece_to(int ms, bool last) const {
  mcu::ArmSegment piece{};
  piece.gripper = mcu::kGripperStays;
  for (std::size_t i = 0; i < kJoints; ++i) {
    double units = 0;
    double speed = 0;  // units per s
    if (nudge_) {
      units = words_of(facts_.state->what)[i] * kUnits;
      if (i == nudge_->joint) {
        const Cubic::State at = nudge_->way.at(ms * kMs);
        units = at.q;
        speed = at.qd;
      }
    } else {
      const segments::Setpoint at = queue_.at(i, Instant{} + Milliseconds(ms));
      units = units_of(i, at.q);
      speed = at.qd * device_.arm.joints[i].steps_per_rad * kUnits;
    }
    if (last) units = std::round(units / kUnits) * kUnits;
    piece.targets[i] = static_cast<std::int32_t>(std::lround(units));
    const double per_ms = speed / kUnits * kMs * mcu::kSpeedsPerStepPerMs;
    piece.velocities[i] = static_cast<std::int16_t>(std::lround(last ? 0 : per_ms));
  }
  return piece;
}

void ArmLinkDriver::show() {
  const bool moving = activity_ == Activity::kMoving || activity_ == Activity::kStopping;
  if (left_) {
    shown_ = *left_;
    return;
  }
  if (!moving || !facts_.state || belief_.unknown()) return belief_.show(1, shown_);
  // Between where its pulses were planned to when it was asked last, and the ends of what it was
  // sent; a stop leads it on from there.
  const bool stopping = activity_ == Activity::kStopping;
  // The board plans a slice ahead.
  const double age = to_seconds(now_ - facts_.state->at + Milliseconds(2));
  // Its queue may have run empty: then it has gone on beyond, and brakes.
  const Reply& state = facts_.state->what;
  const bool waits = !state.moving && state.queued_ms == 0;
  const double queued = waits ? 50 * kMs : state.queued_ms * kMs;
  const double beyond = rests_ && pieces_.empty() ? 0 : std::max(0.0, age - queued);
  for (std::size_t i = 0; i < kJoints; ++i) {
    JointPosition& joint = shown_[i];
    const double here = angle_of(i, facts_.state->what.positions[i]);
    const double gone = joints_[i].velocity_max * age;
    const double past = stopping ? gone : joints_[i].velocity_max * beyond;
    double low = here - past;
    double high = here + past;
    for (const End& end : ends_) {
      low = std::min(low, std::max(end.way[i].lower - past, here - gone));
      high = std::max(high, std::min(end.way[i].upper + past, here + gone));
    }
    joint.quality = rest_[i].quality;
    joint.q = here;
    joint.lower = low - (rest_[i].q - rest_[i].lower);
    joint.upper = high + (rest_[i].upper - rest_[i].q);
    joint.under_way = true;
  }
}

}  // namespace sinew
