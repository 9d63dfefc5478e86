#pragma once

#include <optional>

#include "sinew/core/instant.h"

namespace sinew::control {

/// Whether the host keeps its cycle. @rt
class CycleWatch {
 public:
  enum class Verdict : std::uint8_t { kFine, kOverrun, kGap };

  /// @param cycle  the longest time between two looks that counts as in time
  /// @param gap    longer than this nobody was there at all
  CycleWatch(Duration cycle, Duration gap) : cycle_(cycle), gap_(gap) {}

  /// Once a cycle. Two late ones in a row are an overrun.
  Verdict look(Instant now) {
    const std::optional<Instant> last = last_;
    last_ = now;
    lateness_ = last ? now - *last : Duration::zero();
    if (lateness_ > gap_) {
      late_ = false;
      return Verdict::kGap;
    }
    const bool was_late = late_;
    late_ = lateness_ > cycle_;
    return late_ && was_late ? Verdict::kOverrun : Verdict::kFine;
  }
  /// Between the last two looks.
  Duration between() const { return lateness_; }
  Duration cycle() const { return cycle_; }
  Duration gap() const { return gap_; }

 private:
  Duration cycle_;
  Duration gap_;
  std::optional<Instant> last_;
  Duration lateness_{};
  bool late_ = false;
};

}  // namespace sinew::control
