#pragma once

// Many steps in a few bytes, for axes whose processor can add but hardly multiply.

#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>
#include <vector>

#include "sinew/motion/step_run_code.h"
#include "sinew/motion/step_segments.h"
#include "sinew/motion/step_timing.h"

namespace sinew::motion {

struct StepRunSettings {
  double tolerance = 25;  ///< ticks between a step and its exact time, at most
  /// Smaller tolerances cannot be kept with whole ticks.
  static constexpr double kToleranceMin = 1.5;
  /// Of the interval between two steps, what a step may be off, whatever `tolerance` says: steps
  /// keep their order, and two of them at least half of their interval.
  static constexpr double kIntervalShare = 0.25;
};

/// Turns segments into runs whose intervals are quadratic in the number of the step, each as long
/// as the tolerance lets it be. Every single step is checked: with T the tick that the run gives
/// it, the exact way at T - tolerance has not reached the middle between two steps, and at T +
/// tolerance it has. As the way only grows there, the exact time lies between the two.
///
/// A run's cubic through its begin and three exact times, at 0.29, 0.71 and all of its length: the
/// places between which the error is least where both ends are held. In the manner of Klipper's
/// step compression, with one difference more, as jerk-limited ways are smooth that far.
class StepRuns {
 public:
  /// @param segments_max  how many segments one call may bring
  StepRuns(const StepRunSettings& settings, std::size_t segments_max);

  /// @param offset, tick  as for the StepTimer that would run the segments
  /// @return  how many runs were written to `out`. Refusals: kTooMany (limit: runs), kTooFast (an
  ///          interval of which a quarter is less than kToleranceMin; measured, limit: ticks, and
  ///          `time` in ticks as well). @rt
  std::expected<std::size_t, StepRefusal> compress(std::span<const StepSegment> segments,
                                                   std::int64_t offset, std::uint64_t tick,
                                                   std::span<StepRun> out);

 private:
  struct Piece {
    double begin = 0;  ///< ticks
    double end = 0;
    double per_tick = 0;            ///< u
    double c1 = 0, c2 = 0, c3 = 0;  ///< steps
    double way = 0;                 ///< steps, come since this direction began
    double first = 0;               ///< level of its first step
    std::int64_t steps = 0;
    std::int8_t direction = 1;
    double at(double time) const;
  };
  struct Fit;
  struct Window;

  void take(std::span<const StepSegment> segments, std::int64_t offset, std::uint64_t tick);
  /// Of the pieces [begin_, end_), all in one direction.
  double time_of(double level, double near);
  double way_at(double time);
  const Piece& piece_at(double time);
  const Piece& piece_of(double level);
  Fit fit(double level, std::int64_t count, double base);
  double deviation(const Fit& fit, double level);
  bool keeps(const Fit& fit, double level);
  bool keeps_all(const Fit& fit, double level);
  bool keeps_at(const Fit& fit, double level, std::int64_t k);
  Fit longest(double level, std::int64_t left, double base);

  StepRunSettings settings_;
  std::vector<Piece> pieces_;
  std::size_t begin_ = 0, end_ = 0, cursor_ = 0;
  std::int64_t length_ = 64;  ///< of the last run: the next one's will be near
  double growth_ = 1;
};

}  // namespace sinew::motion
