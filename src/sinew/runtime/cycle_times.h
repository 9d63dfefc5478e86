#pragma once

#include <algorithm>
#include <optional>

#include "sinew/core/instant.h"

namespace sinew::runtime {

/// How long the cycles of a loop take, a hundred at a time. @rt
class CycleTimes {
 public:
  static constexpr int kCycles = 100;

  /// Once a cycle.
  void cycle(Instant now) {
    if (last_) {
      sum_ += now - *last_;
      longest_ = std::max(longest_, now - *last_);
      ++count_;
    }
    last_ = now;
    if (count_ < kCycles) return;
    mean = sum_ / count_;
    longest = longest_;
    sum_ = longest_ = {};
    count_ = 0;
  }

  Duration mean{};     ///< 0 before there were as many
  Duration longest{};  ///< of the same ones

 private:
  std::optional<Instant> last_;
  Duration sum_{};
  Duration longest_{};
  int count_ = 0;
};

}  // namespace sinew::runtime
