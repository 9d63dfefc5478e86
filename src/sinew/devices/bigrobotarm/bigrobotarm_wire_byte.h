#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire.h"

/// The binary wire: id byte, payload, one 0D that closes the request. No length, no checksum, no
/// escape. Integers are little endian. Everything here is @rt.
namespace sinew::bigrobotarm::byte {

inline constexpr std::uint8_t kTerminator = 0x0D;
inline constexpr std::size_t kRequestMax = 21;
inline constexpr std::size_t kReplyMax = 71;

using RequestBytes = FixedVector<std::uint8_t, kRequestMax>;
using ReplyBytes = FixedVector<std::uint8_t, kReplyMax>;

/// Id and payload as the document prints them, without the closing 0D.
RequestBytes encode_request(const Request& request);

/// False where a 0D stands inside the request: the real device would cut it in two there and run
/// the rest as a command of its own.
bool sendable(const Request& request);

/// False where one of the value's four bytes is 0D.
bool sendable(std::int32_t word);

/// The bytes of one reply. A motion has two: MotionStarted{id} is the first 3 bytes, GotoDone or
/// HomeDone the other 25. `Accepted` and the queue do not exist on this wire, and a Status must
/// have its gripper: both assert.
ReplyBytes encode_reply(const Reply& reply);

/// Host side: bytes to replies, by the length that the head byte says. 0D 0A inside data is data.
/// After garbage it skips to the end of the next READY (C8 0D 0A); since that may stand inside
/// data too, a host trusts what follows only after a pause and a reset().
class ReplyDecoder {
 public:
  /// A reply, or garbage, where this byte completes one.
  std::optional<std::expected<Reply, Garbage>> push(std::uint8_t byte);
  /// Forgets what was begun.
  void reset();
  /// True between replies.
  bool at_boundary() const { return bytes_.empty() && !hunting_; }

 private:
  std::optional<std::expected<Reply, Garbage>> lose(std::uint8_t seen, std::uint8_t expected);
  void hunt(std::uint8_t byte);

  ReplyBytes bytes_;
  bool hunting_ = false;
  std::uint8_t ready_matched_ = 0;  ///< bytes of C8 0D 0A seen while hunting
};

/// Device side, as the document has it: a known id has its length and is complete there, so that
/// any byte may stand in its payload; one 0D right behind it belongs to it. An unknown id lasts up
/// to and with the next 0D; so does an empty request.
class RequestDecoder {
 public:
  /// A request, or Invalid, where this byte completes one.
  std::optional<std::expected<Request, Invalid>> push(std::uint8_t byte);
  /// True right behind a request, where a 0D is part of it.
  bool terminator_due() const { return terminator_due_; }

 private:
  RequestBytes bytes_;
  bool unknown_ = false;
  bool terminator_due_ = false;
};

/// Device side, as the firmware does it: the first 0D ends a request, wherever it stands, and
/// what follows is the next one. The first byte alone tells its kind; missing bytes are 0, those
/// beyond its payload are not looked at, those beyond 50 not kept.
class CutRequestDecoder {
 public:
  static constexpr std::size_t kBuffer = 50;

  std::optional<std::expected<Request, Invalid>> push(std::uint8_t byte);

 private:
  std::array<std::uint8_t, kBuffer> bytes_{};
  std::size_t size_ = 0;
};

}  // namespace sinew::bigrobotarm::byte
