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

Clock Clock::simulated(double scale) {
  Clock clock(scale);
  clock.simulated_ = std::make_shared<Simulated>();
  clock.simulated_->start = clock.start_;
  return clock;
}

Instant Clock::now() const {
  if (simulated_) return simulated_->now.load();
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
  // Never rounded to nothing: who waits for so long at a time would not get there.
  return std::max(Duration{1}, from_seconds(std::min(to_seconds(left) / scale_, kLongest)));
}

void Clock::pause(Duration real) const {
  if (!simulated_) return std::this_thread::sleep_for(real);
  pause_until(now() + stretched(real));
}

void Clock::pause_until(Instant instant) const {
  if (!simulated_) return std::this_thread::sleep_for(until(instant));
  pass_to(instant);
  keep_pace();
}

Duration Clock::stretched(Duration real) const {
  return scale_ == 1 ? real : from_seconds(to_seconds(real) * scale_);
}

void Clock::pass_to(Instant instant) const {
  if (instant > now()) simulated_->now.store(instant);
}

void Clock::keep_pace() const {
  const Duration passed = from_seconds(to_seconds(now().time_since_epoch()) / scale_);
  const Duration real = time_of(CLOCK_BOOTTIME) - simulated_->start;
  if (real - passed > kLateMax) {
    simulated_->start += real - passed;
  } else if (passed - real >= kSleepMin) {
    std::unique_lock lock(simulated_->mutex);
    simulated_->woken.wait_for(lock, passed - real, [this] { return simulated_->wake; });
    simulated_->wake = false;
  }
}

Duration Clock::ahead() const {
  if (!simulated_) return Duration::zero();
  const Duration real = time_of(CLOCK_BOOTTIME) - simulated_->start;
  const Duration there = from_seconds(to_seconds(real) * scale_);
  return std::max(Duration::zero(), now().time_since_epoch() - there);
}

Instant Clock::end_of_turn(Duration own) const {
  return ahead() < stretched(kSleepMin) ? now() + own : now();
}

void Clock::wake() const {
  if (!simulated_) return;
  {
    const std::scoped_lock lock(simulated_->mutex);
    simulated_->wake = true;
  }
  simulated_->woken.notify_one();
}

}  // namespace sinew::io
