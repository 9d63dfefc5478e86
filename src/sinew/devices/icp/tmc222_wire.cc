#include "sinew/devices/icp/tmc222_wire.h"

#include <optional>

#include "sinew/core/assert.h"

namespace sinew::tmc222 {
namespace {

constexpr std::uint8_t kFiller = 0xFF;

enum CommandByte : std::uint8_t {
  kGetFullStatus1 = 0x81,
  kGetOtpParam = 0x82,
  kGotoSecurePosition = 0x84,
  kHardStop = 0x85,
  kResetPosition = 0x86,
  kResetToDefault = 0x87,
  kRunInit = 0x88,
  kSetMotorParam = 0x89,
  kSetPosition = 0x8B,
  kSoftStop = 0x8F,
  kGetFullStatus2 = 0xFC,
};

template <class... Cases>
struct Overload : Cases... {
  using Cases::operator()...;
};

constexpr std::uint8_t byte_of(unsigned bits) {
  return static_cast<std::uint8_t>(bits & 0xFFU);
}

constexpr unsigned bit(bool set, unsigned place) {
  return (set ? 1U : 0U) << place;
}

constexpr std::uint8_t nibbles(std::uint8_t high, std::uint8_t low) {
  return byte_of((high & 15U) << 4 | (low & 15U));
}

void put_word(CommandBytes& out, std::int16_t word) {
  const auto bits = static_cast<std::uint16_t>(word);
  out.push_back(byte_of(bits >> 8U));
  out.push_back(byte_of(bits));
}

std::int16_t take_word(std::span<const std::uint8_t> bytes) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(bytes[0] << 8U | bytes[1]));
}

constexpr unsigned kAddressLow = 0x1FU;   // OTP3..OTP0 HW
constexpr unsigned kAddressTop = 0x60U;   // of a 7-bit address
constexpr unsigned kAddressOnes = 0xE0U;  // of the address byte of an answer

/// Ending of a ramp byte: Shaft and Acc.
constexpr unsigned shaft_acceleration(const Parameters& p) {
  return bit(p.shaft, 4) | (p.acceleration & 15U);
}

void put_parameters(CommandBytes& out, const Parameters& p) {
  out.push_back(nibbles(p.run_current, p.hold_current));
  out.push_back(nibbles(p.velocity_max, p.velocity_min));
  out.push_back(byte_of((p.secure_position >> 8U & 7U) << 5U | shaft_acceleration(p)));
  out.push_back(byte_of(p.secure_position));
  out.push_back(byte_of(0xE3U | bit(p.acceleration_shape, 4) | (p.step_mode & 3U) << 2U));
}

Parameters take_parameters(std::span<const std::uint8_t> bytes) {
  Parameters p;
  p.run_current = byte_of(bytes[0] >> 4U);
  p.hold_current = byte_of(bytes[0] & 15U);
  p.velocity_max = byte_of(bytes[1] >> 4U);
  p.velocity_min = byte_of(bytes[1] & 15U);
  p.secure_position = static_cast<std::uint16_t>((bytes[2] >> 5U) << 8U | bytes[3]);
  p.shaft = (bytes[2] & 0x10U) != 0;
  p.acceleration = byte_of(bytes[2] & 15U);
  p.acceleration_shape = (bytes[4] & 0x10U) != 0;
  p.step_mode = byte_of(bytes[4] >> 2U & 3U);
  return p;
}

/// Bytes of a whole command, 0 for an unknown one.
constexpr std::size_t command_length(std::uint8_t command) {
  switch (command) {
    case kGetFullStatus1:
    case kGetOtpParam:
    case kGotoSecurePosition:
    case kHardStop:
    case kResetPosition:
    case kResetToDefault:
    case kSoftStop:
    case kGetFullStatus2:
      return 1;
    case kSetPosition:
      return 5;
    case kRunInit:
    case kSetMotorParam:
      return 8;
    default:
      return 0;
  }
}

Command parse(std::span<const std::uint8_t> bytes) {
  switch (bytes[0]) {
    case kGetFullStatus1:
      return GetFullStatus1{};
    case kGetOtpParam:
      return GetOtpParam{};
    case kGotoSecurePosition:
      return GotoSecurePosition{};
    case kHardStop:
      return HardStop{};
    case kResetPosition:
      return ResetPosition{};
    case kResetToDefault:
      return ResetToDefault{};
    case kSoftStop:
      return SoftStop{};
    case kSetPosition:
      return SetPosition{take_word(bytes.subspan(3))};
    case kRunInit:
      return RunInit{byte_of(bytes[3] >> 4U), byte_of(bytes[3] & 15U), take_word(bytes.subspan(4)),
                     take_word(bytes.subspan(6))};
    case kSetMotorParam:
      return SetMotorParam{take_parameters(bytes.subspan(3))};
    default:
      return GetFullStatus2{};
  }
}

}  // namespace

std::int32_t wrapped(std::int64_t position, std::uint8_t step_mode) {
  const int bits = position_bits(step_mode);
  const std::int64_t span = std::int64_t{1} << bits;
  const std::int64_t low = position & (span - 1);
  return static_cast<std::int32_t>(low >= span / 2 ? low - span : low);
}

std::int32_t secure_target(const Parameters& parameters) {
  // 11 bits are the upper ones of the position, whatever its width.
  const int shift = position_bits(parameters.step_mode) - 11;
  return wrapped(std::int64_t{parameters.secure_position} << shift, parameters.step_mode);
}

CommandBytes encode_command(const Command& command) {
  CommandBytes out;
  const auto plain = [&](std::uint8_t byte) { out.push_back(byte); };
  const auto filled = [&](std::uint8_t byte) {
    out.push_back(byte);
    out.push_back(kFiller);
    out.push_back(kFiller);
  };
  std::visit(Overload{[&](const GetFullStatus1&) { plain(kGetFullStatus1); },
                      [&](const GetFullStatus2&) { plain(kGetFullStatus2); },
                      [&](const GetOtpParam&) { plain(kGetOtpParam); },
                      [&](const GotoSecurePosition&) { plain(kGotoSecurePosition); },
                      [&](const HardStop&) { plain(kHardStop); },
                      [&](const SoftStop&) { plain(kSoftStop); },
                      [&](const ResetPosition&) { plain(kResetPosition); },
                      [&](const ResetToDefault&) { plain(kResetToDefault); },
                      [&](const RunInit& m) {
                        filled(kRunInit);
                        out.push_back(nibbles(m.velocity_max, m.velocity_min));
                        put_word(out, m.first);
                        put_word(out, m.second);
                      },
                      [&](const SetMotorParam& m) {
                        filled(kSetMotorParam);
                        put_parameters(out, m.parameters);
                      },
                      [&](const SetPosition& m) {
                        filled(kSetPosition);
                        put_word(out, m.target);
                      }},
             command);
  SINEW_ASSERT(out.size() == command_length(out[0]));
  return out;
}

std::expected<Command, Refusal> decode_command(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return std::unexpected(Refusal::kLength);
  if (bytes[0] == kSetOtpParam) return std::unexpected(Refusal::kForbidden);
  const std::size_t length = command_length(bytes[0]);
  if (length == 0) return std::unexpected(Refusal::kUnknown);
  if (bytes.size() != length) return std::unexpected(Refusal::kLength);
  return parse(bytes);
}

Answer encode_status1(const Status1& status) {
  const Parameters& p = status.parameters;
  const Flags& f = status.flags;
  return {byte_of(kAddressOnes | (status.address & kAddressLow)),
          nibbles(p.run_current, p.hold_current),
          nibbles(p.velocity_max, p.velocity_min),
          byte_of(bit(p.acceleration_shape, 7) | (p.step_mode & 3U) << 5U | shaft_acceleration(p)),
          byte_of(bit(f.vdd_reset, 7) | bit(f.step_loss, 6) | bit(f.electrical_defect, 5) |
                  bit(f.under_voltage, 4) | bit(f.thermal_shutdown, 3) | bit(f.thermal_warning, 2) |
                  (f.temperature & 3U)),
          byte_of(static_cast<unsigned>(status.motion) << 5U | bit(status.external_switch, 4) |
                  bit(f.over_current_1, 3) | bit(f.over_current_2, 2) | 2U |
                  bit(f.charge_pump_failure, 0)),
          kFiller,
          kFiller};
}

Answer encode_status2(const Status2& status) {
  const auto actual = static_cast<std::uint16_t>(status.actual);
  const auto target = static_cast<std::uint16_t>(status.target);
  return {byte_of(kAddressOnes | (status.address & kAddressLow)),
          byte_of(actual >> 8U),
          byte_of(actual),
          byte_of(target >> 8U),
          byte_of(target),
          byte_of(status.secure_position),
          byte_of(0xF8U | (status.secure_position >> 8U & 7U)),
          kFiller};
}

std::expected<Status1, Refusal> decode_status1(std::span<const std::uint8_t, kAnswerSize> bytes) {
  const bool fixed = (bytes[0] & kAddressOnes) == kAddressOnes && (bytes[5] & 2U) != 0 &&
                     bytes[6] == kFiller && bytes[7] == kFiller;
  if (!fixed) return std::unexpected(Refusal::kUnknown);
  Status1 status;
  status.address = byte_of(kAddressTop | (bytes[0] & kAddressLow));
  Parameters& p = status.parameters;
  p.run_current = byte_of(bytes[1] >> 4U);
  p.hold_current = byte_of(bytes[1] & 15U);
  p.velocity_max = byte_of(bytes[2] >> 4U);
  p.velocity_min = byte_of(bytes[2] & 15U);
  p.acceleration_shape = (bytes[3] & 0x80U) != 0;
  p.step_mode = byte_of(bytes[3] >> 5U & 3U);
  p.shaft = (bytes[3] & 0x10U) != 0;
  p.acceleration = byte_of(bytes[3] & 15U);
  Flags& f = status.flags;
  f.vdd_reset = (bytes[4] & 0x80U) != 0;
  f.step_loss = (bytes[4] & 0x40U) != 0;
  f.electrical_defect = (bytes[4] & 0x20U) != 0;
  f.under_voltage = (bytes[4] & 0x10U) != 0;
  f.thermal_shutdown = (bytes[4] & 8U) != 0;
  f.thermal_warning = (bytes[4] & 4U) != 0;
  f.temperature = byte_of(bytes[4] & 3U);
  status.motion = static_cast<Motion>(bytes[5] >> 5U);
  status.external_switch = (bytes[5] & 0x10U) != 0;
  f.over_current_1 = (bytes[5] & 8U) != 0;
  f.over_current_2 = (bytes[5] & 4U) != 0;
  f.charge_pump_failure = (bytes[5] & 1U) != 0;
  return status;
}

std::expected<Status2, Refusal> decode_status2(std::span<const std::uint8_t, kAnswerSize> bytes) {
  const bool fixed = (bytes[0] & kAddressOnes) == kAddressOnes && (bytes[6] & 0xF8U) == 0xF8U &&
                     bytes[7] == kFiller;
  if (!fixed) return std::unexpected(Refusal::kUnknown);
  return Status2{.address = byte_of(kAddressTop | (bytes[0] & kAddressLow)),
                 .actual = take_word(bytes.subspan(1)),
                 .target = take_word(bytes.subspan(3)),
                 .secure_position = static_cast<std::uint16_t>((bytes[6] & 7U) << 8U | bytes[5])};
}

Answer encode_otp(std::uint8_t address, const Parameters& defaults) {
  // The hardware pin is not in the OTP, so of the address four bits stand here.
  return {0,
          0,
          byte_of(address >> 1U & 15U),
          nibbles(defaults.run_current, defaults.hold_current),
          nibbles(defaults.velocity_max, defaults.velocity_min),
          byte_of((defaults.secure_position >> 8U & 7U) << 5U | shaft_acceleration(defaults)),
          byte_of(defaults.secure_position),
          byte_of((defaults.step_mode & 3U) << 2U)};
}

}  // namespace sinew::tmc222
