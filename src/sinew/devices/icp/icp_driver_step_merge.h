#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sinew/model/robot_model.h"

namespace sinew {

/// Merges the steps of six legs into one stream, so that the platform stays on its straight line in
/// leg space: after k of N steps every leg has made less than one step more or less than its share
/// n k / N.
///
/// Each step of a leg has a window, step j (from 0) the places floor(j N / n) to
/// ceil((j + 1) N / n) - 1; of those that are open the one that closes first is taken. That finds
/// a place for every step, and whole numbers only: a long way ends exactly at its end.
/// Source: S. Baruah et al., Proportionate progress: a notion of fairness in resource allocation,
/// 1996. @rt
class StepMerge {
 public:
  using Counts = std::array<std::int64_t, kLegs>;  ///< signed

  struct Step {
    std::size_t leg = 0;
    int direction = 1;  ///< +1 or -1
    friend bool operator==(const Step&, const Step&) = default;
  };

  /// Nothing to do.
  StepMerge() = default;
  /// |count| < 2^29 each, asserted.
  explicit StepMerge(const Counts& counts);

  bool done() const { return made_ == total_; }
  std::int64_t total() const { return total_; }
  std::int64_t remaining() const { return total_ - made_; }
  /// The next step; not while done().
  Step next() const;
  /// It is made, or given up.
  void advance();

 private:
  struct Leg {
    std::int64_t count = 0;  ///< unsigned
    std::int64_t made = 0;
    std::int64_t opens = 0;
    std::int64_t closes = 0;
    int direction = 1;
  };

  std::size_t pick() const;
  void set_window(Leg& leg) const;

  std::array<Leg, kLegs> legs_;
  std::int64_t total_ = 0;
  std::int64_t made_ = 0;
};

}  // namespace sinew
