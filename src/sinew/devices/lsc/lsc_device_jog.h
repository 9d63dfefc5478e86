#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "sinew/devices/lsc/lsc_wire.h"

namespace sinew {

/// Pulses of base, shoulder, elbow and wrist, us.
using JogPulses = std::array<double, 4>;
inline constexpr std::array<std::uint8_t, 4> kJogServos{6, 5, 4, 3};

/// Lengths that the ESP32 kit's firmware has built in, whatever arm hangs on it; mm.
struct Esp32Links {
  static constexpr double kBase = 28.9;  ///< turntable to shoulder
  static constexpr double kUpper = 104.3;
  static constexpr double kFore = 89;
  static constexpr double kHand = 177;  ///< wrist to tips, jaws closed
};

/// What the ESP32's firmware makes of a jog (command 4): its tips, where the pulses put them with
/// Esp32Links, go on by so many mm in its base frame (x forward, y left, z up). The hand keeps its
/// pitch where it can; else the nearest one in steps of a degree that all four servos reach.
/// Nothing: none does, and the board beeps. Roll and jaws stay as they are.
///
/// Source: closed form of five_r.h; that the present pitch is tried first is assumed.
/// @rt no allocation, no lock.
std::optional<JogPulses> jogged(const JogPulses& now, const lsc::Jog& by);

}  // namespace sinew
