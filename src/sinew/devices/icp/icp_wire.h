#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <variant>

#include "sinew/core/fixed_vector.h"
#include "sinew/devices/icp/tmc222_wire.h"

/// The hexapod's wire: single bytes up, single bytes and 12-byte status blocks down. A byte means
/// what the place in its exchange says; docs/wires/icp.md draws it. Everything here is @rt.
namespace sinew::icp {

inline constexpr std::uint8_t kMotors = 6;
inline constexpr std::size_t kStatusSize = 12;

/// From the host.
inline constexpr std::uint8_t kSync = 0x10;     ///< back to the loop, from anywhere; no reply
inline constexpr std::uint8_t kInit = 0xFF;     ///< opens every exchange
inline constexpr std::uint8_t kWake = 0xC0;     ///< first document table only
inline constexpr std::uint8_t kKill = 0xE0;     ///< deaf until its power is cut; no reply
inline constexpr std::uint8_t kRequest = 0xF0;  ///< status request

/// From the device.
inline constexpr std::uint8_t kAck = 0x00;
inline constexpr std::uint8_t kErrorOnes = 0x11;
inline constexpr std::uint8_t kErrorParity = 0x22;

/// What the device's firmware writes into every motor module at boot: 566 mA run and hold, top
/// speed, sixteenth steps, secure position 0. Source: the document, 89 FF FF DD FF 0F 00 EF.
inline constexpr tmc222::Parameters kMotorParameters{.run_current = 0xD,
                                                     .hold_current = 0xD,
                                                     .velocity_max = 0xF,
                                                     .velocity_min = 0xF,
                                                     .secure_position = 0,
                                                     .shaft = false,
                                                     .acceleration = 0xF,
                                                     .acceleration_shape = false,
                                                     .step_mode = 3};

struct Init {
  friend bool operator==(const Init&, const Init&) = default;
};
struct Sync {
  friend bool operator==(const Sync&, const Sync&) = default;
};
struct Wake {
  friend bool operator==(const Wake&, const Wake&) = default;
};
struct Kill {
  friend bool operator==(const Kill&, const Kill&) = default;
};
struct StatusRequest {
  friend bool operator==(const StatusRequest&, const StatusRequest&) = default;
};
/// One position unit of one motor.
struct Step {
  std::uint8_t motor = 1;  ///< 1..6
  bool direction = false;  ///< bit 3
  friend bool operator==(const Step&, const Step&) = default;
};
/// Whose status is wanted.
struct Select {
  std::uint8_t motor = 1;  ///< 1..6
  friend bool operator==(const Select&, const Select&) = default;
};

using Request = std::variant<Init, Sync, Wake, Kill, StatusRequest, Step, Select>;

/// Why a byte in the command's or the selector's place is nothing.
enum class Refusal : std::uint8_t {
  kOnes,     ///< bits 6..4 do not count the ones of bits 3..0
  kParity,   ///< an odd number of ones
  kNoMotor,  ///< motor 0 or 7
};

/// Positioning byte: motor in bits 2..0, direction in bit 3, number of ones in them in bits 6..4,
/// even parity in bit 7.
std::uint8_t encode_step(const Step& step);

/// The device's checks of a positioning byte, ones before parity before motor.
std::expected<Step, Refusal> decode_step(std::uint8_t byte);

/// A selector is the motor's number alone: one that fails the checks of a positioning byte, so
/// that it moves nothing where it is taken for one.
std::uint8_t encode_request(const Request& request);

/// What a firmware reads differently from the next one.
struct Dialect {
  bool knows_wake = true;        ///< C0 is a command; else it fails the check of its ones
  bool checks_selector = false;  ///< a selector must be a whole positioning byte
};

/// Device side.
///
///   state    | byte                        | next, result
///   ---------+-----------------------------+----------------------------------------
///   kLoop    | FF                          | kCommand, Init
///   kLoop    | anything else               | kLoop, nothing
///   kCommand | 10                          | kLoop, Sync
///   kCommand | E0                          | kDead, Kill
///   kCommand | F0                          | kSelector, StatusRequest
///   kCommand | C0, where it is known       | kLoop, Wake
///   kCommand | anything else               | kLoop, Step or a refusal
///   kSelector| 10                          | kLoop, Sync
///   kSelector| anything else               | kLoop, Select or a refusal
///   kDead    | anything                    | kDead, nothing
class RequestDecoder {
 public:
  enum class State : std::uint8_t { kLoop, kCommand, kSelector, kDead };

  explicit RequestDecoder(Dialect dialect = {}) : dialect_(dialect) {}
  /// What this byte is, where it is anything.
  std::optional<std::expected<Request, Refusal>> push(std::uint8_t byte);
  State state() const { return state_; }

 private:
  std::expected<Request, Refusal> read_command(std::uint8_t byte);
  std::expected<Request, Refusal> read_selector(std::uint8_t byte);

  Dialect dialect_;
  State state_ = State::kLoop;
};

/// The 12 bytes of a status: six of either answer of the module, the address once.
struct Status {
  tmc222::Status1 one{};
  tmc222::Status2 two{};
  friend bool operator==(const Status&, const Status&) = default;
};

using StatusBytes = std::array<std::uint8_t, kStatusSize>;

StatusBytes encode_status(const Status& status);
/// @error kUnknown: a bit that is always 1 is 0.
std::expected<Status, tmc222::Refusal> decode_status(
    std::span<const std::uint8_t, kStatusSize> bytes);

struct Ack {
  friend bool operator==(const Ack&, const Ack&) = default;
};
struct Refused {
  Refusal why{};  ///< kOnes or kParity
  friend bool operator==(const Refused&, const Refused&) = default;
};
using Reply = std::variant<Ack, Refused, Status>;

/// A status is its ACK and the block; refusals for want of a motor go as 11.
using ReplyBytes = FixedVector<std::uint8_t, kStatusSize + 1>;
ReplyBytes encode_reply(const Reply& reply);

/// A byte that fits nothing; everything since the last expect() is void.
struct Garbage {
  std::uint8_t seen = 0;
  friend bool operator==(const Garbage&, const Garbage&) = default;
};

/// Host side: the answer to one byte that was sent. Only who asked can know what 00 means, so it is
/// told what is due; a byte that comes unasked is garbage.
class ReplyDecoder {
 public:
  enum class Due : std::uint8_t { kNothing, kByte, kBlock };

  void expect(Due due);
  Due due() const { return due_; }
  /// The reply, or garbage, where this byte completes one. Nothing is due after either.
  std::optional<std::expected<Reply, Garbage>> push(std::uint8_t byte);

 private:
  Due due_ = Due::kNothing;
  FixedVector<std::uint8_t, kStatusSize + 1> bytes_;
};

}  // namespace sinew::icp
