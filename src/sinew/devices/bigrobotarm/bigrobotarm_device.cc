#include "sinew/devices/bigrobotarm/bigrobotarm_device.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew {

using namespace bigrobotarm;

namespace {

constexpr std::int32_t kFreeMemory = 5214;  // bytes; the firmware prints what it has left
constexpr std::uint8_t kTextHomeGripper = 40;
constexpr std::int32_t kMultiplierMax2026 = 500;

/// Nearest later nanosecond, so that a motion is over when its end is reached.
Duration rounded_up(double seconds) {
  return Duration{static_cast<std::int64_t>(std::ceil(seconds * 1e9))};
}

void put_given(Words& words, const Words& given, std::uint8_t count) {
  std::copy_n(given.begin(), count, words.begin());
}

bool is_queue_line(const text::Line& line) {
  return std::holds_alternative<text::QueueGoto>(line.command) ||
         std::holds_alternative<text::QueueFlush>(line.command) ||
         std::holds_alternative<text::QueueClear>(line.command);
}

}  // namespace

BigRobotArmFirmware::BigRobotArmFirmware(const BigRobotArmDevice& settings, Instant boot,
                                         BigRobotArmProfile profile)
    : settings_(settings), profile_(profile), now_(boot) {
  for (const BigRobotArmJoint& joint : settings.joints) {
    SINEW_ASSERT(joint.steps_per_motor_rev > 0);
    SINEW_ASSERT(joint.multiplier_boot > 0);
  }
  this->boot();
}

void BigRobotArmFirmware::boot() {
  for (std::size_t i = 0; i < kJoints; ++i) speeds_[i] = settings_.joints[i].multiplier_boot;
  accelerations_ = speeds_;
  accelerations_in_force_ = speeds_;
}

void BigRobotArmFirmware::reset(Instant now, Duration deaf) {
  advance(now);
  const auto steps = rotor_steps(now);
  const std::uint64_t lost = bytes_lost_;
  *this = BigRobotArmFirmware(settings_, now, profile_);
  for (std::size_t i = 0; i < kJoints; ++i) rotor_at_zero_[i] = std::llround(steps[i]);
  bytes_lost_ = lost;
  deaf_until_ = now + deaf;
}

void BigRobotArmFirmware::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  for (const std::uint8_t byte : bytes) {
    if (now_ < deaf_until_) {
      ++bytes_lost_;
      continue;
    }
    // The end of the request that is under way does not queue behind its motion.
    if (!as_built() && input_.empty() && byte == byte::kTerminator &&
        byte_decoder_.terminator_due()) {
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
  if (moving_ && as_built()) stepping_.advance_to(to_seconds(now_ - motion_start_));
  process();
}

std::size_t BigRobotArmFirmware::take_output(std::span<std::uint8_t> out) {
  return output_.take_front(out);
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
  BigRobotArmStepping stepping = stepping_;
  if (moving_ && as_built()) stepping.advance_to(t);
  for (std::size_t i = 0; i < kJoints; ++i) {
    steps[i] = static_cast<double>(rotor_at_zero_[i] + targets_[i]);
    if (!moving_) continue;
    const double done = as_built() ? stepping.position(i) : profiles_[i].at(t).position;
    steps[i] += done - distances_[i];
  }
  return steps;
}

std::array<double, kJoints> BigRobotArmFirmware::counted_steps(Instant now) const {
  std::array<double, kJoints> steps = rotor_steps(now);
  for (std::size_t i = 0; i < kJoints; ++i) steps[i] -= static_cast<double>(rotor_at_zero_[i]);
  return steps;
}

void BigRobotArmFirmware::process() {
  while (!holds_input() && output_.size() + kReplyRoom <= output_.capacity()) {
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
  input_.drop_front(1);
  return true;
}

void BigRobotArmFirmware::take_byte_request(std::uint8_t byte) {
  const auto request = as_built() ? cut_decoder_.push(byte) : byte_decoder_.push(byte);
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
  auto line = text::decode_line(raw);
  const bool old = settings_.dialect == BigRobotArmDialect::k2021;
  if (old && line && is_queue_line(*line)) line.reset();
  if (line || old) {
    send(text::ReplyLine{text::FreeMemory{kFreeMemory}});
    send(text::ReplyLine{
        text::Echo{FixedVector<char, text::kLineBuffer>(std::span(raw.data(), raw.size()))}});
  }
  if (line) return take_line(*line);
  reply_line(Invalid{});
}

void BigRobotArmFirmware::take_line(const text::Line& line) {
  const bool sequence_word = std::holds_alternative<text::Begin>(line.command) ||
                             std::holds_alternative<text::End>(line.command);
  if (recording_ || sequence_word) return take_sequence_line(line);
  if (take_queue_line(line)) return;
  const auto& request = std::get<Request>(line.command);
  if (queue_running_ && id_of(request) != RequestId::kStatus) {
    held_ = line;
    return;
  }
  execute(request, line.words_given);
  if (!moving_ || queue_running_) reply_done(request);
}

void BigRobotArmFirmware::take_sequence_line(const text::Line& line) {
  const auto* begin = std::get_if<text::Begin>(&line.command);
  const bool ends = std::holds_alternative<text::End>(line.command);
  if (ends && !recording_ && as_built() && settings_.dialect == BigRobotArmDialect::k2021) {
    dead_ = true;  // a null pointer
    return;
  }
  if (queue_running_ && (begin != nullptr || ends)) {
    held_ = line;
    return;
  }
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
  } else if (!std::holds_alternative<Request>(line.command) || sequence_.full()) {
    return reply_line(Invalid{});
  } else {
    sequence_.push_back(line);
  }
  send(text::ReplyLine{text::Ready{}});
}

bool BigRobotArmFirmware::take_queue_line(const text::Line& line) {
  if (const auto* go = std::get_if<text::QueueGoto>(&line.command)) {
    if (queue_.full()) {
      reply_line(QueueFull{});
      return true;
    }
    Words targets = queue_.empty() ? targets_ : queue_.back();
    put_given(targets, go->positions, line.words_given);
    queue_.push_back(targets);
    send(text::ReplyLine{text::QueuedTo{}});
    reply_line(text::PositionLine{targets});
    if (!moving_) run_queue();
  } else if (std::holds_alternative<text::QueueClear>(line.command)) {
    queue_.clear();
    reply_line(QueueCleared{});
  } else if (std::holds_alternative<text::QueueFlush>(line.command)) {
    if (queue_running_) {
      held_ = line;
    } else {
      reply_line(QueueDrained{});
    }
  } else {
    return false;
  }
  return true;
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
    put_multipliers(speeds_, speeds->speeds, words_given);
  } else if (const auto* accelerations = std::get_if<SetAccelerations>(&request)) {
    put_multipliers(accelerations_, accelerations->accelerations, words_given);
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

void BigRobotArmFirmware::put_multipliers(Words& words, const Words& given,
                                          std::uint8_t count) const {
  put_given(words, given, count);
  if (!text_of(BigRobotArmDialect::k2026)) return;
  for (std::int32_t& word : words) word = std::clamp(word, 1, kMultiplierMax2026);
}

void BigRobotArmFirmware::begin_motion(const Words& targets) {
  // As built, sync mode moves motors that report to nobody.
  const bool split = sync_ && as_built() && !text_of(BigRobotArmDialect::k2026);
  Words& from = split ? sync_targets_ : targets_;
  bool any = false;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const std::int64_t distance = std::int64_t{targets[i]} - from[i];
    distances_[i] = static_cast<double>(distance);
    any = any || distance != 0 || level_speeds_[i] != 0;
    if (split) rotor_at_zero_[i] += distance;
  }
  from = targets;
  if (!any) return;
  const auto duration = as_built() ? begin_stepping(split) : begin_profiles();
  if (duration && *duration == 0) return;
  moving_ = true;
  motion_start_ = now_;
  motion_end_.reset();
  // Beyond a century nobody waits, and the count of nanoseconds would overflow.
  constexpr double kForever = 3e9;  // s
  if (duration && *duration < kForever) motion_end_ = now_ + rounded_up(*duration);
}

std::optional<double> BigRobotArmFirmware::begin_profiles() {
  double longest = 0;
  bool arrives = true;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double unit = settings_.joints[i].steps_per_motor_rev / 100;
    arrives = arrives && (distances_[i] == 0 || speeds_[i] > 0);
    // A joint that cannot move keeps its place: a profile that takes for ever, in effect.
    const double speed = speeds_[i] > 0 ? speeds_[i] * unit : 1e-12;
    profiles_[i] = motion::Trapezoid(distances_[i], speed, accelerations_in_force_[i] * unit);
    longest = std::max(longest, profiles_[i].duration());
  }
  if (sync_) {
    for (motion::Trapezoid& profile : profiles_) profile = profile.stretched(longest);
  }
  return arrives ? std::optional(longest) : std::nullopt;
}

std::optional<double> BigRobotArmFirmware::begin_stepping(bool split) {
  BigRobotArmStepping::Joints joints;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double unit = settings_.joints[i].steps_per_motor_rev / 100;
    // The motors of the split frame never hear of other speeds than those of power-up.
    const std::int32_t speed = split ? settings_.joints[i].multiplier_boot : speeds_[i];
    joints[i] = {distances_[i], speed * unit, accelerations_in_force_[i] * unit, level_speeds_[i]};
  }
  level_speeds_ = {};
  stepping_ = sync_ ? BigRobotArmStepping::level(joints) : BigRobotArmStepping::ramped(joints);
  if (sync_ && !split) {
    for (std::size_t i = 0; i < kJoints; ++i) level_speeds_[i] = stepping_.level_speed(i);
  }
  return stepping_.duration();
}

void BigRobotArmFirmware::finish_motion() {
  moving_ = false;
  motion_end_.reset();
  if (queue_running_) return run_queue();
  if (running_) return run_sequence();
  reply_done(under_way_);
}

void BigRobotArmFirmware::run_queue() {
  queue_running_ = true;
  while (!moving_ && !queue_.empty()) {
    const Words next = queue_[0];
    queue_.drop_front(1);
    begin_motion(next);
  }
  if (moving_) return;
  queue_running_ = false;
  if (!held_) return;
  const text::Line line = *held_;
  held_.reset();
  if (std::holds_alternative<text::QueueFlush>(line.command)) return reply_line(QueueDrained{});
  take_line(line);
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

/// The firmware keeps a multiplier as a float of steps per s, and cuts on the way back.
Words BigRobotArmFirmware::reported_multipliers(Words words) const {
  if (!as_built()) return words;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const auto per_rev = static_cast<float>(settings_.joints[i].steps_per_motor_rev);
    const float kept = static_cast<float>(words[i]) / 100.0F * per_rev;
    const float back = kept / per_rev * 100.0F;
    // Beyond 2^24 a float knows no single steps, and 2^31 has no int32.
    if (std::abs(back) < 0x1p24F) words[i] = static_cast<std::int32_t>(back);
  }
  return reported_words(words);
}

/// Four bytes, of which the firmware fills the top one with the sign alone. Byte wire only.
Words BigRobotArmFirmware::reported_words(Words words) const {
  if (!as_built() || settings_.wire == BigRobotArmWire::kText) return words;
  for (std::int32_t& word : words) {
    const std::uint32_t low = static_cast<std::uint32_t>(word) & 0xFFFFFFU;
    word = static_cast<std::int32_t>(word < 0 ? low | 0xFF000000U : low);
  }
  return words;
}

Status BigRobotArmFirmware::status() const {
  return {reported_words(targets_), reported_multipliers(accelerations_),
          reported_multipliers(speeds_), gripper_, sync_};
}

void BigRobotArmFirmware::reply_done(const Request& request) {
  if (settings_.wire == BigRobotArmWire::kText) return reply_text(request);
  const Status now = status();
  switch (id_of(request)) {
    case RequestId::kGoto:
      return send(Reply{GotoDone{now.positions}});
    case RequestId::kHome:
      return send(Reply{HomeDone{now.positions}});
    case RequestId::kReset:
      return send(Reply{ResetDone{now.positions}});
    case RequestId::kSpeeds:
      return send(Reply{Speeds{now.speeds}});
    case RequestId::kAccelerations:
      return send(Reply{Accelerations{now.accelerations}});
    case RequestId::kGripper:
      return send(Reply{gripper_});
    case RequestId::kSync:
      return send(Reply{Sync{sync_}});
    case RequestId::kStatus:
      return send(Reply{now});
  }
}

void BigRobotArmFirmware::reply_text(const Request& request) {
  const RequestId id = id_of(request);
  const bool all = id == RequestId::kStatus;
  const Status now = status();
  if (all || id == RequestId::kGoto || id == RequestId::kHome) {
    send(text::ReplyLine{text::MovingTo{}});
    send(text::ReplyLine{text::PositionLine{targets_}});
  }
  if (id == RequestId::kReset) send(text::ReplyLine{text::PositionLine{targets_}});
  if (all || id == RequestId::kAccelerations)
    send(text::ReplyLine{Accelerations{now.accelerations}});
  if (all || id == RequestId::kSpeeds) send(text::ReplyLine{Speeds{now.speeds}});
  if (id == RequestId::kGripper) send(text::ReplyLine{gripper_});
  if (all || id == RequestId::kSync) send(text::ReplyLine{Sync{sync_}});
  send(text::ReplyLine{text::Ready{}});
}

void BigRobotArmFirmware::reply_line(const text::ReplyLine& line) {
  send(line);
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
