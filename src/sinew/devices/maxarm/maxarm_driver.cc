#include "sinew/devices/maxarm/maxarm_driver.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew {

using namespace maxarm;
using namespace std::chrono_literals;

namespace {

constexpr std::int32_t kMargin = 10;       // pulses: overshoot and sag beside the way
constexpr std::int32_t kRangeMargin = 25;  // pulses: an arm without power leans on its ends
constexpr double kRounding = 0.5;          // pulses
constexpr double kCreep = 1;               // pulses between two readings of an arm at rest
constexpr double kCreepAgain = 4;          // times what it crept between the last two
constexpr double kSentBeside = 1.5;        // pulses: rounding, and a sturdier frame's neighbour
constexpr int kZeros = 16;
constexpr int kSetsMax = 3;
constexpr int kSuctionFrames = 2;
constexpr int kStrangersMax = 3;
constexpr int kSilentTold = 3;
constexpr int kNeverRests = 4;     ///< times `settle`; an arm that swings so long is not done
constexpr int kOtherEndReads = 3;  ///< equal readings off the target before the move is given up
// The document's scale of the nozzle's servo: 0 to 180 deg are 500 to 2500 us.
constexpr double kZeroUs = 500;
constexpr double kUsPerRad = 2000 / kPi;
constexpr std::int16_t kDeadServo = -1;

Error joint_error(ErrorCode code, std::size_t joint, double measured, double limit) {
  return {code, static_cast<std::int8_t>(joint), measured, limit};
}

/// A servo's sensor reads somewhat beyond its 240 degrees, and no farther.
bool plausible(const Angles& angles) {
  return std::ranges::all_of(angles.pulses, [](std::int16_t p) { return p >= -60 && p <= 1060; });
}

Duration wire_time(const Request& request) {
  constexpr Duration kByteTime = MaxArmTiming().byte_time;
  return static_cast<int>(encode_request(request).size()) * kByteTime;
}

bool sturdy(const Request& request) {
  const FrameBytes frame = encode_request(request);
  return survives_one_fault(frame) && survives_a_look(frame);
}

}  // namespace

Duration MaxArmDevice::tool_time(const RobotModel& /*robot*/, const ToolAction& action,
                                 std::optional<double> /*jaws*/) const {
  const Duration gap = MaxArmTiming().frame_gap;
  const Duration one_reading = pace_of(variant).one_reading;
  if (std::holds_alternative<Suction>(action)) {
    return kSuctionFrames * (wire_time(SetSuction{}) + gap) + one_reading;
  }
  if (const auto* nozzle = std::get_if<NozzleTo>(&action)) {
    return wire_time(SetPwmServo{}) + gap + nozzle->duration + one_reading;
  }
  return {};
}

MaxArmDriver::MaxArmDriver(const MaxArmDevice& device, std::span<const Joint> joints,
                           const MaxArmTiming& timing)
    : device_(device), joints_(joints), timing_(timing), pace_(pace_of(device.variant)) {
  SINEW_ASSERT(joints.size() == kServos);
  for (const MaxArmServo& servo : device.servos) SINEW_ASSERT(servo.pulses_per_rad != 0);
}

void MaxArmDriver::open(Instant now) {
  if (phase_ != Phase::kClosed) close(now);
  fault_.reset();
  decoder_.reset();
  output_.clear();
  checksum_votes_ = 0;
  strangers_ = 0;
  silent_ = 0;
  free_at_ = now;
  in_doubt_ = false;
  answered_at_.reset();
  left_at_.reset();
  doubt(now);
}

void MaxArmDriver::close(Instant /*now*/) {
  if (phase_ == Phase::kClosed) return;
  output_.clear();
  phase_ = Phase::kClosed;
  ready_ = false;
  show_doubt();
  if (job_ != Job::kNone) {
    finish(DriverEvent::Kind::kFailed, {ErrorCode::kPortClosed});
  } else {
    tell(DriverEvent::Kind::kNotice, {ErrorCode::kPortClosed});
  }
}

DriverState MaxArmDriver::state() const {
  if (phase_ == Phase::kClosed) return DriverState::kClosed;
  if (phase_ == Phase::kFault) return DriverState::kFault;
  if (job_ == Job::kStop) return DriverState::kStopping;
  if (job_ == Job::kMove || job_ == Job::kTool) return DriverState::kMoving;
  return ready_ ? DriverState::kReady : DriverState::kOpening;
}

std::optional<Instant> MaxArmDriver::goes_on_until() const {
  if (job_ != Job::kStop) return std::nullopt;
  const Instant settled = moves_until_ + kNeverRests * timing_.settle;
  return in_doubt_ ? std::max(settled, doubt_since_ + timing_.patience) : settled;
}

bool MaxArmDriver::wants_move(Instant /*now*/) const {
  return state() == DriverState::kReady && rests();
}

Expected<void> MaxArmDriver::move(const JointMove& move, Instant now) {
  if (fault_) return std::unexpected(*fault_);
  if (state() != DriverState::kReady) return std::unexpected(Error{ErrorCode::kBusy});
  const auto target = maxarm_pulses(device_, joints_, move.q, positions());
  if (!target) return std::unexpected(target.error());
  for (std::size_t i = 0; i < kServos; ++i) {
    if (positions_[i].quality == PositionQuality::kMeasured) continue;
    return std::unexpected(joint_error(ErrorCode::kPositionUnknown, i, 0, 0));
  }
  if (const auto moved = moved_from(move.q_start)) return std::unexpected(*moved);
  const double seconds = to_seconds(move.duration);
  double shortest = kMaxArmTimeMin * 1e-3;
  for (std::size_t i = 0; i < kServos; ++i) {
    // A pulse of rounding at either end is not the planner's fault.
    const double pulses = std::max(std::abs((*target)[i] - reading_[i]) - 2, 0);
    const double way = pulses / std::abs(device_.servos[i].pulses_per_rad);
    shortest = std::max(shortest, way / joints_[i].velocity_max);
  }
  constexpr double kSlack = 1e-6;
  if (!(seconds >= shortest * (1 - kSlack) && seconds <= kMaxArmTimeMax * 1e-3)) {
    const double limit = seconds < shortest ? shortest : kMaxArmTimeMax * 1e-3;
    return std::unexpected(Error{ErrorCode::kSegmentTime, -1, seconds, limit});
  }
  job_ = Job::kMove;
  target_ = *target;
  time_ms_ = static_cast<std::int32_t>(std::ceil(seconds * 1e3 - kSlack));
  sets_ = 0;
  begun_at_.reset();
  // A question that is out is waited for; else the move can go at once.
  if (phase_ == Phase::kPausing) pause(Duration::zero(), now);
  return {};
}

/// Whether the arm stands elsewhere than a move was planned from, by more than servos rest beside
/// their target.
std::optional<Error> MaxArmDriver::moved_from(const JointVector& q) const {
  if (q.size() != kServos) return std::nullopt;
  for (std::size_t i = 0; i < kServos; ++i) {
    const double pulse = device_.servos[i].offset + device_.servos[i].pulses_per_rad * q[i];
    if (std::abs(reading_[i] - pulse) <= timing_.reached + kSentBeside) continue;
    return joint_error(ErrorCode::kMovedUnasked, i, angle_of(i, reading_[i]), q[i]);
  }
  return std::nullopt;
}

void MaxArmDriver::stop(Instant now) {
  if (job_ == Job::kStop) return;
  const bool nothing_moves = phase_ == Phase::kClosed || phase_ == Phase::kFault ||
                             job_ == Job::kNone || (job_ == Job::kMove && sets_ == 0);
  if (nothing_moves) return finish(DriverEvent::Kind::kStopped);
  tool_frames_ = 0;
  const bool tooling = job_ == Job::kTool;
  job_ = Job::kStop;
  // An arm that a tool action held still needs no SET; the nozzle's own turn cannot be cut short.
  if (tooling) return;
  sets_ = 0;
  alike_ = 0;  // only a reading from now on counts
  if (phase_ == Phase::kPausing) pause(Duration::zero(), now);
}

Expected<void> MaxArmDriver::clear_fault(Instant now) {
  if (phase_ != Phase::kFault) return {};
  fault_.reset();
  in_doubt_ = false;
  doubt(now);
  return {};
}

Expected<void> MaxArmDriver::tool(const ToolAction& action, Instant now) {
  if (fault_) return std::unexpected(*fault_);
  const auto* suction = std::get_if<Suction>(&action);
  const auto* nozzle = std::get_if<NozzleTo>(&action);
  if (suction == nullptr && nozzle == nullptr) {
    return std::unexpected(Error{ErrorCode::kToolNotFitted});
  }
  if (state() != DriverState::kReady) return std::unexpected(Error{ErrorCode::kBusy});
  if (suction != nullptr) {
    constexpr std::array<std::uint8_t, 3> kActions{1, 2, 3};  // on, release, off
    tool_request_ = SetSuction{kActions.at(static_cast<std::size_t>(suction->state))};
    tool_time_ = Duration::zero();
    tool_frames_ = kSuctionFrames;
  } else {
    const double us = std::round(kZeroUs + kUsPerRad * nozzle->angle);
    if (!(us >= 500 && us <= 2500)) {
      return std::unexpected(Error{ErrorCode::kGripperRange, -1, us, us < 500 ? 500.0 : 2500.0});
    }
    const double ms = std::ceil(to_seconds(nozzle->duration) * 1e3 - 1e-6);
    if (!(ms >= kMaxArmTimeMin && ms <= kMaxArmTimeMax)) {
      return std::unexpected(Error{ErrorCode::kSegmentTime, -1, ms * 1e-3,
                                   (ms < kMaxArmTimeMin ? kMaxArmTimeMin : kMaxArmTimeMax) * 1e-3});
    }
    SetPwmServo pwm{static_cast<std::uint16_t>(us), static_cast<std::uint16_t>(ms)};
    for (int i = 0; i < 32 && !sturdy(pwm); ++i) ++pwm.time_ms;
    tool_request_ = pwm;
    tool_time_ = std::chrono::milliseconds(pwm.time_ms);
    tool_frames_ = 1;
  }
  job_ = Job::kTool;
  if (phase_ == Phase::kPausing) pause(Duration::zero(), now);
  return {};
}

void MaxArmDriver::poll(Instant now) {
  if (phase_ == Phase::kClosed || phase_ == Phase::kFault || now < due_) return;
  switch (phase_) {
    case Phase::kQuiet:
      if (now - doubt_since_ > timing_.patience)
        return give_up({ErrorCode::kDeviceSilent, -1, to_seconds(now - doubt_since_),
                        to_seconds(timing_.patience)});
      if (silent_ == 0 || !output_.empty()) return ask(ReadXyz{}, Phase::kMarking, now);
      // A MicroPython board may wait for the rest of a frame: zeros end it, and mean nothing else.
      for (int i = 0; i < kZeros; ++i) output_.push_back(0);
      phase_ = Phase::kWaking;
      free_at_ = now + kZeros * timing_.byte_time + timing_.wake;
      due_ = free_at_;
      return;
    case Phase::kWaking:
      return ask(ReadXyz{}, Phase::kMarking, now);
    case Phase::kPausing:
      return go_on(now);
    case Phase::kTooling:
      return go_on_with_tool(now);
    case Phase::kMarking:
    case Phase::kReading: {
      ++health_.timeouts;
      ++silent_;
      const Error silent{ErrorCode::kDeviceSilent, -1, to_seconds(now - asked_at_),
                         to_seconds(timing_.reply_timeout)};
      if (silent_ == kSilentTold && job_ == Job::kNone) tell(DriverEvent::Kind::kNotice, silent);
      return doubt(now);
    }
    case Phase::kClosed:
    case Phase::kFault:
      return;
  }
}

/// Back to silence, with what the host knows of the arm forgotten.
void MaxArmDriver::doubt(Instant now) {
  if (!in_doubt_) doubt_since_ = now;
  in_doubt_ = true;
  ready_ = false;
  alike_ = 0;
  show_doubt();
  if (now - doubt_since_ > timing_.patience) {
    return give_up({ErrorCode::kDeviceSilent, -1, to_seconds(now - doubt_since_),
                    to_seconds(timing_.patience)});
  }
  if (silent_ > 0) ++health_.retries;
  phase_ = Phase::kQuiet;
  due_ = std::max(now + timing_.quiet, free_at_);
}

void MaxArmDriver::give_up(const Error& error) {
  phase_ = Phase::kFault;
  ready_ = false;
  fault_ = error;
  silent_ = 0;
  finish(DriverEvent::Kind::kFailed, error);
}

void MaxArmDriver::finish(DriverEvent::Kind kind, const Error& error) {
  if (job_ == Job::kMove || job_ == Job::kStop) left_at_.reset();
  if (!left_at_ && rests()) left_at_ = reading_;
  job_ = Job::kNone;
  sets_ = 0;
  tool_frames_ = 0;
  tell(kind, error);
}

void MaxArmDriver::tell(DriverEvent::Kind kind, const Error& error) {
  // Commands are one at a time, so only news that nobody takes can fill the queue.
  if (events_.full() && kind == DriverEvent::Kind::kNotice) return;
  if (events_.full()) (void)take_event();
  events_.push_back({kind, error});
}

void MaxArmDriver::send(const Request& request, Instant now) {
  const FrameBytes frame = encode_request(request);
  for (const std::uint8_t byte : frame) output_.push_back(byte);
  free_at_ = now + static_cast<int>(frame.size()) * timing_.byte_time + timing_.frame_gap;
}

void MaxArmDriver::ask(const Request& question, Phase phase, Instant now) {
  if (now < free_at_ || !output_.empty()) {
    // The port has not taken the last frame; nothing is stacked behind it.
    due_ = std::max(free_at_, now + timing_.frame_gap);
    return;
  }
  ++health_.requests;
  send(question, now);
  decoder_.reset();
  phase_ = phase;
  asked_at_ = now;
  due_ = free_at_ + timing_.reply_timeout;
}

void MaxArmDriver::pause(Duration duration, Instant now) {
  phase_ = Phase::kPausing;
  due_ = std::max(now + duration, free_at_);
}

void MaxArmDriver::receive(std::span<const std::uint8_t> bytes, Instant now) {
  if (phase_ == Phase::kClosed) return;
  // What was due before these bytes came is late, whoever called first.
  if (now > due_) poll(now);
  for (const std::uint8_t byte : bytes) {
    if (phase_ == Phase::kQuiet || phase_ == Phase::kWaking || phase_ == Phase::kFault) {
      ++health_.unexpected;
      if (phase_ == Phase::kQuiet && now - doubt_since_ <= timing_.patience) {
        due_ = std::max(due_, now + timing_.quiet);
      }
      continue;
    }
    const auto frame = decoder_.push(byte);
    health_.unexpected += decoder_.skipped() - skipped_;
    skipped_ = decoder_.skipped();
    if (!frame) continue;
    if (!trusted(*frame)) continue;
    answered_at_ = now - static_cast<int>(kReplyFrame) * timing_.byte_time;
    const auto* angles = std::get_if<Angles>(&frame->reply);
    if (angles != nullptr) {
      facts_.angles = {*angles, now};
    } else {
      facts_.position = {std::get<Position>(frame->reply), now};
    }
    if (phase_ == Phase::kMarking && angles == nullptr) {
      pause(Duration::zero(), now);
      silent_ = 0;
      alike_ = 0;
    } else if (phase_ == Phase::kReading && angles != nullptr && !plausible(*angles)) {
      ++health_.unexpected;
      doubt(now);
    } else if (phase_ == Phase::kReading && angles != nullptr) {
      take_reading(*angles, now);
    } else {
      ++health_.unexpected;  // of an older question: it says nothing about now
    }
  }
}

/// The two sums differ by one, so that a host which takes both at any time would take one bit in
/// 8 for nothing. Two answers settle which one it is; the other is then noise, until it is all
/// that comes.
bool MaxArmDriver::trusted(const ReplyFrame& frame) {
  if (checksum_votes_ > 0 && frame.checksum == checksum_) {
    strangers_ = 0;
    checksum_votes_ = 2;
    return true;
  }
  if (checksum_votes_ == 0) {
    checksum_ = frame.checksum;
    checksum_votes_ = 1;
    // A marker says nothing, so it may be believed already.
    return std::holds_alternative<Position>(frame.reply);
  }
  ++health_.unexpected;
  ++strangers_;
  if (checksum_votes_ < 2 || strangers_ >= kStrangersMax) {
    if (checksum_votes_ == 2) {
      tell(DriverEvent::Kind::kNotice, {ErrorCode::kChecksum, -1, 1.0 * strangers_});
    }
    checksum_ = frame.checksum;
    checksum_votes_ = 1;
    strangers_ = 0;
  }
  return false;
}

DeviceFacts MaxArmDriver::facts() const {
  MaxArmFacts facts = facts_;
  facts.checksum = checksum();
  return DeviceFacts(facts);
}

std::optional<Checksum> MaxArmDriver::checksum() const {
  if (checksum_votes_ < 2) return std::nullopt;
  return checksum_;
}

void MaxArmDriver::take_reading(const Angles& angles, Instant now) {
  silent_ = 0;
  for (std::size_t i = 0; i < kServos; ++i) {
    if (angles.pulses[i] != kDeadServo) continue;
    show_measured();
    show(i, PositionQuality::kLost, 0, 0);
    return give_up(joint_error(ErrorCode::kEncoderLost, i, 0, 0));
  }
  if (job_ != Job::kNone) in_doubt_ = false;
  previous_ = reading_;
  for (std::size_t i = 0; i < kServos; ++i) reading_[i] = angles.pulses[i];
  alike_ = alike_ > 0 && near(reading_, previous_, 1) ? alike_ + 1 : 1;
  // While the servos' ramps may still run, standing still says nothing.
  if (sets_ > 0 && asked_at_ < moves_until_) alike_ = 0;
  go_on(now);
}

/// A reading came, or a pause is over.
void MaxArmDriver::go_on(Instant now) {
  if (now < free_at_ || !output_.empty()) return pause(timing_.frame_gap, now);
  const bool knows = job_ == Job::kMove && sets_ > 0 ? arrived() : rests() && sets_ == 0;
  if (phase_ == Phase::kPausing && (!knows || job_ == Job::kNone)) {
    return ask(ReadAngle{}, Phase::kReading, now);
  }
  if (!ready_ && rests()) {
    ready_ = true;
    in_doubt_ = false;
    if (job_ == Job::kNone) tell(DriverEvent::Kind::kReady);
  }
  if (!ready_ && job_ == Job::kNone && now - doubt_since_ > timing_.patience) {
    return give_up({ErrorCode::kPositionUnknown, 0});
  }
  switch (job_) {
    case Job::kMove:
      return go_on_with_move(now);
    case Job::kStop:
      return go_on_with_stop(now);
    case Job::kTool:
      return go_on_with_tool(now);
    case Job::kNone:
      return rest_idle(now);
  }
}

void MaxArmDriver::go_on_with_move(Instant now) {
  if (sets_ == 0) {
    if (!rests()) return pause(timing_.read_period, now);
    start_ = reading_;
    way_low_ = reading_;
    way_high_ = reading_;
    return begin_move(now);
  }
  if (arrived()) {
    show_measured();
    if (now < told_at_) return pause(told_at_ - now, now);
    finish(DriverEvent::Kind::kDone);
    return pause(timing_.idle_first, now);
  }
  show_way();
  const bool stuck = alike_ >= kOtherEndReads;
  if (stuck && sets_ < kSetsMax && near(reading_, start_, 2)) {
    ++health_.retries;
    return begin_move(now);
  }
  const Duration late = now - moves_until_;
  if ((stuck && late > timing_.settle) || late > kNeverRests * timing_.settle) {
    const std::size_t joint = farthest(target_);
    if (rests()) show_measured();
    finish(DriverEvent::Kind::kFailed,
           joint_error(ErrorCode::kMissedTarget, joint, angle_of(joint, reading_[joint]),
                       angle_of(joint, target_[joint])));
    return pause(timing_.read_period, now);
  }
  pause(next_reading(now + timing_.read_period) - now, now);
}

/// Sends the SET clear of the board's looks, to end when it was said to.
void MaxArmDriver::begin_move(Instant now) {
  if (sets_ > 0 || !begun_at_) begun_at_ = now;
  if (knows_looks()) {
    const Instant look = look_behind(now - kMaxArmLookDoubt);
    const Instant in = now + wire_time(SetAngle{});
    if (look < in + kMaxArmLookDoubt) return pause(look + kMaxArmLookDoubt - now, now);
  }
  send_set(target_, time_ms_, *begun_at_ + pace_.begins, now);
}

bool MaxArmDriver::arrived() const {
  return sets_ > 0 && rests() && near(reading_, target_, timing_.reached);
}

/// From `earliest` on, but the line is free when the servos have settled.
Instant MaxArmDriver::next_reading(Instant earliest) const {
  if (earliest + pace_.one_reading <= moves_until_) return earliest;
  return std::max(moves_until_, asked_at_ + timing_.read_period);
}

bool MaxArmDriver::knows_looks() const {
  return device_.variant == MaxArmVariant::kMicroPython && answered_at_;
}

/// The board's next look at its port behind that instant: it sleeps from answer to look to look.
Instant MaxArmDriver::look_behind(Instant at) const {
  return *answered_at_ + ((at - *answered_at_) / kMaxArmLookPeriod + 1) * kMaxArmLookPeriod;
}

void MaxArmDriver::go_on_with_stop(Instant now) {
  if (rests()) {
    show_measured();
    finish(DriverEvent::Kind::kStopped);
    return pause(timing_.idle_first, now);
  }
  show_way();
  // Where it was a moment ago: inside the way that it was sent on. Again if that did not hold it.
  const bool goes_on =
      sets_ > 0 && asked_at_ >= moves_until_ && !near(reading_, target_, timing_.reached);
  if (sets_ == 0 || (goes_on && sets_ < kSetsMax)) {
    for (std::size_t i = 0; i < kServos; ++i) {
      target_[i] = std::clamp(reading_[i], kMaxArmPulseMin, kMaxArmPulseMax);
    }
    return send_set(target_, timing_.stop_ms, now, now);
  }
  if (now - moves_until_ > kNeverRests * timing_.settle) {
    const std::size_t joint = farthest(target_);
    return finish(DriverEvent::Kind::kFailed,
                  joint_error(ErrorCode::kMissedTarget, joint, angle_of(joint, reading_[joint]),
                              angle_of(joint, target_[joint]))),
           pause(timing_.read_period, now);
  }
  pause(timing_.read_period, now);
}

void MaxArmDriver::go_on_with_tool(Instant now) {
  if (now < free_at_ || !output_.empty()) {
    due_ = std::max(free_at_, now + timing_.frame_gap);
    phase_ = Phase::kTooling;
    return;
  }
  if (tool_frames_ > 0) {
    --tool_frames_;
    ++health_.requests;
    send(tool_request_, now);
    free_at_ += tool_time_;
    phase_ = Phase::kTooling;
    due_ = free_at_;
    return;
  }
  if (phase_ == Phase::kTooling) {
    told_at_ = now + pace_.one_reading;
    return ask(ReadAngle{}, Phase::kReading, now);
  }
  if (!rests()) return pause(timing_.read_period, now);
  if (now < told_at_) return pause(told_at_ - now, now);
  // The device answers: it lives, and what it was told has reached it as far as anyone can know.
  show_measured();
  tell_if_moved();
  finish(DriverEvent::Kind::kDone);
  pause(timing_.idle_first, now);
}

/// At rest, with nothing under way that could have moved it.
void MaxArmDriver::tell_if_moved() {
  if (left_at_ && !near(reading_, *left_at_, timing_.reached)) {
    const std::size_t joint = farthest(*left_at_);
    tell(DriverEvent::Kind::kNotice,
         joint_error(ErrorCode::kMovedUnasked, joint, angle_of(joint, reading_[joint]),
                     angle_of(joint, (*left_at_)[joint])));
    left_at_.reset();
  }
  if (!left_at_) left_at_ = reading_;
}

void MaxArmDriver::rest_idle(Instant now) {
  if (rests()) {
    show_measured();
    tell_if_moved();
  } else {
    for (std::size_t i = 0; i < kServos; ++i) {
      way_low_[i] = std::min(reading_[i], previous_[i]);
      way_high_[i] = std::max(reading_[i], previous_[i]);
    }
    show_way();
  }
  const bool idle = rests() && ready_;
  pause(asked_at_ + (idle ? pace_.idle : timing_.read_period) - now, now);
}

/// @param begins  when its ramp is taken to begin, or when the board takes it where that is later
void MaxArmDriver::send_set(const Pulses& target, std::int32_t time_ms, Instant begins,
                            Instant now) {
  const Instant in = now + wire_time(SetAngle{});
  const Instant taken = knows_looks() ? look_behind(in) : in;
  const Instant from = std::max(begins, taken);
  const auto early = std::chrono::duration_cast<std::chrono::milliseconds>(from - taken).count();
  const auto longer = std::min(static_cast<std::int32_t>(early), kMaxArmTimeMax - time_ms);
  const SetAngle set = sturdy_set(target, time_ms + longer);
  for (std::size_t i = 0; i < kServos; ++i) {
    target_[i] = set.pulses[i];
    way_low_[i] = std::min(way_low_[i], target_[i]);
    way_high_[i] = std::max(way_high_[i], target_[i]);
  }
  ++health_.requests;
  ++sets_;
  send(set, now);
  facts_.set = {set, now};
  alike_ = 0;
  moves_until_ = from + std::chrono::milliseconds(time_ms) + MaxArmPace::settles;
  told_at_ = moves_until_ + pace_.two_readings;
  show_way();
  pause(next_reading(free_at_) - now, now);
}

std::size_t MaxArmDriver::farthest(const Pulses& from) const {
  const auto off = [&](std::size_t k) { return std::abs(reading_[k] - from[k]); };
  std::size_t worst = 0;
  for (std::size_t i = 1; i < kServos; ++i) worst = off(i) > off(worst) ? i : worst;
  return worst;
}

/// The SET_ANGLE nearest to what was asked that one fault on the line, or a look of the MicroPython
/// program in its middle, cannot turn into another: some ms later, or a pulse beside.
SetAngle MaxArmDriver::sturdy_set(const Pulses& target, std::int32_t time_ms) const {
  constexpr std::array<std::int32_t, 3> kBeside{0, 1, -1};
  constexpr std::int32_t kLater = 16;
  constexpr int kWays = 27;
  const auto build = [&](int way, std::int32_t later) -> std::optional<SetAngle> {
    SetAngle set{{}, static_cast<std::uint16_t>(time_ms + later)};
    for (std::size_t i = 0; i < kServos; ++i, way /= 3) {
      const std::int32_t pulse = target[i] + kBeside[static_cast<std::size_t>(way % 3)];
      const bool moved = pulse != target[i];
      const double angle = angle_of(i, pulse);
      if (moved && (pulse < kMaxArmPulseMin || pulse > kMaxArmPulseMax)) return std::nullopt;
      if (moved && !SendRange(joints_[i]).from(positions_[i]).holds(angle)) return std::nullopt;
      set.pulses[i] = static_cast<std::uint16_t>(pulse);
    }
    return set;
  };
  for (int way = 0; way < kWays; ++way) {
    for (std::int32_t later = 0; later < kLater; ++later) {
      const auto set = build(way, later);
      if (set && sturdy(*set)) return *set;
    }
  }
  // Never met: tests look through targets all over the range.
  return *build(0, 0);
}

bool MaxArmDriver::near(const Pulses& a, const Pulses& b, std::int32_t tolerance) const {
  return std::ranges::equal(
      a, b, [&](std::int32_t x, std::int32_t y) { return std::abs(x - y) <= tolerance; });
}

double MaxArmDriver::angle_of(std::size_t joint, double pulse) const {
  return (pulse - device_.servos[joint].offset) / device_.servos[joint].pulses_per_rad;
}

void MaxArmDriver::show(std::size_t joint, PositionQuality quality, double low, double high) {
  const double a = angle_of(joint, low);
  const double b = angle_of(joint, high);
  positions_[joint] = {quality, angle_of(joint, reading_[joint]), std::min(a, b), std::max(a, b)};
}

/// Half a pulse of rounding, and how far a servo may creep under its load until the next reading:
/// a pulse where two readings agree, more where they do not.
void MaxArmDriver::show_measured() {
  for (std::size_t i = 0; i < kServos; ++i) {
    const std::int32_t crept = rests() ? std::abs(reading_[i] - previous_[i]) : kMargin;
    const double margin = kRounding + kCreep + kCreepAgain * crept;
    show(i, PositionQuality::kMeasured, reading_[i] - margin, reading_[i] + margin);
  }
}

void MaxArmDriver::show_way() {
  for (std::size_t i = 0; i < kServos; ++i) {
    way_low_[i] = std::min(way_low_[i], reading_[i]);
    way_high_[i] = std::max(way_high_[i], reading_[i]);
    show(i, PositionQuality::kUncertain, way_low_[i] - kMargin, way_high_[i] + kMargin);
  }
}

void MaxArmDriver::show_doubt() {
  for (std::size_t i = 0; i < kServos; ++i) {
    const MaxArmServo& servo = device_.servos[i];
    const double a = servo.offset + servo.pulses_per_rad * joints_[i].lower;
    const double b = servo.offset + servo.pulses_per_rad * joints_[i].upper;
    show(i, PositionQuality::kUncertain, std::min(a, b) - kRangeMargin,
         std::max(a, b) + kRangeMargin);
  }
}

std::size_t MaxArmDriver::take_output(std::span<std::uint8_t> out) {
  return output_.take_front(out);
}

std::optional<Instant> MaxArmDriver::next_deadline() const {
  if (phase_ == Phase::kClosed || phase_ == Phase::kFault) return std::nullopt;
  return due_;
}

std::optional<DriverEvent> MaxArmDriver::take_event() {
  return events_.take_front();
}

}  // namespace sinew
