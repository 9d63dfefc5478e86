#include "sinew/mcu/frame_stream.h"

namespace sinew {
namespace mcu {

uint8_t stuff(const uint8_t* frame, uint8_t size, uint8_t* out) {
  uint8_t place = 0;
  out[place++] = 0;
  uint8_t code = place;
  out[place++] = 1;
  for (uint8_t i = 0; i < size; ++i) {
    if (frame[i] != 0) {
      // Frames are shorter than the longest block, so that a code never runs out.
      out[place++] = frame[i];
      ++out[code];
      continue;
    }
    code = place;
    out[place++] = 1;
  }
  out[place++] = 0;
  return place;
}

uint8_t FrameReceiver::push(uint8_t byte) {
  if (byte == 0) {
    const bool complete = begun_ && !broken_ && left_ == 0 && size_ > 0;
    if (begun_ && !complete) ++dropped_;
    const uint8_t size = size_;
    reset();
    return complete ? size : 0;
  }
  begun_ = true;
  if (broken_) return 0;
  if (left_ == 0) {
    if (zero_due_) append(0);
    // A block of the longest kind has no 00 behind it, and no frame of ours is so long.
    broken_ = broken_ || byte > kFrameMax + 1;
    left_ = static_cast<uint8_t>(byte - 1);
    zero_due_ = true;
    return 0;
  }
  append(byte);
  --left_;
  return 0;
}

void FrameReceiver::reset() {
  size_ = 0;
  left_ = 0;
  begun_ = broken_ = zero_due_ = false;
}

void FrameReceiver::append(uint8_t byte) {
  if (size_ == kFrameMax) {
    broken_ = true;
    return;
  }
  frame_[size_++] = byte;
}

}  // namespace mcu
}  // namespace sinew
