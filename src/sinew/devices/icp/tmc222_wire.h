#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>
#include <variant>

#include "sinew/core/fixed_vector.h"

/// The I2C messages of the TMC222 stepper module, as bytes behind its slave address. Words are big
/// endian. Source: TMC222 data sheet V1.12, 5.2 (registers) and 6.8 (commands). All @rt.
///
/// There is no SetOTPParam (90) here: it cannot be undone, and at this machine's 12 V it may
/// destroy the chip. Neither encoder nor decoder has a path for it.
namespace sinew::tmc222 {

inline constexpr std::size_t kCommandMax = 8;
inline constexpr std::size_t kAnswerSize = 8;

using CommandBytes = FixedVector<std::uint8_t, kCommandMax>;
using Answer = std::array<std::uint8_t, kAnswerSize>;

/// Command byte of what must never be sent.
inline constexpr std::uint8_t kSetOtpParam = 0x90;

/// A position in the secure-position register that switches it off; 0 is a place like any other.
inline constexpr std::uint16_t kSecurePositionOff = 0x400;

/// The RAM that SetMotorParam fills; codes, not units.
struct Parameters {
  std::uint8_t run_current = 0;       ///< 0..15 into kPeakCurrent
  std::uint8_t hold_current = 0;      ///< the same
  std::uint8_t velocity_max = 0;      ///< 0..15 into kVelocityMax
  std::uint8_t velocity_min = 0;      ///< n/32 of the maximum; 0: the maximum itself
  std::uint16_t secure_position = 0;  ///< 11 bits
  bool shaft = false;                 ///< turns the other way
  std::uint8_t acceleration = 0;      ///< 0..15 into kAcceleration
  bool acceleration_shape = false;    ///< no ramps: velocity_min throughout
  std::uint8_t step_mode = 0;         ///< 0..3: half, quarter, eighth, sixteenth steps
  friend bool operator==(const Parameters&, const Parameters&) = default;
};

/// mA, peak, by code. Source: table 12.
inline constexpr std::array<double, 16> kPeakCurrent{59,  71,  84,  100, 119, 141, 168, 200,
                                                     238, 283, 336, 400, 476, 566, 673, 800};
/// Full steps per s, by code. Source: table 13.
inline constexpr std::array<double, 16> kVelocityMax{99,  136, 167, 197, 213, 228, 243, 273,
                                                     303, 334, 364, 395, 456, 546, 729, 973};
/// Full steps per s^2, by code, as the higher velocities have them. Source: table 15.
inline constexpr std::array<double, 16> kAcceleration{49,    218,   1004,  3609,  6228,  8848,
                                                      11409, 13970, 16531, 19092, 21886, 24447,
                                                      27008, 29570, 34925, 40047};

/// Lowest speed of a ramp, full steps per s.
constexpr double velocity_min(const Parameters& parameters) {
  const double top = kVelocityMax[parameters.velocity_max];
  return parameters.velocity_min == 0 ? top : top * parameters.velocity_min / 32;
}

/// Microsteps in one full step: 2, 4, 8 or 16.
constexpr int microsteps(std::uint8_t step_mode) {
  return 2 << step_mode;
}
/// Bits of a position: 13, 14, 15 or 16; it counts microsteps and wraps.
constexpr int position_bits(std::uint8_t step_mode) {
  return 13 + step_mode;
}
/// `position`, wrapped to what the step mode's register holds.
std::int32_t wrapped(std::int64_t position, std::uint8_t step_mode);
/// Where GotoSecurePosition goes, in microsteps: 32 of them a count at sixteenth steps.
std::int32_t secure_target(const Parameters& parameters);

/// What the motor is doing, bits 7..5 of the sixth status byte.
enum class Motion : std::uint8_t {
  kAtTarget = 0,
  kAcceleratingUp = 1,
  kDeceleratingUp = 2,
  kTopSpeedUp = 3,
  kNotAtTarget = 4,  ///< stopped
  kAcceleratingDown = 5,
  kDeceleratingDown = 6,
  kTopSpeedDown = 7,
};

/// What a GetFullStatus1 tells, and thereby clears.
struct Flags {
  bool vdd_reset = false;          ///< lost its RAM since the last question
  bool step_loss = false;          ///< steps may be lost; positioning is blocked
  bool electrical_defect = false;  ///< a coil is open or shorted
  bool under_voltage = false;      ///< UV2
  bool thermal_shutdown = false;
  bool thermal_warning = false;
  std::uint8_t temperature = 0;  ///< 0 normal, 1 cold, 2 hot, 3 shut down
  bool over_current_1 = false;
  bool over_current_2 = false;
  bool charge_pump_failure = false;
  friend bool operator==(const Flags&, const Flags&) = default;
};

/// What of them is no wear and no warmth: something went wrong, or will.
constexpr bool tells_trouble(const Flags& flags) {
  return flags.vdd_reset || flags.step_loss || flags.electrical_defect || flags.under_voltage ||
         flags.thermal_shutdown || flags.thermal_warning || flags.over_current_1 ||
         flags.over_current_2 || flags.charge_pump_failure;
}

struct Status1 {
  std::uint8_t address = 0x60;  ///< 7 bits, 60..7F
  Parameters parameters{};      ///< without the secure position
  Flags flags{};
  Motion motion = Motion::kAtTarget;
  bool external_switch = false;
  friend bool operator==(const Status1&, const Status1&) = default;
};

struct Status2 {
  std::uint8_t address = 0x60;
  std::int16_t actual = 0;
  std::int16_t target = 0;
  std::uint16_t secure_position = 0;
  friend bool operator==(const Status2&, const Status2&) = default;
};

struct GetFullStatus1 {
  friend bool operator==(const GetFullStatus1&, const GetFullStatus1&) = default;
};
struct GetFullStatus2 {
  friend bool operator==(const GetFullStatus2&, const GetFullStatus2&) = default;
};
struct GetOtpParam {
  friend bool operator==(const GetOtpParam&, const GetOtpParam&) = default;
};
struct GotoSecurePosition {
  friend bool operator==(const GotoSecurePosition&, const GotoSecurePosition&) = default;
};
struct HardStop {
  friend bool operator==(const HardStop&, const HardStop&) = default;
};
struct SoftStop {
  friend bool operator==(const SoftStop&, const SoftStop&) = default;
};
/// Actual and target position become 0. Ignored in motion.
struct ResetPosition {
  friend bool operator==(const ResetPosition&, const ResetPosition&) = default;
};
/// RAM becomes what the OTP holds.
struct ResetToDefault {
  friend bool operator==(const ResetToDefault&, const ResetToDefault&) = default;
};
/// To `first` at these speeds, then to `second` at the lowest; that place becomes 0.
struct RunInit {
  std::uint8_t velocity_max = 0;
  std::uint8_t velocity_min = 0;
  std::int16_t first = 0;
  std::int16_t second = 0;
  friend bool operator==(const RunInit&, const RunInit&) = default;
};
struct SetMotorParam {
  Parameters parameters;
  friend bool operator==(const SetMotorParam&, const SetMotorParam&) = default;
};
struct SetPosition {
  std::int16_t target = 0;
  friend bool operator==(const SetPosition&, const SetPosition&) = default;
};

using Command =
    std::variant<GetFullStatus1, GetFullStatus2, GetOtpParam, GotoSecurePosition, HardStop,
                 SoftStop, ResetPosition, ResetToDefault, RunInit, SetMotorParam, SetPosition>;

/// Bytes behind the address.
CommandBytes encode_command(const Command& command);

/// Why bytes are no command.
enum class Refusal : std::uint8_t {
  kForbidden,  ///< SetOTPParam: never to be passed on
  kUnknown,
  kLength,
};

/// One whole write behind the address. Filler bytes may be anything.
std::expected<Command, Refusal> decode_command(std::span<const std::uint8_t> bytes);

Answer encode_status1(const Status1& status);
Answer encode_status2(const Status2& status);

/// Nothing where a bit that the chip always sends as 1 is 0.
std::expected<Status1, Refusal> decode_status1(std::span<const std::uint8_t, kAnswerSize> bytes);
std::expected<Status2, Refusal> decode_status2(std::span<const std::uint8_t, kAnswerSize> bytes);

/// The OTP of a chip with these defaults: calibration bytes as 0, address bits in the third.
Answer encode_otp(std::uint8_t address, const Parameters& defaults);

}  // namespace sinew::tmc222
