#include "sinew/devices/axis_link/axis_link_wire.h"

#include <bit>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"
#include "sinew/wire/crc32c.h"

namespace sinew::axis_link {
namespace {

// Byte 0: version in bits 7..5, kind in 4..3, axis in 2..0.
enum class Kind : std::uint8_t { kRequest = 0, kState = 1, kIdentity = 2, kMore = 3 };
// Bytes 10..11 of an answer of kind kMore say which.
constexpr std::uint16_t kIsHealth = 0;
constexpr std::uint16_t kIsSetupWord = 1;

constexpr std::size_t kBody = kFrameSize - 4;
constexpr std::uint8_t kToAll = 0x80;
constexpr std::uint8_t kModeBits = 0x0F;
constexpr std::uint16_t kNoSupply = 0xFFFF;
constexpr std::int16_t kNoTemperature = std::numeric_limits<std::int16_t>::min();

// Flags of a state: bits 0..8, verdict 9..11, fault 12..15.
constexpr unsigned kVerdictShift = 9;
constexpr unsigned kFaultShift = 12;
constexpr auto kVerdictLast = static_cast<unsigned>(Verdict::kNoSession);

constexpr std::uint8_t head(Kind kind, std::uint8_t axis) {
  return static_cast<std::uint8_t>(kVersion << 5 | static_cast<unsigned>(kind) << 3 | axis);
}

template <std::size_t Bytes>
void put(Frame& frame, std::size_t place, std::uint32_t value) {
  for (std::size_t k = 0; k < Bytes; ++k) {
    frame[place + k] = static_cast<std::uint8_t>(value >> (8 * k));
  }
}

template <std::size_t Bytes>
std::uint32_t get(std::span<const std::uint8_t, kFrameSize> frame, std::size_t place) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < Bytes; ++k) {
    value |= static_cast<std::uint32_t>(frame[place + k]) << (8 * k);
  }
  return value;
}

std::uint16_t get16(std::span<const std::uint8_t, kFrameSize> frame, std::size_t place) {
  return static_cast<std::uint16_t>(get<2>(frame, place));
}

void seal(Frame& frame) {
  put<4>(frame, kBody, crc32c(std::span(frame).first<kBody>()));
}

/// The checks that both directions share; the kind where they pass.
std::expected<Kind, Reject> check(std::span<const std::uint8_t, kFrameSize> bytes) {
  if (crc32c(bytes.first<kBody>()) != get<4>(bytes, kBody)) {
    return std::unexpected(Reject::kChecksum);
  }
  if (version_of(bytes[0]) != kVersion) return std::unexpected(Reject::kOtherVersion);
  return static_cast<Kind>(bytes[0] >> 3 & 3);
}

std::uint16_t flags_of(const State& state) {
  SINEW_ASSERT(state.fault < 16);
  unsigned flags = 0;
  flags |= state.motor_ok ? 1U << 0 : 0;
  flags |= state.sensor_ok ? 1U << 1 : 0;
  flags |= state.communication_ok ? 1U << 2 : 0;
  flags |= state.position_ok ? 1U << 3 : 0;
  flags |= state.homed ? 1U << 4 : 0;
  flags |= state.homing ? 1U << 5 : 0;
  flags |= state.moving ? 1U << 6 : 0;
  flags |= state.end_stop ? 1U << 7 : 0;
  flags |= state.emergency_stopped ? 1U << 8 : 0;
  flags |= static_cast<unsigned>(state.verdict) << kVerdictShift;
  flags |= static_cast<unsigned>(state.fault) << kFaultShift;
  return static_cast<std::uint16_t>(flags);
}

State state_of(std::span<const std::uint8_t, kFrameSize> bytes) {
  const unsigned flags = get16(bytes, 10);
  return {.position = std::bit_cast<std::int32_t>(get<4>(bytes, 4)),
          .velocity = std::bit_cast<std::int16_t>(get16(bytes, 8)),
          .motor_ok = (flags >> 0 & 1) != 0,
          .sensor_ok = (flags >> 1 & 1) != 0,
          .communication_ok = (flags >> 2 & 1) != 0,
          .position_ok = (flags >> 3 & 1) != 0,
          .homed = (flags >> 4 & 1) != 0,
          .homing = (flags >> 5 & 1) != 0,
          .moving = (flags >> 6 & 1) != 0,
          .end_stop = (flags >> 7 & 1) != 0,
          .emergency_stopped = (flags >> 8 & 1) != 0,
          .fault = static_cast<std::uint8_t>(flags >> kFaultShift),
          .verdict = static_cast<Verdict>(flags >> kVerdictShift & 7)};
}

Kind put_body(Frame& frame, const State& state) {
  put<4>(frame, 4, std::bit_cast<std::uint32_t>(state.position));
  put<2>(frame, 8, std::bit_cast<std::uint16_t>(state.velocity));
  put<2>(frame, 10, flags_of(state));
  return Kind::kState;
}

Kind put_body(Frame& frame, const Identity& identity) {
  put<4>(frame, 4, identity.model_hash);
  put<2>(frame, 8, identity.boot);
  put<2>(frame, 10, identity.uncertainty);
  return Kind::kIdentity;
}

Kind put_body(Frame& frame, const Health& health) {
  put<2>(frame, 4, health.supply_mv.value_or(kNoSupply));
  put<2>(frame, 6, std::bit_cast<std::uint16_t>(health.temperature_c01.value_or(kNoTemperature)));
  frame[8] = static_cast<std::uint8_t>(static_cast<unsigned>(health.motor_magnet) |
                                       static_cast<unsigned>(health.joint_magnet) << 4);
  put<2>(frame, 10, kIsHealth);
  return Kind::kMore;
}

Kind put_body(Frame& frame, const SetupWord& word) {
  put<4>(frame, 4, word.value);
  put<2>(frame, 8, word.index);
  put<2>(frame, 10, kIsSetupWord);
  return Kind::kMore;
}

Health health_of(std::span<const std::uint8_t, kFrameSize> bytes) {
  Health health;
  const std::uint16_t supply = get16(bytes, 4);
  const auto temperature = std::bit_cast<std::int16_t>(get16(bytes, 6));
  if (supply != kNoSupply) health.supply_mv = supply;
  if (temperature != kNoTemperature) health.temperature_c01 = temperature;
  health.motor_magnet = static_cast<Magnet>(bytes[8] & 0xF);
  health.joint_magnet = static_cast<Magnet>(bytes[8] >> 4);
  return health;
}

bool is_magnet(int number) {
  return number <= static_cast<int>(kMagnetLast);
}

/// Nearest whole number; nothing outside [lower, upper] or for NaN.
std::optional<std::int32_t> rounded(double value, double lower, double upper) {
  const double nearest = std::round(value);
  if (!(nearest >= lower && nearest <= upper)) return std::nullopt;
  return static_cast<std::int32_t>(nearest);
}

}  // namespace

Frame encode(const Request& request) {
  SINEW_ASSERT(request.axis < kAxes);
  SINEW_ASSERT(request.velocity >= kVelocityMin && request.velocity <= kVelocityMax);
  Frame frame{};
  frame[0] = head(Kind::kRequest, request.axis);
  frame[1] = static_cast<std::uint8_t>((request.to_all ? kToAll : 0) |
                                       static_cast<unsigned>(request.mode));
  put<2>(frame, 2, request.sequence);
  put<4>(frame, 4, std::bit_cast<std::uint32_t>(request.target));
  put<3>(frame, 8, std::bit_cast<std::uint32_t>(request.velocity));
  frame[11] = request.session;
  seal(frame);
  return frame;
}

Frame encode(const Reply& reply) {
  SINEW_ASSERT(reply.axis < kAxes);
  Frame frame{};
  frame[1] = reply.session;
  put<2>(frame, 2, reply.sequence);
  const Kind kind = std::visit([&](const auto& body) { return put_body(frame, body); }, reply.body);
  frame[0] = head(kind, reply.axis);
  seal(frame);
  return frame;
}

std::expected<Request, Reject> decode_request(std::span<const std::uint8_t, kFrameSize> bytes) {
  const auto kind = check(bytes);
  if (!kind) return std::unexpected(kind.error());
  const std::uint8_t mode = bytes[1] & kModeBits;
  const bool known = (bytes[1] & ~(kToAll | kModeBits)) == 0 && mode <= kModeLast;
  const bool to_all = (bytes[1] & kToAll) != 0;
  const bool for_all = mode == static_cast<std::uint8_t>(Mode::kStop) ||
                       mode == static_cast<std::uint8_t>(Mode::kEmergencyStop);
  if (*kind != Kind::kRequest || !known || (to_all && !for_all)) {
    return std::unexpected(Reject::kContent);
  }
  // The sign of 24 bits is moved to the top and back.
  const auto velocity = std::bit_cast<std::int32_t>(get<3>(bytes, 8) << 8) >> 8;
  return Request{.axis = static_cast<std::uint8_t>(bytes[0] & 7),
                 .to_all = to_all,
                 .mode = static_cast<Mode>(mode),
                 .sequence = get16(bytes, 2),
                 .target = std::bit_cast<std::int32_t>(get<4>(bytes, 4)),
                 .velocity = velocity,
                 .session = bytes[11]};
}

std::expected<Reply, Reject> decode_reply(std::span<const std::uint8_t, kFrameSize> bytes) {
  const auto kind = check(bytes);
  if (!kind) return std::unexpected(kind.error());
  Reply reply{.axis = static_cast<std::uint8_t>(bytes[0] & 7),
              .session = bytes[1],
              .sequence = get16(bytes, 2),
              .body = {}};
  switch (*kind) {
    case Kind::kRequest:
      return std::unexpected(Reject::kContent);
    case Kind::kState:
      if ((get16(bytes, 10) >> kVerdictShift & 7) > kVerdictLast) {
        return std::unexpected(Reject::kContent);
      }
      reply.body = state_of(bytes);
      break;
    case Kind::kIdentity:
      reply.body = Identity{get<4>(bytes, 4), get16(bytes, 8), get16(bytes, 10)};
      break;
    case Kind::kMore: {
      const std::uint16_t which = get16(bytes, 10);
      if (which == kIsSetupWord) {
        reply.body = SetupWord{get<4>(bytes, 4), get16(bytes, 8)};
      } else if (which == kIsHealth && bytes[9] == 0 && is_magnet(bytes[8] & 0xF) &&
                 is_magnet(bytes[8] >> 4)) {
        reply.body = health_of(bytes);
      } else {
        return std::unexpected(Reject::kContent);
      }
      break;
    }
  }
  return reply;
}

std::optional<std::int32_t> to_units(double q) {
  return rounded(q * kUnitsPerRad, std::numeric_limits<std::int32_t>::min(),
                 std::numeric_limits<std::int32_t>::max());
}

std::optional<std::int32_t> to_velocity_units(double qd) {
  return rounded(qd * kVelocityUnits, kVelocityMin, kVelocityMax);
}

std::uint32_t model_hash(const AxisModel& model) {
  std::array<std::uint8_t, 1 + 5 * 8> bytes{model.axis};
  std::size_t place = 1;
  for (const double number :
       {model.lower, model.upper, model.velocity_max, model.acceleration_max, model.jerk_max}) {
    SINEW_ASSERT(std::abs(number) < 0x1p36);
    const auto units = std::bit_cast<std::uint64_t>(std::int64_t{std::llround(number * 0x1p26)});
    for (unsigned shift = 0; shift < 64; shift += 8) {
      bytes[place++] = static_cast<std::uint8_t>(units >> shift);
    }
  }
  return crc32c(bytes);
}

Request hello(std::uint8_t axis, std::uint16_t sequence, std::uint32_t hash, Duration deadline) {
  SINEW_ASSERT(deadline >= kDeadlineMin && deadline <= kDeadlineMax);
  const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(deadline).count();
  return {.axis = axis,
          .mode = Mode::kHello,
          .sequence = sequence,
          .target = std::bit_cast<std::int32_t>(hash),
          .velocity = static_cast<std::int32_t>(milliseconds)};
}

}  // namespace sinew::axis_link
