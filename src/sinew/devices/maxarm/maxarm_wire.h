#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "sinew/core/fixed_vector.h"

/// The MaxArm's wire: `AA 55 function length data sum`, 9600 baud, little endian; the sum is the
/// complement of the bytes from function to the end of the data. Nothing that moves is answered;
/// two questions are. docs/wires/maxarm.md has the tables. Everything here is @rt.
namespace sinew::maxarm {

inline constexpr std::size_t kServos = 3;
inline constexpr std::size_t kDataMax = 8;
inline constexpr std::size_t kFrameMax = kDataMax + 5;
inline constexpr std::size_t kReplyFrame = 11;

/// Servos to pulses: 0..1000 is 0..240 degrees of the servo.
struct SetAngle {
  std::array<std::uint16_t, kServos> pulses{};
  std::uint16_t time_ms = 0;
  friend bool operator==(const SetAngle&, const SetAngle&) = default;
};
/// The nozzle to a point of the firmware's frame, by the firmware's own inverse kinematics.
struct SetXyz {
  std::array<std::int16_t, 3> xyz_mm{};
  std::uint16_t time_ms = 0;
  friend bool operator==(const SetXyz&, const SetXyz&) = default;
};
/// The servo that turns the nozzle: 500..2500 us is 0..180 degrees.
struct SetPwmServo {
  std::uint16_t pulse_us = 0;
  std::uint16_t time_ms = 0;
  friend bool operator==(const SetPwmServo&, const SetPwmServo&) = default;
};
/// 1 pump on; 2 pump off and valve open; 3 all off. The device ignores others.
struct SetSuction {
  std::uint8_t action = 3;
  friend bool operator==(const SetSuction&, const SetSuction&) = default;
};
struct ReadAngle {
  friend bool operator==(const ReadAngle&, const ReadAngle&) = default;
};
struct ReadXyz {
  friend bool operator==(const ReadXyz&, const ReadXyz&) = default;
};
using Request = std::variant<SetAngle, SetXyz, SetPwmServo, SetSuction, ReadAngle, ReadXyz>;

struct Angles {
  std::array<std::int16_t, kServos> pulses{};  ///< signed: a dead servo answers -1
  friend bool operator==(const Angles&, const Angles&) = default;
};
struct Position {
  std::array<std::int16_t, 3> xyz_mm{};
  friend bool operator==(const Position&, const Position&) = default;
};
using Reply = std::variant<Angles, Position>;

/// What the sum of a reply covers; a request's is always kSpec.
enum class Checksum : std::uint8_t {
  kSpec,        ///< function, length, data
  kWithHeader,  ///< AA and 55 as well, which makes it one more
};

/// A reply as it came.
struct ReplyFrame {
  Reply reply;
  Checksum checksum = Checksum::kSpec;
  friend bool operator==(const ReplyFrame&, const ReplyFrame&) = default;
};

using FrameBytes = FixedVector<std::uint8_t, kFrameMax>;

FrameBytes encode_request(const Request& request);
FrameBytes encode_reply(const Reply& reply, Checksum checksum);

/// True where a device takes nothing else for this request when one of its bytes is lost, one is
/// doubled or one bit is flipped on the way, and the head of another frame follows.
///
/// A flipped bit never fits the sum. A lost byte b moves the sum into the data and AA, the next
/// frame's head, into the sum's place: it fits exactly where b is AA. A doubled byte b moves the
/// last data byte into the sum's place: it fits exactly where b is the sum itself.
bool survives_one_fault(const FrameBytes& frame);

/// True where a MicroPython board that looks at its port in the middle of this frame takes nothing
/// else for it, with READ_ANGLE behind it and zeros or READ_XYZ behind that. It forgets the data
/// bytes that it had, takes the rest and the next frame for data, and some byte for the sum.
bool survives_a_look(const FrameBytes& frame);

/// Host side: bytes to replies. AA AA 55 is a beginning, noise is skipped, and a frame that turns
/// out wrong is looked through again behind its first byte, since a good one may begin inside.
class ReplyDecoder {
 public:
  /// A reply where this byte completes one; a reply that fits both sums does not exist.
  std::optional<ReplyFrame> push(std::uint8_t byte);
  void reset() { bytes_.clear(); }
  /// True between replies.
  bool at_boundary() const { return bytes_.empty(); }
  /// Bytes that belonged to no reply, since construction.
  std::uint64_t skipped() const { return skipped_; }

 private:
  void drop_first();
  bool is_beginning() const;

  FixedVector<std::uint8_t, kReplyFrame> bytes_;
  std::uint64_t skipped_ = 0;
};

/// Device side, with the faults that both of the maker's programs have: AA AA 55 loses the frame,
/// and what is wrong (function, length, sum) is dropped without a word.
class RequestDecoder {
 public:
  /// A request where this byte completes one.
  std::optional<Request> push(std::uint8_t byte);
  /// The MicroPython program reads the port ten times a second and forgets between two looks how
  /// many data bytes it has, but not that it is among them.
  void begin_poll() { data_.clear(); }
  void reset();
  bool at_boundary() const { return step_ == Step::kHead; }

 private:
  enum class Step : std::uint8_t { kHead, kSecond, kFunction, kLength, kData, kSum };

  Step step_ = Step::kHead;
  std::uint8_t function_ = 0;
  std::uint8_t length_ = 0;
  FixedVector<std::uint8_t, kDataMax> data_;
  std::uint8_t sum_due_ = 0;
  Request request_;  ///< complete but for its sum
};

}  // namespace sinew::maxarm
