#include "sinew/io/clock.h"

#include <time.h>

#include <algorithm>
#include <thread>

namespace sinew::io {
namespace {

Duration time_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

}  // namespace

std::int64_t wall_time_ns() {
  return time_of(CLOCK_REALTIME).count();
}

Clock::Clock(double scale) : scale_(scale), start_(time_of(CLOCK_BOOTTIME)) {}

Instant Clock::now() const {
  const Duration real = time_of(CLOCK_BOOTTIME) - start_;
  if (scale_ == 1) return Instant{real};
  return Instant{from_seconds(to_seconds(real) * scale_)};
}

Duration Clock::until(Instant instant) const {
  const Duration left = instant - now();
  if (left <= Duration::zero()) return Duration::zero();
  if (scale_ == 1) return left;
  // Slowed down, a far instant would leave the count of nanoseconds; nobody waits a day in one go.
  constexpr double kLongest = 86'400;  // s
  return from_seconds(std::min(to_seconds(left) / scale_, kLongest));
}

void Clock::pause(Duration real) const {
  std::this_thread::sleep_for(real);
}

}  // namespace sinew::io
