#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>

#include "sinew/core/error.h"
#include "sinew/core/instant.h"
#include "sinew/mcu/encoder_node.h"

/// The RS-485 link between an axis board and its encoder node: `AA reg 55` asks, `AA reg lo hi 55`
/// answers. No checksum; AA and 55 occur in data, so both sides read by length and time-out.
/// docs/wires/encoder_link.md. Everything here is @rt.
namespace sinew::encoder_link {

inline constexpr std::uint8_t kStart = kEncoderStart;
inline constexpr std::uint8_t kEnd = kEncoderEnd;
inline constexpr std::size_t kRequestSize = 3;
inline constexpr std::size_t kReplySize = kEncoderNodeReplySize;
inline constexpr int kTurn = 4096;  ///< ticks

enum class Register : std::uint8_t {
  kPosition = kEncoderPosition,          ///< 0..4095 ticks
  kVelocity = kEncoderVelocity,          ///< ticks/s, two's complement, held at -32767..32767
  kAcceleration = kEncoderAcceleration,  ///< ticks/s^2, likewise
  kStatus = kEncoderStatus,              ///< ours, not the document's: the bits below
};

/// Bits of kStatus; 8..15 count refused I2C transactions, up to 255.
namespace status {
inline constexpr std::uint16_t kFresh = kEncoderFresh;      ///< POSITION is answered
inline constexpr std::uint16_t kMagnet = kEncoderMagnet;    ///< the chip sees one
inline constexpr std::uint16_t kTooWeak = kEncoderTooWeak;  ///< and it is nearly lost
inline constexpr std::uint16_t kTooStrong = kEncoderTooStrong;
inline constexpr std::uint16_t kBusError =
    kEncoderBusError;  ///< the chip did not acknowledge, last time
inline constexpr std::uint16_t kRestarted =
    kEncoderRestarted;  ///< turns may be lost since this was last read
inline constexpr std::uint16_t kSettled =
    kEncoderHasSpeed;  ///< VELOCITY and ACCELERATION are answered
}  // namespace status

struct Request {
  Register name = Register::kPosition;
  friend bool operator==(const Request&, const Request&) = default;
};

struct Reply {
  Register name = Register::kPosition;
  std::uint16_t value = 0;
  /// As kVelocity and kAcceleration mean it.
  std::int16_t as_signed() const { return static_cast<std::int16_t>(value); }
  friend bool operator==(const Reply&, const Reply&) = default;
};

using RequestBytes = std::array<std::uint8_t, kRequestSize>;
using ReplyBytes = std::array<std::uint8_t, kReplySize>;

RequestBytes encode(const Request& request);
ReplyBytes encode(const Reply& reply);

/// Why an answer is none.
enum class ReplyFault : std::uint8_t {
  kWrongStart,
  kWrongRegister,  ///< an answer to another question
  kWrongEnd,
  kOutOfRange,  ///< a position above 4095
};

/// The board's side: five bytes that answer one question. It never looks for a start inside an
/// answer: after a fault the caller waits for a quiet line and asks again.
class ReplyDecoder {
 public:
  explicit ReplyDecoder(Register asked) : asked_(asked) {}
  std::optional<std::expected<Reply, ReplyFault>> push(std::uint8_t byte);

 private:
  std::expected<Reply, ReplyFault> reply() const;

  Register asked_;
  std::size_t size_ = 0;
  ReplyBytes bytes_{};
};

/// Position over many turns from 0..4095 ticks: the nearest way round, so less than half a turn
/// between two readings. A reading that the shaft cannot have come to is held back; the second one
/// that agrees with it is believed, and the turns are then unknown. A gap in which half a turn was
/// possible loses them too.
class Unwrap {
 public:
  /// @param speed_max  ticks/s that the shaft can do
  explicit Unwrap(double speed_max) : speed_max_(speed_max) {}

  /// @param position  0..4095. @return  ticks since the first reading; nothing while held back.
  std::optional<std::int64_t> update(std::uint16_t position, Instant now);
  /// The turns since the first reading are counted without a doubt.
  bool certain() const { return certain_; }
  /// From here on they are (homing found the place).
  void trust() { certain_ = true; }

 private:
  static constexpr double kNoise = 4;  ///< ticks: noise of the chip and rounding

  double reach(Instant now) const;

  double speed_max_;
  bool started_ = false;
  bool certain_ = true;
  std::int64_t ticks_ = 0;
  Instant read_at_{};
  std::optional<std::uint16_t> doubted_;
};

/// The board's side of a conversation: one question at a time, each answered, refused or given up
/// after a time. It asks for nothing by itself.
///
///   state    | event                    | next, result
///   ---------+--------------------------+----------------------------------------------
///   idle     | ask                      | waiting
///   waiting  | five good bytes          | idle, the reply
///   waiting  | five bytes, a fault      | quiet, kUnexpectedReply
///   waiting  | reply_timeout passes     | quiet, kDeviceSilent
///   idle     | a byte                   | quiet (nobody asked; counted)
///   quiet    | a byte                   | quiet again, from this byte on
///   quiet    | quiet_time passes        | idle
class Conversation {
 public:
  struct Timing {
    /// "Less than 10 ms" in the document's drawing are eight bytes at 9600 baud and no pause.
    Duration reply_timeout = std::chrono::milliseconds(15);
    Duration quiet_time = std::chrono::milliseconds(3);  ///< > one byte at 9600 baud
  };

  explicit Conversation(const Timing& timing) : timing_(timing) {}

  bool ready(Instant now);
  /// @param now  when the request's last byte is through. @return  its bytes. Needs ready().
  RequestBytes ask(Register name, Instant now);
  /// @error kUnexpectedReply
  std::optional<Expected<Reply>> receive(std::uint8_t byte, Instant now);
  /// @error kDeviceSilent (measured, limit: s)
  std::optional<Expected<Reply>> poll(Instant now);
  std::uint64_t stray_bytes() const { return stray_bytes_; }

 private:
  enum class State : std::uint8_t { kIdle, kWaiting, kQuiet };

  Timing timing_;
  State state_ = State::kIdle;
  ReplyDecoder decoder_{Register::kPosition};
  Instant since_{};
  std::uint64_t stray_bytes_ = 0;
};

}  // namespace sinew::encoder_link
