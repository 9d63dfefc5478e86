#pragma once

#include <cstdint>
#include <string_view>

namespace sinew {

/// What an AS5600 sees of its magnet; bits of the axis link carry the number.
enum class Magnet : std::uint8_t {
  kUnknown = 0,  ///< no such sensor, or not read yet
  kGood = 1,
  kTooWeak = 2,    ///< too far away: readings still count
  kTooStrong = 3,  ///< too near: readings still count
  kMissing = 4,
  kNoReply = 5,  ///< of the sensor, or of its node
};
inline constexpr auto kMagnetLast = Magnet::kNoReply;

constexpr bool is_detected(Magnet magnet) {
  return magnet == Magnet::kGood || magnet == Magnet::kTooWeak || magnet == Magnet::kTooStrong;
}

/// Unknown is none: such a sensor may not be there.
constexpr bool needs_attention(Magnet magnet) {
  return magnet != Magnet::kUnknown && magnet != Magnet::kGood;
}

/// Of the bits that a chip or a node has for it.
constexpr Magnet magnet_from(bool detected, bool too_weak, bool too_strong) {
  if (!detected) return Magnet::kMissing;
  if (too_weak) return Magnet::kTooWeak;
  return too_strong ? Magnet::kTooStrong : Magnet::kGood;
}

/// "too weak"
constexpr std::string_view magnet_word(Magnet magnet) {
  constexpr std::string_view kWords[] = {"unknown",    "good",    "too weak",
                                         "too strong", "missing", "no reply"};
  return kWords[static_cast<std::size_t>(magnet)];
}

}  // namespace sinew
