#include "sinew/wire/cobs.h"

#include "sinew/core/assert.h"

namespace sinew::cobs {

Stream encode(std::span<const std::uint8_t> frame) {
  SINEW_ASSERT(!frame.empty() && frame.size() <= kFrameMax);
  Stream out;
  out.push_back(kDelimiter);
  std::size_t code = out.size();
  out.push_back(1);
  for (const std::uint8_t byte : frame) {
    if (byte != kDelimiter) {
      // Frames are shorter than the longest block, so that a code never runs out.
      out.push_back(byte);
      ++out[code];
      continue;
    }
    code = out.size();
    out.push_back(1);
  }
  out.push_back(kDelimiter);
  return out;
}

std::optional<std::span<const std::uint8_t>> Decoder::push(std::uint8_t byte) {
  if (byte == kDelimiter) {
    const bool complete = begun_ && !broken_ && left_ == 0 && size_ > 0;
    if (begun_ && !complete) ++dropped_;
    const std::size_t size = size_;
    size_ = 0;
    left_ = 0;
    begun_ = broken_ = zero_due_ = false;
    if (!complete) return std::nullopt;
    return std::span<const std::uint8_t>(frame_.data(), size);
  }
  begun_ = true;
  if (broken_) return std::nullopt;
  if (left_ == 0) {
    if (zero_due_) append(kDelimiter);
    // A block of the longest kind has no 00 behind it, and no frame of ours is so long.
    broken_ = broken_ || byte > kFrameMax + 1;
    left_ = static_cast<std::uint8_t>(byte - 1);
    zero_due_ = true;
    return std::nullopt;
  }
  append(byte);
  --left_;
  return std::nullopt;
}

void Decoder::append(std::uint8_t byte) {
  if (size_ == frame_.size()) {
    broken_ = true;
    return;
  }
  frame_[size_++] = byte;
}

}  // namespace sinew::cobs
