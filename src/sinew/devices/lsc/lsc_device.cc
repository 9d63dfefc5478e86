#include "sinew/devices/lsc/lsc_device.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "sinew/core/assert.h"
#include "sinew/devices/lsc/lsc_device_jog.h"

namespace sinew {

using namespace lsc;

namespace {

constexpr double kBootUnits = 1500;               // us; the middle of a PWM servo
constexpr std::uint16_t kPulseMin = 500;          // us
constexpr std::uint16_t kPulseMax = 2500;         // us
constexpr std::uint16_t kBusMax = 1000;           // thousandths of 240 deg
constexpr std::uint16_t kEsp32GripperMax = 1500;  // us; beyond it the jaws would stall
constexpr std::uint16_t kEsp32TimeMin = 20;       // ms
constexpr std::uint16_t kEsp32TimeMax = 30'000;   // ms
constexpr std::uint16_t kEsp32HomeTime = 1000;    // ms; assumed
constexpr std::uint16_t kEsp32JogTime = 1000;     // ms; assumed, as for home
constexpr int kOffsetMax = 125;
constexpr double kMotorUnitsPerS = 1560;  // at speed 1000: 0.16 s for 60 deg, servos of that class
constexpr double kMotorLead = 60;         // units; the shaft is pushed on, never wound up
constexpr std::int16_t kMotorSpeedMax = 1000;
constexpr Duration kBeepPause = std::chrono::seconds(1);
constexpr std::string_view kEsp32BootText = "pwm servo\r\nbegin\r\n";

bool known(std::uint8_t id) {
  return id >= 1 && id <= LscBoard::kServos;
}

/// What the ESP32's firmware makes of a move before it carries it out.
Move esp32_clamped(const Move& move) {
  Move clamped;
  clamped.time_ms = std::clamp(move.time_ms, kEsp32TimeMin, kEsp32TimeMax);
  for (const ServoValue& servo : move.servos) {
    const std::uint16_t top = servo.id == 1 ? kEsp32GripperMax : kPulseMax;
    if (known(servo.id)) {
      clamped.servos.push_back({servo.id, std::clamp(servo.value, kPulseMin, top)});
    }
  }
  return clamped;
}

}  // namespace

LscBoard::LscBoard(LscProfile profile, Instant boot)
    : profile_(profile),
      now_(boot),
      decoder_(profile == LscProfile::kEsp32 ? LengthRule::kAnything : LengthRule::kBounded) {
  power_cycle(boot);
}

Dialect LscBoard::dialect() const {
  switch (profile_) {
    case LscProfile::kBus:
      return Dialect::kBus;
    case LscProfile::kEsp32:
      return Dialect::kEsp32;
    case LscProfile::kLsc6:
      break;
  }
  return Dialect::kLsc6;
}

LscBoard::Memory LscBoard::memory() const {
  Memory memory;
  for (std::size_t i = 0; i < kServos; ++i) {
    memory.push_back(static_cast<std::uint8_t>(servos_[i].saved_offset));
    const Parameters limits =
        written_info(static_cast<std::uint8_t>(i + 1), servos_[i].limits, BusServoSenses{});
    for (std::size_t k = 0; k + 1 < kServoBytes; ++k) memory.push_back(limits[k]);
  }
  for (const std::uint8_t byte : groups_.memory()) memory.push_back(byte);
  return memory;
}

bool LscBoard::set_memory(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kServos * kServoBytes) return false;
  std::array<BusServoLimits, kServos> limits;
  for (std::size_t i = 0; i < kServos; ++i) {
    const auto read = read_limits(Parameters(bytes.subspan(i * kServoBytes + 1, kServoBytes - 1)));
    if (!read) return false;
    limits[i] = read->second;
  }
  if (!groups_.set_memory(bytes.subspan(kServos * kServoBytes))) return false;
  for (std::size_t i = 0; i < kServos; ++i) {
    servos_[i].offset = servos_[i].saved_offset = static_cast<std::int8_t>(bytes[i * kServoBytes]);
    servos_[i].limits = limits[i];
  }
  return true;
}

void LscBoard::power_cycle(Instant now) {
  now_ = std::max(now_, now);
  decoder_.reset();
  output_.clear();
  groups_.stop();
  groups_.forget_speeds();
  for (Servo& servo : servos_) {
    const double measured = servo.measured;
    const std::int8_t offset = servo.saved_offset;
    const BusServoLimits limits = servo.limits;
    servo = {.driven = false,
             .from = kBootUnits,
             .to = kBootUnits,
             .start = now_,
             .duration = Duration::zero(),
             .measured = measured,
             .offset = offset,
             .saved_offset = offset,
             .limits = limits};
  }
  if (profile_ != LscProfile::kEsp32) return;
  for (const char character : kEsp32BootText) {
    output_.push_back(static_cast<std::uint8_t>(character));
  }
}

void LscBoard::receive(std::span<const std::uint8_t> bytes, Instant now) {
  advance(now);
  const std::uint64_t skipped = decoder_.skipped();
  for (const std::uint8_t byte : bytes) {
    const auto frame = decoder_.push(byte);
    if (!frame) continue;
    const auto request = decode_request(*frame, dialect());
    if (request) {
      take(*request);
    } else {
      ++beeps_;
    }
  }
  if (decoder_.skipped() != skipped) ++beeps_;
}

void LscBoard::advance(Instant now) {
  SINEW_ASSERT(now >= now_);
  // Each round goes on at its own instant, so that the next action starts exactly there.
  while (groups_.due() && *groups_.due() <= now) {
    now_ = std::max(now_, *groups_.due());
    const std::uint8_t group = groups_.group();
    const std::uint16_t times = groups_.times();
    if (const auto action = groups_.next()) {
      start(*action);
    } else if (profile_ != LscProfile::kEsp32) {
      say(GroupFinished{group, times});
    }
  }
  now_ = now;
  if (supply_volts_ < kBeepVolts && (!beeped_ || now_ - *beeped_ >= kBeepPause)) {
    beeped_ = now_;
    ++beeps_;
  }
}

std::size_t LscBoard::take_output(std::span<std::uint8_t> out) {
  return output_.take_front(out);
}

double LscBoard::at(const Servo& servo) const {
  const Duration gone = now_ - servo.start;
  if (servo.motor) {
    const double wanted = servo.from + servo.motor_units_s * to_seconds(gone);
    return std::clamp(wanted, servo.measured - kMotorLead, servo.measured + kMotorLead);
  }
  if (gone >= servo.duration) return servo.to;
  return servo.from + (servo.to - servo.from) * to_seconds(gone) / to_seconds(servo.duration);
}

double LscBoard::commanded(std::uint8_t id) const {
  return at(servo(id));
}

LscBoard::Command LscBoard::command(std::uint8_t id) const {
  const Servo& it = servo(id);
  return {it.driven, at(it) + it.offset};
}

void LscBoard::sense_position(std::uint8_t id, double units) {
  servo(id).measured = units - servo(id).offset;
}

bool LscBoard::moving() const {
  return std::any_of(servos_.begin(), servos_.end(), [&](const Servo& servo) {
    if (servo.motor) return servo.driven && servo.motor_units_s != 0;
    return servo.driven && now_ - servo.start < servo.duration;
  });
}

bool LscBoard::acceptable(const Move& move) const {
  const bool bus = profile_ == LscProfile::kBus;
  return std::all_of(move.servos.begin(), move.servos.end(), [&](const ServoValue& servo) {
    if (!known(servo.id)) return false;
    if (bus) return servo.value <= kBusMax || servo.value == kLeavePosition;
    return servo.value >= kPulseMin && servo.value <= kPulseMax;
  });
}

void LscBoard::start(const Move& move) {
  for (const ServoValue& target : move.servos) {
    if (target.value == kLeavePosition) continue;
    Servo& it = servo(target.id);
    if (it.motor) continue;
    const bool bus = profile_ == LscProfile::kBus;
    it.from = bus && !it.driven ? it.measured : at(it);
    it.to = target.value;
    if (bus) it.to = std::clamp<double>(it.to, it.limits.position_min, it.limits.position_max);
    it.start = now_;
    it.duration = std::chrono::milliseconds(move.time_ms);
    it.driven = true;
  }
}

void LscBoard::run_group(std::uint8_t group, std::uint16_t times) {
  if (!groups_.run(group, times, now_)) {
    ++beeps_;
    return;
  }
  if (profile_ != LscProfile::kEsp32) say(GroupStarted{group, times});
  advance(now_);
}

void LscBoard::press_run(bool held, Instant now) {
  advance(now);
  run_group(kButtonGroup, held ? 0 : 1);
}

void LscBoard::take(const Request& request) {
  bool right = true;
  if (const auto* move = std::get_if<Move>(&request)) {
    const bool clamps = profile_ == LscProfile::kEsp32;
    right = clamps || acceptable(*move);
    if (right) start(clamps ? esp32_clamped(*move) : *move);
  } else if (const auto* run = std::get_if<RunGroup>(&request)) {
    run_group(run->group, run->times);
  } else if (std::holds_alternative<StopGroup>(request)) {
    if (groups_.stop() && profile_ != LscProfile::kEsp32) say(GroupStopped{});
  } else if (const auto* erase = std::get_if<EraseGroup>(&request)) {
    if (erase->group == kAllGroups || profile_ == LscProfile::kEsp32) {
      groups_.erase_all();
    } else {
      groups_.erase(erase->group);
    }
    say(GroupErased{});
  } else if (const auto* speed = std::get_if<SetGroupSpeed>(&request)) {
    groups_.set_speed(speed->group, speed->percent);
  } else if (std::holds_alternative<ReadBattery>(request)) {
    const double millivolts = std::clamp(supply_volts_ * 1000, 0.0, 65535.0);
    say(Battery{static_cast<std::uint16_t>(std::lround(millivolts))});
  } else if (const auto* step = std::get_if<GroupStep>(&request)) {
    right = take_group_step(*step);
  } else {
    right = profile_ == LscProfile::kBus ? take_bus(request) : take_esp32(request);
  }
  if (!right) ++beeps_;
}

bool LscBoard::take_group_step(const GroupStep& step) {
  if (step.kind == GroupStep::Kind::kBegin) {
    if (step.value > LscGroups::kGroupMax) return false;
    download_group_ = step.value;
    download_place_ = 0;
  } else if (step.kind == GroupStep::Kind::kAction) {
    // Blocks are how the board's memory is cut; the order of the actions is the order of the group.
    if (!acceptable(step.move)) return false;
    if (!groups_.store(download_group_, download_place_, step.move)) return false;
    ++download_place_;
  }
  say(GroupStepTaken{static_cast<std::uint8_t>(step.kind)});
  return true;
}

bool LscBoard::for_each(const ServoIds& ids, auto&& action) {
  if (!std::all_of(ids.begin(), ids.end(), known)) return false;
  for (const std::uint8_t id : ids) action(id, servo(id));
  return true;
}

bool LscBoard::take_offset(const ServoOffset& offset) {
  if (!known(offset.id) || std::abs(offset.offset) > kOffsetMax) return false;
  servo(offset.id).offset = offset.offset;
  return true;
}

bool LscBoard::take_bus(const Request& request) {
  if (const auto* unload = std::get_if<Unload>(&request)) {
    return for_each(unload->ids, [](std::uint8_t, Servo& it) { it.driven = it.motor = false; });
  }
  if (const auto* read = std::get_if<ReadPositions>(&request)) {
    Positions positions;
    const bool right = for_each(read->ids, [&](std::uint8_t id, const Servo& it) {
      const double units = std::clamp(it.measured, 0.0, 65535.0);
      positions.servos.push_back({id, static_cast<std::uint16_t>(std::lround(units))});
    });
    if (right) say(positions);
    return right;
  }
  if (const auto* store = std::get_if<StoreBusOffsets>(&request)) {
    return for_each(store->ids, [](std::uint8_t, Servo& it) { it.saved_offset = it.offset; });
  }
  if (const auto* read = std::get_if<ReadBusOffsets>(&request)) {
    BusOffsets offsets;
    const bool right = for_each(read->ids, [&](std::uint8_t id, const Servo& it) {
      offsets.servos.push_back({id, it.offset});
    });
    if (right) say(offsets);
    return right;
  }
  if (const auto* adjust = std::get_if<AdjustBusOffset>(&request)) {
    if (std::abs(adjust->offset) > kOffsetMax) return false;
    return take_offset({adjust->id, static_cast<std::int8_t>(adjust->offset)});
  }
  if (const auto* mode = std::get_if<SetMode>(&request)) return take_mode(*mode);
  if (const auto* write = std::get_if<WriteBusInfo>(&request)) return take_info(write->parameters);
  if (!std::holds_alternative<ReadBusInfo>(request)) return false;
  say(info());
  return true;
}

bool LscBoard::take_mode(const SetMode& mode) {
  if (!known(mode.id) || mode.mode > 1 || std::abs(mode.speed) > kMotorSpeedMax) return false;
  Servo& it = servo(mode.id);
  it.from = it.to = it.measured;
  it.start = now_;
  it.duration = Duration::zero();
  it.driven = true;
  it.motor = mode.mode == 1;
  it.motor_units_s = it.motor ? mode.speed * kMotorUnitsPerS / kMotorSpeedMax : 0;
  return true;
}

bool LscBoard::take_info(const Parameters& info) {
  const auto limits = read_limits(info);
  if (!limits || !known(limits->first)) return false;
  for (Servo& it : servos_) it.limits = limits->second;
  return true;
}

BusInfo LscBoard::info() const {
  const Servo& it = servos_[0];
  const double millivolts = std::clamp(supply_volts_ * 1000, 0.0, 65535.0);
  return {written_info(1, it.limits,
                       {it.offset, static_cast<std::int16_t>(std::lround(it.measured)),
                        static_cast<std::uint16_t>(std::lround(millivolts))})};
}

bool LscBoard::take_esp32(const Request& request) {
  if (std::holds_alternative<ReadVersion>(request)) {
    say(Version{1, 1});
  } else if (std::holds_alternative<ReadOffsets>(request)) {
    Offsets offsets;
    for (std::uint8_t id = 1; id <= kServos; ++id) {
      offsets.servos[id - 1U] = {id, servo(id).offset};
    }
    say(offsets);
  } else if (const auto* offset = std::get_if<SetOffset>(&request)) {
    return take_offset(offset->servo);
  } else if (std::holds_alternative<SaveOffsets>(request)) {
    for (Servo& it : servos_) it.saved_offset = it.offset;
    say(OffsetsSaved{});
  } else if (std::holds_alternative<GoHome>(request)) {
    Move home{kEsp32HomeTime, {}};
    for (std::uint8_t id = 1; id <= kServos; ++id) {
      home.servos.push_back({id, static_cast<std::uint16_t>(kBootUnits)});
    }
    start(home);
  } else if (std::holds_alternative<ReadCommanded>(request)) {
    Commanded commanded_now;
    for (std::uint8_t id = 1; id <= kServos; ++id) {
      const auto units = static_cast<std::uint16_t>(std::lround(commanded(id)));
      commanded_now.servos[id - 1U] = {id, units};
    }
    say(commanded_now);
  } else if (const auto* action = std::get_if<StoreAction>(&request)) {
    if (!groups_.store(action->group, action->index, esp32_clamped(action->move))) return false;
    say(ActionStored{});
  } else if (const auto* by = std::get_if<Jog>(&request)) {
    return jog(*by);
  } else {
    return std::holds_alternative<Chassis>(request);
  }
  return true;
}

bool LscBoard::jog(const Jog& by) {
  JogPulses at_now{};
  for (std::size_t i = 0; i < at_now.size(); ++i) at_now[i] = commanded(kJogServos[i]);
  const auto target = jogged(at_now, by);
  if (!target) return false;
  Move move{kEsp32JogTime, {}};
  for (std::size_t i = 0; i < at_now.size(); ++i) {
    move.servos.push_back({kJogServos[i], static_cast<std::uint16_t>(std::lround((*target)[i]))});
  }
  start(move);
  return true;
}

void LscBoard::say(const Reply& reply) {
  const Bytes bytes = encode(reply);
  if (output_.size() + bytes.size() > output_.capacity()) {
    bytes_lost_ += bytes.size();
    return;
  }
  for (const std::uint8_t byte : bytes) output_.push_back(byte);
}

}  // namespace sinew
