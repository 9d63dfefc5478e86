#pragma once

#include "sinew/core/instant.h"

namespace sinew::io {

/// The machine's steady clock, optionally run faster or slower: `scale` seconds of the run pass in
/// one real second. It starts at Instant{} when it is made.
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
  std::chrono::steady_clock::time_point start_;
};

}  // namespace sinew::io
