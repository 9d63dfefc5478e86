#pragma once

#include <Arduino.h>

/// What the checksum of a reply covers. The arm's Arduino program has kSpec (function, length,
/// data), its MicroPython program kWithHeader (AA 55 as well, which makes it one more).
enum class ReplyChecksum : uint8_t { kUnknown, kSpec, kWithHeader };

namespace sinew_maxarm {

constexpr uint8_t kReplyFrame = 11;

struct Reply {
  uint8_t function;
  int16_t values[3];
  ReplyChecksum checksum;
};

/// Bytes to replies. Never holds more than one frame. A frame that turns out wrong is searched
/// again behind its first byte, since a good one may begin inside.
class ReplyParser {
 public:
  /// True if this byte completes a reply.
  bool push(uint8_t byte, Reply& reply);
  void reset() { count_ = 0; }

 private:
  bool may_be_frame() const;
  void drop_first();
  void drop_to_head();

  uint8_t bytes_[kReplyFrame];
  uint8_t count_ = 0;
};

/// Checksum of the arm. Two equal replies in a row settle it. From then on a reply with the other
/// one is noise (a flipped bit can look like it), until three in a row prove a changed arm.
class ChecksumWatch {
 public:
  /// False: a reply with this checksum is noise.
  bool accept(ReplyChecksum checksum);
  ReplyChecksum checksum() const { return checksum_; }
  /// How often a settled checksum changed, up to 255.
  uint8_t changes() const { return changes_; }

 private:
  ReplyChecksum checksum_ = ReplyChecksum::kUnknown;
  uint8_t agreed_ = 0;
  uint8_t others_ = 0;
  uint8_t changes_ = 0;
};

}  // namespace sinew_maxarm
