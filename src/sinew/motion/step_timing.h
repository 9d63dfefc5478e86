#pragma once

// When to make each step: the part that runs on the axis' own processor. Integers only, and no
// division: it must run where there is no floating-point unit and in an interrupt. The host's part
// is step_segments.h.

#include <cstdint>

namespace sinew::motion {

/// A stretch of an axis' way in one direction: how far it has come, in steps, at each instant. The
/// way is c1 u + c2 u^2 + c3 u^3, where u runs from 0 to 1 within the next power of two above
/// `duration`, so that 32 bits of u are a tick's exact place.
///
/// Where it begins is not said, because it is where the stretch before it ends, to the last bit:
/// host and axis compute that with the same integers, and nothing can drift.
struct StepSegment {
  std::uint32_t duration = 1;  ///< ticks, 1 .. kTicksMax
  std::uint32_t steps = 0;     ///< to be made in it; the host has counted them
  std::int8_t direction = 1;   ///< +1 or -1; the way is counted in this direction
  std::int64_t c1 = 0;         ///< 2^-40 step
  std::int64_t c2 = 0;
  std::int64_t c3 = 0;

  static constexpr int kFractionBits = 40;
  static constexpr std::int64_t kStep = std::int64_t{1} << kFractionBits;
  static constexpr std::uint32_t kTicksMax = (std::uint32_t{1} << 31) - 1;
  /// |c1| + |c2| + |c3| stays below this: half a million steps and more.
  static constexpr std::int64_t kCoefficientsMax = std::int64_t{1} << 61;

  /// Bits of `duration`: u = 1 is 2^span_bits() ticks.
  int span_bits() const;
  /// u of a whole tick, and of the middle between a tick and the next.
  std::uint32_t u_at(std::uint32_t tick) const { return tick << (32 - span_bits()); }
  std::uint32_t u_after(std::uint32_t tick) const { return (2 * tick + 1) << (31 - span_bits()); }
  /// The way come at u, 2^-40 step; every product is rounded down, so it is 5 of those units away
  /// from the real polynomial at most. Three multiplications of 64 by 32 bits. @rt
  std::int64_t way(std::uint32_t u) const;
};

struct TimedStep {
  std::uint64_t tick = 0;
  std::int8_t direction = 1;
};

/// Turns segments into the instants of steps. A step is due at the tick that is nearest to where
/// the way passes the middle between two steps: half a tick away from it at most, wherever the
/// axis is faster than one step in 2^37 ticks (half an hour at 72 MHz), and never lost or made up.
///
/// The search is Newton's, from where the last intervals point to, inside a bracket that always
/// holds the answer; a step costs two evaluations as a rule and kEvaluationsMax at most.
///
/// Direction comes with each step as soon as the step before has been made, so the driver's
/// direction line can be set that early. @rt
class StepTimer {
 public:
  static constexpr int kNewtonMax = 12;
  static constexpr int kEvaluationsMax = kNewtonMax + 31;

  StepTimer() = default;
  /// @param offset  position minus step count, 2^-40 step: within half a step
  explicit StepTimer(std::int64_t offset, std::uint64_t tick = 0) : offset_(offset), begin_(tick) {}

  /// The next stretch; only when done().
  void load(const StepSegment& segment);
  bool done() const { return !loaded_; }
  /// The next step of the loaded segment. False where it has no more: done() then.
  bool next(TimedStep& step);

  std::int64_t position() const { return position_; }  ///< steps made, signed
  std::int64_t offset() const { return offset_; }      ///< when done(): as for the constructor
  std::uint64_t clock() const { return begin_; }       ///< when done(): where the next one begins
  /// Evaluations that the dearest and all steps took.
  int evaluations_most() const { return evaluations_most_; }
  std::uint64_t evaluations() const { return evaluations_; }

 private:
  std::uint32_t search(std::int64_t target, std::int64_t lower);
  void take_slope(std::uint32_t tick);
  std::int64_t correction(std::int64_t missing) const;

  StepSegment segment_;
  bool loaded_ = false;
  std::int64_t offset_ = 0;  ///< 2^-40 step, at the segment's begin, in signed position
  std::uint64_t begin_ = 0;  ///< tick at which the segment begins
  std::int64_t position_ = 0;
  std::uint32_t made_ = 0;  ///< steps of this segment

  // What the last steps tell of the next; ticks relative to begin_.
  std::int64_t last_ = -1;
  std::int64_t interval_ = 0;
  std::int64_t interval_before_ = 0;
  std::int8_t direction_ = 0;

  // Ticks per way as mantissa_ * 2^-slope_shift_; 0 where the axis stands.
  std::uint32_t mantissa_ = 0;
  int slope_shift_ = 0;

  int evaluations_most_ = 0;
  std::uint64_t evaluations_ = 0;
};

/// Many steps at once, for axes whose processor can hardly multiply: each interval is the one
/// before plus a number that itself grows evenly. Bound to a tolerance; step_runs.h makes them.
///
/// In units of 2^-shift ticks: interval, then every step: time += interval, interval += add,
/// add += add2. Three additions a step.
struct StepRun {
  std::uint32_t count = 0;
  std::int8_t direction = 1;
  std::int8_t shift = 0;  ///< 0 .. 48
  std::int64_t interval = 0;
  std::int64_t add = 0;
  std::int64_t add2 = 0;
};

/// Plays runs; each begins at the last tick of the one before. @rt
class StepRunPlayer {
 public:
  explicit StepRunPlayer(std::uint64_t tick = 0) : base_(tick) {}
  void load(const StepRun& run) {
    run_ = run;
    time_ = run.shift > 0 ? std::int64_t{1} << (run.shift - 1) : 0;
  }
  bool done() const { return run_.count == 0; }
  bool next(TimedStep& step) {
    if (run_.count == 0) return false;
    time_ += run_.interval;
    run_.interval += run_.add;
    run_.add += run_.add2;
    const std::uint64_t tick = base_ + static_cast<std::uint64_t>(time_ >> run_.shift);
    if (--run_.count == 0) base_ = tick;
    step = {tick, run_.direction};
    return true;
  }
  std::uint64_t clock() const { return base_; }  ///< when done(): the tick of the last step

 private:
  StepRun run_;
  std::int64_t time_ = 0;
  std::uint64_t base_ = 0;
};

}  // namespace sinew::motion
