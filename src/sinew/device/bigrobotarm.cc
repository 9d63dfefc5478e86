#include "sinew/device/bigrobotarm.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew {

using namespace bigrobotarm;

namespace {

constexpr std::int32_t kFreeMemory = 5214;  // bytes; the firmware prints what it has left
constexpr std::uint8_t kTextHomeGripper = 40;

/// Nearest later nanosecond, so that a motion is over when its end is reached.
Duration rounded_up(double seconds) {
  return Duration{static_cast<std::int64_t>(std::ceil(seconds * 1e9))};
}

void put_given(Words& words, const Words& given, std::uint8_t count) {
  std::copy_n(given.begin(), count, words.begin());
}

/// A joint that can never arrive stands still for ever in its profile.
bool can_move(std::int64_t distance, std::int32_t speed) {
  return distance == 0 || speed > 0;
}

}  // namespace

BigRobotArmFirmware::BigRobotArmFirmware(const BigRobotArmDevice& settings, Instant boot)
    : settings_(settings), now_(boot) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    SINEW_ASSERT(settings.joints[i].steps_per_motor_rev > 0);
    SINEW_ASSERT(settings.joints[i].multiplier_boot > 0);
    speeds_[i] = settings.joints[i].multiplier_boot;
  }
  accelerations_ = speeds_;
  accelerations_in_force_ = speeds_;
}

void BigRobotArmFirmware::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  for (const std::uint8_t byte : bytes) {
    // The end of the request that is under way does not queue behind its motion.
    if (input_.empty() && byte == byte::kTerminator && byte_decoder_.terminator_due()) {
      (void)byte_decoder_.push(byte);
      continue;
    }
    if (input_.full()) {
      ++bytes_lost_;
      continue;
    }
    input_.push_back(byte);
    process();
  }
}

void BigRobotArmFirmware::advance(Instant now) {
  SINEW_ASSERT(now >= now_);
  // Each round ends a motion at its own instant, so that the next one starts exactly there.
  while (moving_ && motion_end_ && *motion_end_ <= now) {
    now_ = *motion_end_;
    finish_motion();
    process();
  }
  now_ = now;
  process();
}

std::size_t BigRobotArmFirmware::take_output(std::span<std::uint8_t> out) {
  const std::size_t count = std::min(out.size(), output_.size());
  std::copy_n(output_.begin(), count, out.begin());
  std::copy(output_.begin() + count, output_.end(), output_.begin());
  output_.resize(output_.size() - count);
  return count;
}

std::optional<Instant> BigRobotArmFirmware::next_event() const {
  if (moving_) return motion_end_;
  // Held back for want of room: it goes on as soon as it is asked to.
  if (!input_.empty()) return now_;
  return std::nullopt;
}

std::array<double, kJoints> BigRobotArmFirmware::rotor_steps(Instant now) const {
  const double t = to_seconds(now - motion_start_);
  std::array<double, kJoints> steps{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    steps[i] = static_cast<double>(rotor_at_zero_[i] + targets_[i]);
    if (moving_) steps[i] += profiles_[i].at(t).position - profiles_[i].distance();
  }
  return steps;
}

void BigRobotArmFirmware::process() {
  while (!moving_ && output_.size() + kReplyRoom <= output_.capacity()) {
    std::uint8_t byte = 0;
    if (!next_byte(byte)) return;
    if (settings_.wire == BigRobotArmWire::kByte) {
      take_byte_request(byte);
    } else {
      take_character(static_cast<char>(byte));
    }
  }
}

bool BigRobotArmFirmware::next_byte(std::uint8_t& byte) {
  if (input_.empty()) return false;
  byte = input_[0];
  std::copy(input_.begin() + 1, input_.end(), input_.begin());
  input_.pop_back();
  return true;
}

void BigRobotArmFirmware::take_byte_request(std::uint8_t byte) {
  const auto request = byte_decoder_.push(byte);
  if (!request) return;
  if (!*request) return send(Reply{Invalid{}});
  const RequestId id = id_of(**request);
  if (id == RequestId::kGoto || id == RequestId::kHome) send(Reply{MotionStarted{id}});
  execute(**request, kJoints);
  if (!moving_) reply_done(**request);
}

void BigRobotArmFirmware::take_character(char character) {
  if (!line_reader_.push(character)) return;
  const std::string_view raw = line_reader_.line();
  send(text::ReplyLine{text::FreeMemory{kFreeMemory}});
  send(text::ReplyLine{
      text::Echo{FixedVector<char, text::kLineBuffer>(std::span(raw.data(), raw.size()))}});
  if (const auto line = text::decode_line(raw)) return take_line(*line);
  send(text::ReplyLine{Invalid{}});
  send(text::ReplyLine{text::Ready{}});
}

void BigRobotArmFirmware::take_line(const text::Line& line) {
  const bool ends = std::holds_alternative<text::End>(line.command);
  const auto* begin = std::get_if<text::Begin>(&line.command);
  if (ends && recording_) {
    recording_ = false;
    running_ = true;
    rounds_left_ = sequence_.empty() ? std::int8_t{0} : repeats_;
    sequence_place_ = 0;
    return run_sequence();
  }
  if (begin != nullptr && !recording_) {
    recording_ = true;
    repeats_ = begin->repeats;
    sequence_.clear();
  } else if (ends || begin != nullptr || (recording_ && sequence_.full())) {
    send(text::ReplyLine{Invalid{}});
  } else if (recording_) {
    sequence_.push_back(line);
  } else {
    const auto& request = std::get<Request>(line.command);
    execute(request, line.words_given);
    if (!moving_) reply_done(request);
    return;
  }
  send(text::ReplyLine{text::Ready{}});
}

void BigRobotArmFirmware::execute(const Request& request, std::uint8_t words_given) {
  under_way_ = request;
  if (const auto* go = std::get_if<Goto>(&request)) {
    Words targets = targets_;
    put_given(targets, go->positions, words_given);
    begin_motion(targets);
  } else if (std::holds_alternative<Home>(request)) {
    if (settings_.wire == BigRobotArmWire::kText) gripper_.position = kTextHomeGripper;
    begin_motion(Words{});
  } else if (std::holds_alternative<Reset>(request)) {
    for (std::size_t i = 0; i < kJoints; ++i) rotor_at_zero_[i] += targets_[i];
    targets_ = {};
  } else if (const auto* speeds = std::get_if<SetSpeeds>(&request)) {
    put_given(speeds_, speeds->speeds, words_given);
  } else if (const auto* accelerations = std::get_if<SetAccelerations>(&request)) {
    put_given(accelerations_, accelerations->accelerations, words_given);
    for (std::size_t i = 0; i < kJoints; ++i) {
      if (accelerations_[i] > 0) accelerations_in_force_[i] = accelerations_[i];
    }
  } else if (const auto* gripper = std::get_if<SetGripper>(&request)) {
    gripper_.enabled = gripper->enabled;
    if (gripper->enabled) gripper_.position = gripper->position;
  } else if (const auto* sync = std::get_if<SetSync>(&request)) {
    sync_ = sync->on;
  }
}

void BigRobotArmFirmware::begin_motion(const Words& targets) {
  double longest = 0;
  bool arrives = true;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const std::int64_t distance = std::int64_t{targets[i]} - targets_[i];
    const double unit = settings_.joints[i].steps_per_motor_rev / 100;
    arrives = arrives && can_move(distance, speeds_[i]);
    // A joint that cannot move keeps its place: a profile that takes for ever, in effect.
    const double speed = speeds_[i] > 0 ? speeds_[i] * unit : 1e-12;
    profiles_[i] =
        motion::Trapezoid(static_cast<double>(distance), speed, accelerations_in_force_[i] * unit);
    longest = std::max(longest, profiles_[i].duration());
  }
  targets_ = targets;
  if (longest == 0) return;
  if (sync_) {
    for (motion::Trapezoid& profile : profiles_) profile = profile.stretched(longest);
  }
  moving_ = true;
  motion_start_ = now_;
  motion_end_.reset();
  // Beyond a century nobody waits, and the count of nanoseconds would overflow.
  constexpr double kForever = 3e9;  // s
  if (arrives && longest < kForever) motion_end_ = now_ + rounded_up(longest);
}

void BigRobotArmFirmware::finish_motion() {
  moving_ = false;
  motion_end_.reset();
  if (running_) return run_sequence();
  reply_done(under_way_);
}

void BigRobotArmFirmware::run_sequence() {
  while (!moving_ && rounds_left_ > 0) {
    if (sequence_place_ == sequence_.size()) {
      sequence_place_ = 0;
      --rounds_left_;
      continue;
    }
    const text::Line& line = sequence_[sequence_place_++];
    execute(std::get<Request>(line.command), line.words_given);
  }
  if (moving_) return;
  running_ = false;
  reply_done(ReadStatus{});
}

Status BigRobotArmFirmware::status() const {
  return {targets_, accelerations_, speeds_, gripper_, sync_};
}

void BigRobotArmFirmware::reply_done(const Request& request) {
  if (settings_.wire == BigRobotArmWire::kText) return reply_text(request);
  switch (id_of(request)) {
    case RequestId::kGoto:
      return send(Reply{GotoDone{targets_}});
    case RequestId::kHome:
      return send(Reply{HomeDone{targets_}});
    case RequestId::kReset:
      return send(Reply{ResetDone{targets_}});
    case RequestId::kSpeeds:
      return send(Reply{Speeds{speeds_}});
    case RequestId::kAccelerations:
      return send(Reply{Accelerations{accelerations_}});
    case RequestId::kGripper:
      return send(Reply{gripper_});
    case RequestId::kSync:
      return send(Reply{Sync{sync_}});
    case RequestId::kStatus:
      return send(Reply{status()});
  }
}

void BigRobotArmFirmware::reply_text(const Request& request) {
  const RequestId id = id_of(request);
  const bool all = id == RequestId::kStatus;
  if (all || id == RequestId::kGoto || id == RequestId::kHome) {
    send(text::ReplyLine{text::MovingTo{}});
    send(text::ReplyLine{text::PositionLine{targets_}});
  }
  if (id == RequestId::kReset) send(text::ReplyLine{text::PositionLine{targets_}});
  if (all || id == RequestId::kAccelerations) send(text::ReplyLine{Accelerations{accelerations_}});
  if (all || id == RequestId::kSpeeds) send(text::ReplyLine{Speeds{speeds_}});
  if (id == RequestId::kGripper) send(text::ReplyLine{gripper_});
  if (all || id == RequestId::kSync) send(text::ReplyLine{Sync{sync_}});
  send(text::ReplyLine{text::Ready{}});
}

void BigRobotArmFirmware::send(const Reply& reply) {
  for (const std::uint8_t byte : byte::encode_reply(reply)) output_.push_back(byte);
}

void BigRobotArmFirmware::send(const text::ReplyLine& line) {
  for (const char character : text::encode_reply_line(line)) {
    output_.push_back(static_cast<std::uint8_t>(character));
  }
  output_.push_back('\r');
  output_.push_back('\n');
}

}  // namespace sinew
