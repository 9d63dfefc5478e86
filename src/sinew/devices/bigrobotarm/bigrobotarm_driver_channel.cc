#include "sinew/devices/bigrobotarm/bigrobotarm_driver_channel.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew {

using namespace bigrobotarm;

namespace {

/// The firmware fills the top byte of a reported position with the sign alone.
constexpr double kStepMax = (1 << 24) - 1;
/// It keeps multipliers as floats and cuts them when it echoes.
constexpr std::int32_t kEchoTolerance = 1;

/// Steps per s that the board's processor manages at most, one joint alone and all together; its
/// own trapezoid knows nothing of them. Measured on the firmware in a cycle-accurate emulation.
constexpr double kStepRateAlone = 3430;
constexpr double kStepRateTogether = 5000;
/// From the ordinary quiet time up to 8 times it.
constexpr int kPatienceDoublings = 3;

/// Seconds that the processor needs for the steps of a motion, however fast they are asked for.
double stepping_time(const Words& from, const Words& to) {
  double longest = 0;
  double total = 0;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double steps = std::abs(1.0 * to[i] - from[i]);
    longest = std::max(longest, steps);
    total += steps;
  }
  return std::max(longest / kStepRateAlone, total / kStepRateTogether);
}

Error joint_error(ErrorCode code, std::size_t joint, double measured, double limit) {
  return {code, static_cast<std::int8_t>(joint), measured, limit};
}

/// The step for `steps`, or the nearer neighbour where it cannot be sent.
std::optional<std::int32_t> sendable_step(double steps) {
  const auto nearest = static_cast<std::int32_t>(std::lround(steps));
  const std::int32_t side = steps < nearest ? -1 : 1;
  for (const std::int32_t candidate : {nearest, nearest + side, nearest - side}) {
    if (byte::sendable(candidate)) return candidate;
  }
  return std::nullopt;
}

std::optional<Error> compare(const Words& reported, const Words& sent, std::int32_t tolerance) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (std::abs(std::int64_t{reported[i]} - sent[i]) > tolerance) {
      return joint_error(ErrorCode::kReplyMismatch, i, reported[i], sent[i]);
    }
  }
  return std::nullopt;
}

/// The byte that stands for a reply on the byte wire.
double head_of(const Reply& reply) {
  if (std::holds_alternative<Status>(reply)) return 0xCA;
  if (std::holds_alternative<Invalid>(reply)) return 0xC9;
  if (const auto* started = std::get_if<MotionStarted>(&reply)) {
    return static_cast<double>(started->id);
  }
  return static_cast<double>(reply.index());  // GotoDone is 1, and so on
}

double head_due(const Request& request) {
  if (std::holds_alternative<ReadStatus>(request)) return 0xCA;
  return static_cast<double>(id_of(request));
}

}  // namespace

BigRobotArmChannel::BigRobotArmChannel(const BigRobotArmDevice& device,
                                       const BigRobotArmChannelTiming& timing)
    : device_(device), timing_(timing) {
  for (const BigRobotArmJoint& joint : device.joints) SINEW_ASSERT(joint.steps_per_rad != 0);
  SINEW_ASSERT(timing.quiet > Duration::zero() && timing.reply_timeout > Duration::zero());
}

void BigRobotArmChannel::open(Instant now) {
  byte_decoder_.reset();
  text_decoder_.reset();
  output_.clear();
  state_ = State::kQuiet;
  doubt_told_ = false;
  quiet_since_ = now;
  deadline_ = now + timing_.quiet;
}

void BigRobotArmChannel::close() {
  const bool known = state_ == State::kClosed;
  state_ = State::kClosed;
  deadline_.reset();
  output_.clear();
  if (!known) tell(Failed{{ErrorCode::kPortClosed}});
}

Expected<void> BigRobotArmChannel::read_status(Instant now) {
  return ask(ReadStatus{}, now);
}

Expected<void> BigRobotArmChannel::move_to(const BigRobotArmAngles& q, Duration expected,
                                           Instant now) {
  const auto steps = steps_of(q);
  if (!steps) return std::unexpected(steps.error());
  const auto asked = ask(Goto{*steps}, now);
  if (asked) expected_ = std::max(expected, Duration::zero());
  return asked;
}

Expected<void> BigRobotArmChannel::set_speeds(const Words& multipliers, Instant now) {
  if (const auto checked = check_multipliers(device_, multipliers); !checked) return checked;
  return ask(SetSpeeds{multipliers}, now);
}

Expected<void> BigRobotArmChannel::set_accelerations(const Words& multipliers, Instant now) {
  if (const auto checked = check_multipliers(device_, multipliers); !checked) return checked;
  return ask(SetAccelerations{multipliers}, now);
}

Expected<void> BigRobotArmChannel::set_gripper(bool enabled, std::int32_t position, Instant now) {
  if (position < 0 || position > std::min(device_.gripper_max, 255)) {
    return std::unexpected(
        Error{ErrorCode::kGripperRange, -1, 1.0 * position, 1.0 * device_.gripper_max});
  }
  return ask(SetGripper{enabled, static_cast<std::uint8_t>(position)}, now);
}

Expected<void> BigRobotArmChannel::reset_positions(Instant now) {
  return ask(Reset{}, now);
}

Expected<void> BigRobotArmChannel::leave_sync(Instant now) {
  return ask(SetSync{false}, now);
}

bool BigRobotArmChannel::withdraw() {
  if (state_ != State::kAsked || output_.empty() || output_begun_) return false;
  output_.clear();
  state_ = State::kIdle;
  deadline_.reset();
  return true;
}

Expected<Words> BigRobotArmChannel::steps_of(const BigRobotArmAngles& q) const {
  Words words{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double steps = (q[i] - offset_[i]) * device_.joints[i].steps_per_rad;
    // Written so that NaN is refused too.
    if (!(std::abs(steps) <= kStepMax - 1)) {
      return std::unexpected(joint_error(ErrorCode::kStepRange, i, steps, kStepMax));
    }
    words[i] = static_cast<std::int32_t>(std::lround(steps));
    if (device_.wire == BigRobotArmWire::kText) continue;
    const auto step = sendable_step(steps);
    if (!step) return std::unexpected(joint_error(ErrorCode::kUnsendable, i, words[i], 0));
    words[i] = *step;
  }
  return words;
}

BigRobotArmAngles BigRobotArmChannel::angles_of(const Words& steps) const {
  BigRobotArmAngles q{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    q[i] = offset_[i] + steps[i] / device_.joints[i].steps_per_rad;
  }
  return q;
}

Expected<void> BigRobotArmChannel::ask(const Request& request, Instant now) {
  if (state_ != State::kIdle) return std::unexpected(Error{ErrorCode::kBusy});
  const bool fits = device_.wire == BigRobotArmWire::kByte ? byte::sendable(request)
                                                           : text::sendable(text::Line{request});
  if (!fits) {
    const auto* gripper = std::get_if<SetGripper>(&request);
    return std::unexpected(
        Error{ErrorCode::kUnsendable, -1, gripper != nullptr ? 1.0 * gripper->position : 0.0});
  }
  send(request);
  state_ = State::kAsked;
  asked_at_ = now;
  deadline_ = now + timing_.reply_timeout;
  return {};
}

void BigRobotArmChannel::send(const Request& request) {
  SINEW_ASSERT(output_.empty());
  asked_ = request;
  output_begun_ = false;
  if (device_.wire == BigRobotArmWire::kByte) {
    for (const std::uint8_t byte : byte::encode_request(request)) output_.push_back(byte);
    output_.push_back(byte::kTerminator);
  } else {
    for (const char character : text::encode_line({request})) {
      output_.push_back(static_cast<std::uint8_t>(character));
    }
    output_.push_back(text::kLineEnd);
  }
}

void BigRobotArmChannel::receive(std::span<const std::uint8_t> bytes, Instant now) {
  // What was due before these bytes came is late, whoever called first.
  if (deadline_ && now > *deadline_) poll(now);
  for (const std::uint8_t byte : bytes) {
    if (state_ == State::kClosed) return;
    if (state_ == State::kQuiet) {
      take_unexpected();
      deadline_ = now + timing_.quiet;
      if (now - quiet_since_ > timing_.quiet_limit && !doubt_told_) {
        doubt({ErrorCode::kUnaskedReply, -1, 1.0 * byte}, now);
      }
      continue;
    }
    const auto result = decode(byte);
    if (state_ == State::kIdle || !output_.empty()) {
      // Nothing was asked, or the question has not even left.
      take_unexpected();
      doubt({ErrorCode::kUnaskedReply, -1, 1.0 * byte}, now);
    } else if (result && !*result) {
      take_unexpected();
      doubt({ErrorCode::kUnexpectedReply, -1, 1.0 * result->error().seen,
             1.0 * result->error().expected},
            now);
    } else if (result) {
      if (const auto error = check(**result)) {
        take_unexpected();
        doubt(*error, now);
      } else {
        take_reply(**result, now);
      }
    }
  }
}

void BigRobotArmChannel::take_unexpected() {
  ++unexpected_;
  noise_ = true;
}

std::optional<std::expected<Reply, Garbage>> BigRobotArmChannel::decode(std::uint8_t byte) {
  if (device_.wire == BigRobotArmWire::kByte) return byte_decoder_.push(byte);
  return text_decoder_.push(static_cast<char>(byte));
}

std::optional<Error> BigRobotArmChannel::check(const Reply& reply) const {
  const Error unexpected{ErrorCode::kUnexpectedReply, -1, head_of(reply), head_due(asked_)};
  if (std::holds_alternative<Invalid>(reply)) return Error{ErrorCode::kDeviceRefused};
  if (const auto* started = std::get_if<MotionStarted>(&reply)) {
    const bool due = state_ == State::kAsked && started->id == id_of(asked_);
    return due ? std::nullopt : std::optional(unexpected);
  }
  const auto* go = std::get_if<Goto>(&asked_);
  if (go != nullptr && state_ != State::kMoving) return unexpected;
  if (const auto* done = std::get_if<GotoDone>(&reply); done != nullptr && go != nullptr) {
    return compare(done->positions, go->positions, 0);
  }
  if (const auto* done = std::get_if<ResetDone>(&reply);
      done != nullptr && std::holds_alternative<Reset>(asked_)) {
    return compare(done->positions, Words{}, 0);
  }
  const auto* speeds = std::get_if<SetSpeeds>(&asked_);
  if (const auto* echo = std::get_if<Speeds>(&reply); echo != nullptr && speeds != nullptr) {
    return compare(echo->speeds, speeds->speeds, kEchoTolerance);
  }
  const auto* ramps = std::get_if<SetAccelerations>(&asked_);
  if (const auto* echo = std::get_if<Accelerations>(&reply); echo != nullptr && ramps != nullptr) {
    return compare(echo->accelerations, ramps->accelerations, kEchoTolerance);
  }
  const auto* grip = std::get_if<SetGripper>(&asked_);
  if (const auto* echo = std::get_if<Gripper>(&reply); echo != nullptr && grip != nullptr) {
    // A disabled gripper keeps its old position, whatever was asked.
    const bool same =
        echo->enabled == grip->enabled && (!grip->enabled || echo->position == grip->position);
    if (same) return std::nullopt;
    return Error{ErrorCode::kReplyMismatch, -1, 1.0 * echo->position, 1.0 * grip->position};
  }
  const auto* sync = std::get_if<SetSync>(&asked_);
  if (const auto* echo = std::get_if<Sync>(&reply); echo != nullptr && sync != nullptr) {
    if (echo->on == sync->on) return std::nullopt;
    return Error{ErrorCode::kReplyMismatch, -1, echo->on ? 1.0 : 0.0, sync->on ? 1.0 : 0.0};
  }
  const bool status =
      std::holds_alternative<Status>(reply) && std::holds_alternative<ReadStatus>(asked_);
  return status ? std::nullopt : std::optional(unexpected);
}

void BigRobotArmChannel::take_reply(const Reply& reply, Instant now) {
  if (std::holds_alternative<MotionStarted>(reply)) {
    state_ = State::kMoving;
    const auto* go = std::get_if<Goto>(&asked_);
    const double stepping = stepping_time(positions_, go != nullptr ? go->positions : Words{});
    const double expected = std::max(to_seconds(expected_), stepping);
    deadline_ = asked_at_ + from_seconds(expected * timing_.move_factor) + timing_.move_margin;
    return tell(Started{});
  }
  if (const auto* status = std::get_if<Status>(&reply)) return take_status(*status, now);
  if (const auto* done = std::get_if<GotoDone>(&reply)) positions_ = done->positions;
  if (std::holds_alternative<ResetDone>(reply)) {
    offset_ = angles_of(positions_);
    positions_ = {};
  }
  state_ = State::kIdle;
  deadline_.reset();
  tell(Done{id_of(asked_), angles_of(positions_)});
}

void BigRobotArmChannel::take_status(const Status& status, Instant now) {
  const bool after_doubt = state_ == State::kVerify;
  if (after_doubt && silent_asks_ > 0) {
    // It may answer an earlier question, with the rest of the answers still to come.
    silent_asks_ = 0;
    state_ = State::kQuiet;
    deadline_ = now + timing_.quiet;
    return;
  }
  positions_ = status.positions;
  state_ = State::kIdle;
  deadline_.reset();
  doubt_told_ = false;
  tell(StatusRead{angles_of(positions_), status, after_doubt, deaf_});
  noise_ = deaf_ = false;
}

BigRobotArmStart BigRobotArmChannel::start_in(const Status& status) const {
  Words boot{};
  for (std::size_t i = 0; i < kJoints; ++i) boot[i] = device_.joints[i].multiplier_boot;
  const bool as_built = !compare(status.speeds, boot, kEchoTolerance) &&
                        !compare(status.accelerations, boot, kEchoTolerance) && !status.sync &&
                        status.gripper.value_or(Gripper{true, 90}) == Gripper{true, 90};
  if (!as_built) return BigRobotArmStart::kNone;
  return status.positions == Words{} ? BigRobotArmStart::kAnew : BigRobotArmStart::kKept;
}

void BigRobotArmChannel::poll(Instant now) {
  if (!deadline_ || now < *deadline_) return;
  if (state_ == State::kQuiet) {
    if (!output_.empty()) {
      deadline_ = now + timing_.quiet;
      return;
    }
    byte_decoder_.reset();
    text_decoder_.reset();
    send(ReadStatus{});
    state_ = State::kVerify;
    asked_at_ = now;
    deadline_ = now + timing_.reply_timeout;
    return;
  }
  if (state_ == State::kVerify && ++silent_asks_ >= kDeafAsks && noise_) deaf_ = true;
  doubt({ErrorCode::kDeviceSilent, -1, to_seconds(now - asked_at_),
         to_seconds(*deadline_ - asked_at_)},
        now);
}

void BigRobotArmChannel::doubt(const Error& error, Instant now) {
  // A request that has not begun to leave is dropped. One that has must go on: the real device
  // takes a goto that breaks off for a goto to zero.
  if (!output_begun_) output_.clear();
  state_ = State::kQuiet;
  quiet_since_ = now;
  // Twice as patient after each question without an answer: where a request was cut off before,
  // every byte of a question fills it up.
  deadline_ = now + timing_.quiet * (1 << std::min(silent_asks_, kPatienceDoublings));
  if (!doubt_told_) tell(Failed{error});
  doubt_told_ = true;
}

std::size_t BigRobotArmChannel::take_output(std::span<std::uint8_t> out) {
  const std::size_t count = output_.take_front(out);
  output_begun_ = output_begun_ || count > 0;
  return count;
}

std::optional<BigRobotArmChannel::Event> BigRobotArmChannel::take_event() {
  return events_.take_front();
}

void BigRobotArmChannel::tell(const Event& event) {
  SINEW_ASSERT(!events_.full());
  events_.push_back(event);
}

/// The arm is taken to count from the model's zero.
std::optional<Error> BigRobotArmDevice::target_refusal(const RobotModel& /*robot*/,
                                                       std::span<const double> q,
                                                       std::span<const double> /*from*/) const {
  SINEW_ASSERT(q.size() == kBigRobotArmJoints);
  BigRobotArmAngles angles{};
  std::ranges::copy(q, angles.begin());
  const auto steps = BigRobotArmChannel(*this).steps_of(angles);
  return steps ? std::nullopt : std::optional(steps.error());
}

std::optional<Error> BigRobotArmDevice::gripper_refusal(const GripperTo& gripper) const {
  constexpr double kTolerance = 1e-9;
  const double widest = from_deg(gripper_max);
  const double angle = gripper.angle.value_or(0);
  if (!(angle >= 0 && angle <= widest + kTolerance)) {
    return Error{ErrorCode::kToolAngle, -1, angle, angle < 0 ? 0 : widest};
  }
  const auto position = static_cast<std::int32_t>(std::lround(to_deg(angle)));
  const bool cut = wire == BigRobotArmWire::kByte && !bigrobotarm::byte::sendable(position);
  return cut ? std::optional(Error{ErrorCode::kUnsendable, -1, 1.0 * position}) : std::nullopt;
}

}  // namespace sinew
