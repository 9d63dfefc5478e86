#pragma once

#include <chrono>
#include <cstdint>

namespace sinew {

using Duration = std::chrono::nanoseconds;

/// The time line of one run. It has no now(): whoever needs the time is handed an Instant, so that
/// the same code runs under real and under virtual time.
struct InjectedClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = Duration;
  using time_point = std::chrono::time_point<InjectedClock>;
  static constexpr bool is_steady = true;
};

using Instant = InjectedClock::time_point;

/// Seconds as a double, for arithmetic with velocities. @rt
constexpr double to_seconds(Duration duration) {
  return std::chrono::duration<double>(duration).count();
}

/// Nearest nanosecond to a number of seconds; the caller guarantees |seconds| < 9e9. @rt
constexpr Duration from_seconds(double seconds) {
  const double nanoseconds = seconds * 1e9;
  return Duration{static_cast<std::int64_t>(nanoseconds + (nanoseconds < 0 ? -0.5 : 0.5))};
}

}  // namespace sinew
