#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/mcu/frame_stream.h"

/// Frames on a stream of bytes (mcu/frame_stream.h) with 00 between them and nowhere else, so that
/// a receiver is back in step after the next 00, whatever was lost. Everything is @rt.
namespace sinew::cobs {

inline constexpr std::uint8_t kDelimiter = 0;
inline constexpr std::size_t kFrameMax = mcu::kFrameMax;
/// Up to 254 bytes grow by one, and a 00 stands on either side: the first ends whatever noise came
/// before, so that noise never costs a good frame.
inline constexpr std::size_t kStreamMax = mcu::kStuffedMax;
using Stream = FixedVector<std::uint8_t, kStreamMax>;

/// `frame` as it goes on the line, delimiters included. @pre 1..kFrameMax bytes
Stream encode(std::span<const std::uint8_t> frame);

/// Bytes to frames. What is too long, or broken, is dropped up to the next 00.
class Decoder {
 public:
  /// A frame, where this byte ends one; it is valid until the next push().
  std::optional<std::span<const std::uint8_t>> push(std::uint8_t byte);
  /// Frames that were begun and not good, since construction.
  std::uint64_t dropped() const { return receiver_.dropped(); }

 private:
  mcu::FrameReceiver receiver_;
};

}  // namespace sinew::cobs
