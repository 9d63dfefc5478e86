#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"

/// Consistent overhead byte stuffing: frames on a stream of bytes with 00 between them and nowhere
/// else, so that a receiver is back in step after the next 00, whatever was lost.
///
/// Source: S. Cheshire, M. Baker, Consistent Overhead Byte Stuffing, 1999. Everything is @rt.
namespace sinew::cobs {

inline constexpr std::uint8_t kDelimiter = 0;
inline constexpr std::size_t kFrameMax = 64;
/// Up to 254 bytes grow by one, and a 00 stands on either side: the first ends whatever noise came
/// before, so that noise never costs a good frame.
inline constexpr std::size_t kStreamMax = kFrameMax + 3;
using Stream = FixedVector<std::uint8_t, kStreamMax>;

/// `frame` as it goes on the line, delimiters included. @pre 1..kFrameMax bytes
Stream encode(std::span<const std::uint8_t> frame);

/// Bytes to frames. What is too long, or broken, is dropped up to the next 00.
class Decoder {
 public:
  /// A frame, where this byte ends one; it is valid until the next push().
  std::optional<std::span<const std::uint8_t>> push(std::uint8_t byte);
  /// Frames that were begun and not good, since construction.
  std::uint64_t dropped() const { return dropped_; }

 private:
  void append(std::uint8_t byte);

  std::array<std::uint8_t, kFrameMax> frame_{};
  std::size_t size_ = 0;
  std::uint8_t left_ = 0;  ///< bytes until the next code byte
  bool begun_ = false;
  bool broken_ = false;
  bool zero_due_ = false;  ///< the block that just runs stands for a 00 at its end
  std::uint64_t dropped_ = 0;
};

}  // namespace sinew::cobs
