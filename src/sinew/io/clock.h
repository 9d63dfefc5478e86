#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>

#include "sinew/core/instant.h"

namespace sinew::io {

/// Wall clock, ns since 1970; for records that people read, never for time that passes.
std::int64_t wall_time_ns();

/// The machine's clock since it was started, which also counts while it sleeps, optionally run
/// faster or slower: `scale` seconds of the run pass in one real second. It starts at Instant{}
/// when it is made.
class Clock {
 public:
  explicit Clock(double scale = 1);
  /// Time that passes only as far as its machine has been simulated, and no quicker than `scale`
  /// times as fast as real time. A computer that is busy elsewhere makes it late, and never makes
  /// it jump. One thread simulates: it alone pauses on it, and lets time pass.
  static Clock simulated(double scale = 1);

  bool is_simulated() const { return simulated_ != nullptr; }
  Instant now() const;
  /// Real time until `instant`; zero where it has passed; with a scale a day at most.
  Duration until(Instant instant) const;
  /// Lets this much real time pass, or a little more.
  void pause(Duration real) const;
  /// The same until `instant`, and not an instant less.
  void pause_until(Instant instant) const;
  /// Of this clock, for so much real time.
  Duration stretched(Duration real) const;
  double scale() const { return scale_; }

  /// @name Of simulated time, for the thread that simulates
  /// @{
  /// It is `instant` now, if it was not later already.
  void pass_to(Instant instant) const;
  /// Waits until real time has come as far, or for wake(). What is late by more than kLateMax
  /// stays late.
  void keep_pace() const;
  /// How far it is ahead of real time, in its own time; zero where it is late, or real.
  Duration ahead() const;
  /// Where a turn of `own` time ends that begins now: at once where keep_pace() has to sleep first.
  Instant end_of_turn(Duration own) const;
  /// @}
  /// The thread that simulates, or will, waits no longer now: it has something to do. From any
  /// thread; without effect on real time.
  void wake() const;

  static constexpr Duration kLateMax = std::chrono::milliseconds(250);  ///< real time
  /// Real time. A sleep takes longer than requested; a shorter one is left to the next.
  static constexpr Duration kSleepMin = std::chrono::milliseconds(1);

 private:
  struct Simulated {
    std::atomic<Instant> now{Instant{}};
    Duration start{};  ///< real, where it would be zero; of the thread that simulates
    std::mutex mutex;
    std::condition_variable woken;
    bool wake = false;  ///< under the mutex
  };

  double scale_;
  Duration start_;
  std::shared_ptr<Simulated> simulated_;
};

}  // namespace sinew::io
