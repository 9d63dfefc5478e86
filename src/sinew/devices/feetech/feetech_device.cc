#include "sinew/devices/feetech/feetech_device.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::sim {

using namespace feetech;

namespace {

// Addresses that only the device itself uses.
constexpr std::uint8_t kOrder = 2;
constexpr std::uint8_t kPhase = 18;
constexpr std::uint8_t kUnload = 19;
constexpr std::uint8_t kStiffness = 21;
constexpr std::uint8_t kReplyFlag = 64;
constexpr std::uint8_t kFineSpeed = 0x04;
constexpr std::uint16_t kModelSts = 777;
constexpr std::uint16_t kModelScs = 1284;
constexpr double kPerPercent = 0.01;
constexpr double kFactoryStiffness = 32;
constexpr double kFactoryStiffnessScs = 15;
constexpr std::uint8_t kMiddle = 128;  // written to the torque's register

/// Where the two series keep how they protect themselves: torque meanwhile, time, and threshold.
struct Protection {
  std::uint8_t torque, time, threshold;
  double unit;  ///< s of its time
};
constexpr Protection kProtectionSts{34, 35, 36, 0.01};
constexpr Protection kProtectionScs{37, 38, 39, 0.04};

bool is_read_only(std::uint8_t address) {
  return address < Register::kId || address >= Register::kPosition;
}

}  // namespace

FeetechServo::FeetechServo(FeetechSeries series, std::uint8_t id, Instant boot)
    : series_(series), now_(boot) {
  lasting_[Register::kFirmware] = 3;
  lasting_[Register::kFirmware + 1] = 10;
  lasting_[kOrder] = sts() ? 0 : 1;
  const std::uint16_t model = sts() ? kModelSts : kModelScs;
  lasting_[Register::kModel] = static_cast<std::uint8_t>(model & 0xFF);
  lasting_[Register::kModel + 1] = static_cast<std::uint8_t>(model >> 8);
  lasting_[Register::kId] = id;
  lasting_[Register::kReplies] = 1;
  lasting_[Register::kHottest] = sts() ? 70 : 80;
  lasting_[Register::kVoltsMax] = sts() ? 80 : 90;
  lasting_[Register::kVoltsMin] = sts() ? 40 : 45;
  lasting_[kPhase] = sts() ? 12 : 0;
  lasting_[kUnload] = sts() ? 44 : 36;
  lasting_[kStiffness] =
      static_cast<std::uint8_t>(sts() ? kFactoryStiffness : kFactoryStiffnessScs);
  const Protection& protection = sts() ? kProtectionSts : kProtectionScs;
  lasting_[protection.torque] = 20;
  lasting_[protection.time] = sts() ? 200 : 100;
  lasting_[protection.threshold] = 80;
  set_settings(lasting_);
  set_word(Register::kHighest, static_cast<std::uint16_t>(units_max()));
  set_word(Register::kTorqueMax, 1000);
  power_cycle(boot);
}

void FeetechServo::set_settings(const Settings& settings) {
  lasting_ = settings;
  std::ranges::copy(settings, registers_.begin());
}

void FeetechServo::set_word(std::uint8_t address, std::uint16_t word) {
  Data data;
  put_word(data, word, order());
  std::ranges::copy(data, registers_.begin() + address);
  if (address < kSettings) std::ranges::copy(data, lasting_.begin() + address);
}

std::uint16_t FeetechServo::word(std::uint8_t address) const {
  return word_at(registers_, address, order());
}

int FeetechServo::offset() const {
  return sts() ? signed_word(word(Register::kOffset), kOffsetSign) : 0;
}

void FeetechServo::power_cycle(Instant now) {
  now_ = now;
  registers_.fill(0);
  std::ranges::copy(lasting_, registers_.begin());
  if (sts()) set_word(Register::kTorqueLimit, word(Register::kTorqueMax));
  kept_.reset();
  overload_ = speed_ = 0;
  protects_ = false;
}

std::optional<Data> FeetechServo::read(std::uint8_t address, std::uint8_t count) const {
  if (count > kDataMax || address + count > Register::kEnd) return std::nullopt;
  Data data;
  for (std::size_t i = 0; i < count; ++i) data.push_back(registers_[address + i]);
  return data;
}

void FeetechServo::write(std::uint8_t address, const Data& data) {
  const bool was_on = registers_[Register::kTorque] == 1;
  const std::uint8_t lock = registers_[sts() ? Register::kLockSts : Register::kLockScs];
  bool goal = false;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const auto at = static_cast<std::uint8_t>(address + i);
    if (address + i >= Register::kEnd || is_read_only(at)) continue;
    if (at == Register::kTorque && data[i] == kMiddle) {
      set_middle();
      continue;
    }
    registers_[at] = data[i];
    if (at < kSettings && lock == 0) lasting_[at] = data[i];
    goal = goal || at == Register::kGoal;
  }
  // Seen by users: a goal switches its motor on.
  if (goal) registers_[Register::kTorque] = 1;
  const bool on = registers_[Register::kTorque] == 1;
  if (on && !was_on) {
    profile_ = position_ - offset();
    speed_ = 0;
  }
  if (!on || goal) begin_goal();
}

/// A new goal, or its motor off, is what ends its protection.
void FeetechServo::begin_goal() {
  const double goal = signed_word(word(Register::kGoal), kPositionSign);
  const bool back = (goal - profile_) * (profile_ - (position_ - offset())) < 0;
  if (registers_[Register::kTorque] != 1 || back) {
    protects_ = false;
    overload_ = 0;
  }
}

void FeetechServo::action() {
  if (!kept_) return;
  const Write write = *kept_;
  kept_.reset();
  this->write(write.address, write.data);
}

void FeetechServo::set_middle() {
  if (!sts()) return;
  const int middle = static_cast<int>(units_max() + 1) / 2;
  set_word(Register::kOffset,
           sign_and_magnitude(static_cast<int>(std::lround(position_)) - middle, kOffsetSign));
}

FeetechServo::Command FeetechServo::command() const {
  Command command;
  command.units = profile_ + offset();
  const bool on = registers_[Register::kTorque] == 1;
  const double limit = sts() ? word(Register::kTorqueLimit) / 1000.0 : 1;
  const double held = registers_[(sts() ? kProtectionSts : kProtectionScs).torque] * kPerPercent;
  command.torque = on ? std::min(limit, protects_ ? held : 1.0) : 0;
  command.stiffness = registers_[kStiffness] / (sts() ? kFactoryStiffness : kFactoryStiffnessScs);
  return command;
}

/// Towards its goal, no faster than it was told, and no farther than its own limits.
void FeetechServo::advance(Instant now) {
  const double dt = to_seconds(now - now_);
  now_ = now;
  protect(dt);
  if (registers_[Register::kTorque] != 1 || dt <= 0) return;
  double goal = signed_word(word(Register::kGoal), kPositionSign);
  const double lowest = word(Register::kLowest);
  const double highest = word(Register::kHighest);
  if (lowest < highest) goal = std::clamp(goal, lowest, highest);
  const double way = goal - profile_;
  const double unit = sts() && (registers_[kPhase] & kFineSpeed) == 0 ? 50 : 1;
  const int told = signed_word(word(Register::kSpeed), kPositionSign);
  double speed = told == 0 ? 1e6 : unit * std::abs(told);
  const double acceleration = sts() ? 100.0 * registers_[Register::kAcceleration] : 0;
  if (acceleration > 0) {
    speed = std::min(speed, std::abs(speed_) + acceleration * dt);
    speed = std::min(speed, std::sqrt(2 * acceleration * std::abs(way)));
  }
  const double step = std::clamp(way, -speed * dt, speed * dt);
  speed_ = step / dt;
  profile_ += step;
}

/// What it complains of, and what it does about it.
void FeetechServo::protect(double dt) {
  const Protection& protection = sts() ? kProtectionSts : kProtectionScs;
  const bool on = registers_[Register::kTorque] == 1;
  const bool over = std::abs(duty_) > registers_[protection.threshold] * kPerPercent;
  overload_ = on && over ? overload_ + dt : 0;
  protects_ = protects_ || overload_ > registers_[protection.time] * protection.unit;
  const std::uint8_t volts = registers_[Register::kVolts];
  const bool supply =
      volts > registers_[Register::kVoltsMax] || volts < registers_[Register::kVoltsMin];
  const bool hot = registers_[Register::kHeat] > registers_[Register::kHottest];
  registers_[Register::kTrouble] =
      static_cast<std::uint8_t>((supply ? Trouble::kVoltage : 0) | (hot ? Trouble::kHeat : 0) |
                                (protects_ ? Trouble::kOverload : 0));
  if (hot && (registers_[kUnload] & Trouble::kHeat) != 0) registers_[Register::kTorque] = 0;
}

void FeetechServo::sense(const Senses& senses) {
  position_ = senses.units;
  duty_ = senses.duty;
  const auto reported = [](double value, int sign) {
    return sign_and_magnitude(static_cast<int>(std::lround(value)), sign);
  };
  set_word(Register::kPosition, reported(std::floor(senses.units) - offset(), kPositionSign));
  set_word(Register::kSpeedNow, reported(senses.speed, kPositionSign));
  set_word(Register::kLoad, reported(1000 * senses.duty, kLoadSign));
  registers_[Register::kVolts] =
      static_cast<std::uint8_t>(std::clamp(std::round(10 * senses.volts), 0.0, 255.0));
  registers_[Register::kHeat] = static_cast<std::uint8_t>(std::clamp(senses.heat, 0.0, 255.0));
  registers_[Register::kMoving] = std::abs(senses.speed) >= 1 ? 1 : 0;
  registers_[kReplyFlag] = kept_ ? 1 : 0;
}

void FeetechServo::hold() {
  set_word(Register::kGoal,
           sign_and_magnitude(static_cast<int>(std::floor(position_)) - offset(), kPositionSign));
  registers_[Register::kTorque] = 1;
  profile_ = std::floor(position_) - offset();
}

// The bus

FeetechBusDevice::FeetechBusDevice(FeetechSeries series, std::span<const std::uint8_t> ids,
                                   Instant boot)
    : series_(series) {
  SINEW_ASSERT(ids.size() <= kServosMax);
  for (const std::uint8_t id : ids) servos_.emplace_back(series, id, boot);
  plugged_.fill(true);
}

void FeetechBusDevice::power_cycle(Instant now) {
  for (FeetechServo& servo : servos_) servo.power_cycle(now);
  decoder_.reset();
  output_.clear();
}

void FeetechBusDevice::receive(std::span<const std::uint8_t> bytes, Instant /*now*/) {
  for (const std::uint8_t byte : bytes) {
    if (decoder_.push(byte) != PacketDecoder::Result::kPacket) continue;
    if (const auto request = decode_request(decoder_.packet())) hear(*request);
  }
}

std::size_t FeetechBusDevice::take_output(std::span<std::uint8_t> out) {
  return output_.take_front(out);
}

void FeetechBusDevice::reply(std::size_t i, const Data& data) {
  const Bytes bytes = encode(Reply{servos_[i].id(), servos_[i].trouble(), data});
  if (output_.size() + bytes.size() > output_.capacity()) {
    bytes_lost_ += bytes.size();
    return;
  }
  for (const std::uint8_t byte : bytes) output_.push_back(byte);
}

void FeetechBusDevice::hear(const Request& request) {
  const auto each = [&](std::uint8_t id, auto&& act) {
    for (std::size_t i = 0; i < servos_.size(); ++i) {
      if (plugged_[i] && (id == kBroadcast || servos_[i].id() == id)) act(i);
    }
  };
  if (const auto* ping = std::get_if<Ping>(&request)) {
    each(ping->id, [&](std::size_t i) { reply(i); });
  } else if (const auto* read = std::get_if<Read>(&request)) {
    each(read->id, [&](std::size_t i) {
      const auto data = servos_[i].read(read->address, read->count);
      if (data) reply(i, *data);
    });
  } else if (const auto* write = std::get_if<Write>(&request)) {
    each(write->id, [&](std::size_t i) {
      // What it is called before is what it replies as.
      const bool replies =
          write->id != kBroadcast && servos_[i].read(Register::kReplies, 1).value()[0] != 0;
      if (replies) reply(i);
      write->waits ? servos_[i].keep(*write) : servos_[i].write(write->address, write->data);
    });
  } else if (const auto* action = std::get_if<Action>(&request)) {
    each(action->id, [&](std::size_t i) { servos_[i].action(); });
  } else if (const auto* middle = std::get_if<SetMiddle>(&request)) {
    each(middle->id, [&](std::size_t i) {
      servos_[i].set_middle();
      if (middle->id != kBroadcast) reply(i);
    });
  } else if (const auto* all = std::get_if<SyncWrite>(&request)) {
    for (const SyncWrite::Part& part : all->parts) {
      each(part.id, [&](std::size_t i) { servos_[i].write(all->address, part.data); });
    }
  } else if (const auto* some = std::get_if<SyncRead>(&request);
             some && series_ == FeetechSeries::kSts) {
    for (const std::uint8_t id : some->ids) {
      bool heard = false;
      each(id, [&](std::size_t i) {
        const auto data = servos_[i].read(some->address, some->count);
        heard = data.has_value();
        if (data) reply(i, *data);
      });
      // Each waits for the one before it: nothing is known of what they do where that one is not
      // there, so they are taken to wait for ever.
      if (!heard) return;
    }
  }
}

}  // namespace sinew::sim
