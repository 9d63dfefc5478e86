#pragma once

#include <stdint.h>

/// Frames on a stream of bytes by consistent overhead byte stuffing: 00 between them and nowhere
/// else. Source: S. Cheshire, M. Baker, Consistent Overhead Byte Stuffing, 1999. @rt
namespace sinew {
namespace mcu {

constexpr uint8_t kFrameMax = 64;               ///< bytes of a frame
constexpr uint8_t kStuffedMax = kFrameMax + 3;  ///< of a frame on the line, 00 on either side

/// The bytes of `frame` on the line, a 00 on either side. @pre size is 1..kFrameMax
/// @return bytes written to `out`, at most kStuffedMax
uint8_t stuff(const uint8_t* frame, uint8_t size, uint8_t* out);

/// Bytes to frames. What is too long, or broken, is dropped up to the next 00.
class FrameReceiver {
 public:
  /// Size of the frame that this byte ends, 0 where it ends none. frame() is valid until the next
  /// push().
  uint8_t push(uint8_t byte);
  const uint8_t* frame() const { return frame_; }
  /// Forgets a frame that was begun.
  void reset();
  /// Frames that were begun and not good.
  uint32_t dropped() const { return dropped_; }

 private:
  void append(uint8_t byte);

  uint8_t frame_[kFrameMax] = {};
  uint8_t size_ = 0;
  uint8_t left_ = 0;  ///< bytes until the next code byte
  bool begun_ = false;
  bool broken_ = false;
  bool zero_due_ = false;  ///< the present block ends with a 00
  uint32_t dropped_ = 0;
};

}  // namespace mcu
}  // namespace sinew
