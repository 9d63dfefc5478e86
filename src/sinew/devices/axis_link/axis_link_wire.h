#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <variant>

#include "sinew/core/instant.h"
#include "sinew/devices/encoder/encoder_wire_magnet.h"

/// Sinew's own link to an axis controller: one frame of 16 bytes each way, at the same time. All
/// integers are little endian, the last four bytes are the CRC-32C of the twelve before. The page
/// is docs/wires/axis_link.md. Everything here is @rt.
namespace sinew::axis_link {

inline constexpr std::uint8_t kVersion = 1;  ///< 1..7; 0 and a line of zeros is nobody's frame
inline constexpr std::size_t kFrameSize = 16;
inline constexpr std::size_t kAxes = 8;
using Frame = std::array<std::uint8_t, kFrameSize>;

/// A frame this far ahead of the last one executed is new; everything else is old. At the highest
/// rate, 2000 frames/s, this is 0.5 s: longer than the longest deadline.
inline constexpr std::uint16_t kSequenceWindow = 1024;

inline constexpr Duration kDeadlineMin = std::chrono::milliseconds(20);
inline constexpr Duration kDeadlineMax = std::chrono::milliseconds(500);
inline constexpr Duration kDeadlineDefault = std::chrono::milliseconds(100);

enum class Mode : std::uint8_t {
  kRead = 0,           ///< goes on with whatever it does; keeps the deadline away
  kHold = 1,           ///< stays where it is; decelerates first where it moves
  kTrack = 2,          ///< target and velocity at the next setpoint
  kMove = 3,           ///< to the target, with a profile of its own
  kHome = 4,           ///< starts homing
  kCancel = 5,         ///< ends homing
  kStop = 6,           ///< decelerates and holds; also without a session
  kEmergencyStop = 7,  ///< at once, latched; also without a session
  kRelease = 8,        ///< the latch; resumes nothing
  kClearFaults = 9,
  kSelfTest = 10,
  kHello = 11,       ///< opens a session: target is the model hash, velocity the deadline in ms
  kReadHealth = 12,  ///< as kRead; the next answer is a Health
  kReadSetup = 13,   ///< as kRead; the next answer is the setup's word number `velocity`
  kWriteSetup = 14,  ///< at rest: the setup's word number `velocity` shall be `target`
  kStoreSetup = 15,  ///< at rest: keeps the setup that was written, and starts again with it
};
inline constexpr std::uint8_t kModeLast = 15;

/// What the host sends.
struct Request {
  std::uint8_t axis = 0;  ///< 0..7
  bool to_all = false;    ///< every axis that hears it; only for kStop and kEmergencyStop
  Mode mode = Mode::kRead;
  std::uint16_t sequence = 0;
  std::int32_t target = 0;    ///< position units
  std::int32_t velocity = 0;  ///< velocity units, 24 bits
  std::uint8_t session = 0;   ///< as the axis gave it in its Identity
  friend bool operator==(const Request&, const Request&) = default;
};

/// What became of the last frame that was executed; without a session: kNoSession.
enum class Verdict : std::uint8_t {
  kAccepted = 0,
  kNotHomed = 1,
  kOutOfLimits = 2,
  kFaulted = 3,
  kEmergencyStopped = 4,
  kBusy = 5,
  kNoSession = 6,  ///< nothing was executed; also after a hello for another model
};

/// The axis as it was when the frame began.
struct State {
  std::int32_t position = 0;  ///< position units
  std::int16_t velocity = 0;  ///< 2^-10 rad/s, saturated: the upper 16 bits of velocity units
  bool motor_ok = false;
  bool sensor_ok = false;
  bool communication_ok = false;
  bool position_ok = false;
  bool homed = false;
  bool homing = false;
  bool moving = false;
  bool end_stop = false;
  bool emergency_stopped = false;
  std::uint8_t fault = 0;  ///< 0..15; 0 none, see fault table
  Verdict verdict = Verdict::kAccepted;
  friend bool operator==(const State&, const State&) = default;
};

/// Answer to a hello.
struct Identity {
  std::uint32_t model_hash = 0;
  std::uint16_t boot = 0;         ///< counts the axis's starts
  std::uint16_t uncertainty = 0;  ///< of its position: 2^-20 rad
  friend bool operator==(const Identity&, const Identity&) = default;
};

/// Answer to kReadHealth.
struct Health {
  std::optional<std::uint16_t> supply_mv;       ///< FFFF on the wire: not measured
  std::optional<std::int16_t> temperature_c01;  ///< 0.01 deg C; 8000 on the wire: not measured
  Magnet motor_magnet = Magnet::kUnknown;
  Magnet joint_magnet = Magnet::kUnknown;
  friend bool operator==(const Health&, const Health&) = default;
};

/// What a board keeps about its axis, as its device reads and writes it (axis_device_setup.h).
inline constexpr std::size_t kSetupSize = 384;
inline constexpr std::size_t kSetupWords = kSetupSize / 4;
using SetupBytes = std::array<std::uint8_t, kSetupSize>;

/// The first word of a board's image identity (wire/board_image.h), read as the setup's words are.
inline constexpr std::size_t kImageWord = 256;

/// Answer to kReadSetup: four bytes of what the board keeps about its axis, little endian.
struct SetupWord {
  std::uint32_t value = 0;
  std::uint16_t index = 0;
  friend bool operator==(const SetupWord&, const SetupWord&) = default;
};

/// What the axis sends in the same clocks.
struct Reply {
  std::uint8_t axis = 0;
  std::uint8_t session = 0;    ///< 0: none is open
  std::uint16_t sequence = 0;  ///< of the last frame that it executed
  std::variant<State, Identity, Health, SetupWord> body;
  friend bool operator==(const Reply&, const Reply&) = default;
};

/// Why 16 bytes are not a frame; the checks are made in this order.
enum class Reject : std::uint8_t {
  kChecksum,
  kOtherVersion,  ///< good, and of another version; its meaning is unknown
  kContent,       ///< a request where an answer was due, an unknown mode, or a reserved bit
};

Frame encode(const Request& request);
Frame encode(const Reply& reply);
std::expected<Request, Reject> decode_request(std::span<const std::uint8_t, kFrameSize> bytes);
std::expected<Reply, Reject> decode_reply(std::span<const std::uint8_t, kFrameSize> bytes);

/// Version of a frame with a good checksum.
constexpr std::uint8_t version_of(std::uint8_t head) {
  return static_cast<std::uint8_t>(head >> 5);
}

/// True where `sequence` is 1..kSequenceWindow ahead of `last`, around 65536.
constexpr bool is_newer(std::uint16_t sequence, std::uint16_t last) {
  const auto ahead = static_cast<std::uint16_t>(sequence - last);
  return ahead >= 1 && ahead <= kSequenceWindow;
}

// Units. 2^-26 rad is 0.85 millionth of a degree; +-32 rad are five turns either way.
inline constexpr double kUnitsPerRad = 1 << 26;
inline constexpr double kVelocityUnits = 1 << 18;         ///< per rad/s: 2^-18 rad/s, +-32 rad/s
inline constexpr double kStateVelocityUnits = 1 << 10;    ///< per rad/s
inline constexpr double kUncertaintyUnits = 1 << 20;      ///< per rad
inline constexpr std::int32_t kVelocityMax = 0x7F'FFFF;   ///< 24 bits
inline constexpr std::int32_t kVelocityMin = -0x80'0000;  ///< 24 bits

/// Nearest unit; nothing where `q` (rad) is no number or does not fit.
std::optional<std::int32_t> to_units(double q);
constexpr double from_units(std::int32_t units) {
  return units / kUnitsPerRad;
}
/// Nearest unit of rad/s; nothing where it is no number or does not fit.
std::optional<std::int32_t> to_velocity_units(double qd);

/// What both ends must agree on before anything moves; rad and its derivatives by s.
struct AxisModel {
  std::uint8_t axis = 0;
  double lower = 0;
  double upper = 0;
  double velocity_max = 0;
  double acceleration_max = 0;
  double jerk_max = 0;
};

/// CRC-32C over the axis and the five numbers, each as a 64-bit count of 2^-26.
std::uint32_t model_hash(const AxisModel& model);

/// @pre kDeadlineMin <= deadline <= kDeadlineMax, axis < kAxes
Request hello(std::uint8_t axis, std::uint16_t sequence, std::uint32_t hash, Duration deadline);

}  // namespace sinew::axis_link
