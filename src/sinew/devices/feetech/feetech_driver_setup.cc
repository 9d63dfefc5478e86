#include "sinew/devices/feetech/feetech_driver_setup.h"

#include <algorithm>

#include "sinew/devices/feetech/feetech_driver_servos.h"

namespace sinew {

using namespace feetech;

namespace {

constexpr std::uint8_t kOrder = 2;
constexpr int kMiddle = 2048;
constexpr int kNear = 4;  // units: of a shaft at rest
constexpr int kTries = 3;

std::string number_of(std::uint8_t id) {
  return "servo " + std::to_string(id);
}

std::optional<Reply> asked(FeetechLine& line, const Read& read) {
  for (int i = 0; i < kTries; ++i) {
    if (auto reply = line.ask(read)) return reply;
  }
  return std::nullopt;
}

std::optional<FoundServo> read_servo(FeetechLine& line, std::uint8_t id) {
  const auto settings = asked(line, {id, 0, FeetechServos::kSettingsCount});
  const auto state = asked(line, {id, FeetechServos::kStateFrom, FeetechServos::kStateCount});
  if (!settings || !state) return std::nullopt;
  const std::span fixed(settings->data.data(), settings->data.size());
  const std::span now(state->data.data(), state->data.size());
  const bool sts = fixed[kOrder] == 0;
  const std::endian order = sts ? std::endian::little : std::endian::big;
  const auto at = [&](std::uint8_t address) {
    return static_cast<std::size_t>(address - FeetechServos::kStateFrom);
  };
  const auto signed_at = [&](std::uint8_t address, int sign) {
    return signed_word(word_at(now, at(address), order), sign);
  };
  FoundServo servo;
  servo.id = id;
  servo.series = sts ? FeetechSeries::kSts : FeetechSeries::kScs;
  servo.firmware_major = fixed[Register::kFirmware];
  servo.firmware_minor = fixed[Register::kFirmware + 1];
  servo.model = word_at(fixed, Register::kModel, std::endian::little);
  servo.lowest = word_at(fixed, Register::kLowest, order);
  servo.highest = word_at(fixed, Register::kHighest, order);
  servo.holds_positions = sts ? fixed[Register::kMode] == 0 : servo.highest != 0;
  servo.offset = sts ? signed_word(word_at(fixed, Register::kOffset, order), kOffsetSign) : 0;
  servo.position = signed_at(Register::kPosition, kPositionSign);
  servo.load = signed_at(Register::kLoad, kLoadSign) / 1000.0;
  servo.motor_on = now[at(Register::kTorque)] == 1;
  servo.volts = now[at(Register::kVolts)] / 10.0;
  servo.heat = now[at(Register::kHeat)];
  servo.trouble = state->trouble;
  return servo;
}

/// What is written between outlives the power.
void write_lasting(FeetechLine& line, const FoundServo& servo, std::uint8_t id_after,
                   const Write& write) {
  const bool sts = servo.series == FeetechSeries::kSts;
  const std::uint8_t lock = sts ? Register::kLockSts : Register::kLockScs;
  line.write(Write{servo.id, Register::kTorque, {0}, false});
  line.write(Write{servo.id, lock, {0}, false});
  line.write(write);
  line.write(Write{id_after, lock, {1}, false});
}

}  // namespace

FoundServos find_servos(FeetechLine& line, std::uint8_t last, bool (*each)(std::uint8_t)) {
  FoundServos found;
  for (unsigned id = 0; id <= last; ++id) {
    const auto number = static_cast<std::uint8_t>(id);
    if (!each(number)) break;
    const bool replies = line.ask({number, Register::kId, 1}).has_value();
    const bool garbled = line.garbled();
    if (!replies && !garbled) continue;
    if (const auto servo = read_servo(line, number)) {
      found.servos.push_back(*servo);
    } else {
      found.garbled.push_back(number);
    }
  }
  return found;
}

std::expected<FoundServo, std::string> find_servo(FeetechLine& line, std::uint8_t id) {
  if (const auto servo = read_servo(line, id)) return *servo;
  if (line.garbled()) {
    return std::unexpected("the replies of " + number_of(id) +
                           " are garbled: two servos have this number. Leave one of them on the "
                           "bus");
  }
  return std::unexpected(number_of(id) + " does not reply; sinew servos PORT lists those that do");
}

std::expected<FoundServo, std::string> change_id(FeetechLine& line, std::uint8_t from,
                                                 std::uint8_t to) {
  const auto servo = find_servo(line, from);
  if (!servo) return servo;
  if (from == to) return servo;
  const bool taken = line.ask({to, Register::kId, 1}).has_value() || line.garbled();
  if (taken) {
    return std::unexpected(number_of(to) + " is on the bus already; nothing was changed");
  }
  write_lasting(line, *servo, to, {from, Register::kId, {to}, false});
  const auto changed = find_servo(line, to);
  if (changed && changed->model == servo->model) return changed;
  return std::unexpected(number_of(from) +
                         " was told its new number and does not reply by it; "
                         "sinew servos PORT lists those that do");
}

std::expected<FoundServo, std::string> set_middle(FeetechLine& line, std::uint8_t id) {
  const auto servo = find_servo(line, id);
  if (!servo) return servo;
  if (servo->series != FeetechSeries::kSts) {
    return std::unexpected(number_of(id) +
                           " is of the SCS series, whose middle cannot be set: turn its horn");
  }
  // Written as an offset: not every firmware knows the order for it.
  const int actual = (servo->position + servo->offset + 4096) % 4096;
  int offset = actual - kMiddle;
  offset = std::clamp(offset, -2047, 2047);
  Data word;
  put_word(word, sign_and_magnitude(offset, kOffsetSign), std::endian::little);
  write_lasting(line, *servo, id, {id, Register::kOffset, word, false});
  const auto changed = find_servo(line, id);
  if (!changed) return changed;
  if (std::abs(changed->position - kMiddle) <= kNear) return changed;
  return std::unexpected(number_of(id) + " counts " + std::to_string(changed->position) +
                         " behind it, not 2048: hold it still, and try again");
}

}  // namespace sinew
