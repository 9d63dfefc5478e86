#pragma once

#include <cstdint>

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

  Instant now() const;
  /// Real time until `instant`; zero where it has passed; with a scale a day at most.
  Duration until(Instant instant) const;
  /// Lets this much real time pass, or a little more.
  void pause(Duration real) const;
  double scale() const { return scale_; }

 private:
  double scale_;
  Duration start_;
};

}  // namespace sinew::io
