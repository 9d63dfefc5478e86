#pragma once

// When to make each step: the host's part. step_timing.h is the axis'.

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>

#include "sinew/motion/online_profile.h"
#include "sinew/motion/rest_to_rest.h"
#include "sinew/motion/step_timing.h"

namespace sinew::motion {

/// A stretch of constant jerk.
struct JerkPhase {
  AxisState start;
  double jerk = 0;
  double duration = 0;  ///< s, >= 0
};

/// The phases of a rest-to-rest move from `q` by `distance` (either sign): seven, some of them
/// without duration.
std::array<JerkPhase, 7> jerk_phases(const JerkLimitedMove& move, double q, double distance);

/// What the step driver and its timer can do.
struct StepHardware {
  double steps_per_unit = 0;        ///< signed, per rad (or m) of the joint
  double ticks_per_second = 1e6;    ///< of the timer
  double step_interval_min = 2e-6;  ///< s, from one step to the next
  double direction_setup = 5e-6;    ///< s, from the last step of one direction to the next's first
};

/// Why a way cannot be stepped.
struct StepRefusal {
  enum class Reason : std::uint8_t {
    kTooFast,        ///< steps would come closer than step_interval_min; measured, limit: s
    kReversalQuick,  ///< two steps around a reversal closer than direction_setup; likewise
    kGap,            ///< a phase begins elsewhere than the one before ends; measured, limit: steps
    kNotANumber,     ///< or a negative duration
    kTooMany,        ///< more segments than there is room for; limit: segments
  };
  Reason reason = Reason::kNotANumber;
  double time = 0;  ///< s since the first phase that was ever converted
  double measured = 0;
  double limit = 0;
  friend bool operator==(const StepRefusal&, const StepRefusal&) = default;
};

/// Turns phases of constant jerk into segments for StepTimer, phase after phase, for as long as the
/// axis runs. It computes each segment's end with the axis' own integers and begins the next one
/// there, and aims at the plan's absolute position each time: the end is off by 2^-39 step at most
/// after any number of segments, and no step is lost or made up.
///
/// Between the ends a segment differs from the plan by 2^-37 step, and by what `q` itself cannot
/// say (a double of 1e7 steps: 2^-29). Segments end where the axis turns, and where a count or a
/// duration would not fit.
///
/// A turn just behind the middle between two steps asks for a step to and fro at once. Where the
/// two would be closer than direction_setup neither is made: the joint is never farther from the
/// plan than half a step and what it moves in that time. merged_reversals() counts them. @rt
class StepSegments {
 public:
  /// Position deviation at a hand-over between phases that is rounding and not a mistake, steps.
  static constexpr double kGapMax = 1e-3;

  /// @param q  where the axis is: nearest step and offset follow.
  StepSegments(const StepHardware& hardware, double q);

  /// @return  how many segments were written to `out`. After a refusal nothing has changed.
  std::expected<std::size_t, StepRefusal> convert(std::span<const JerkPhase> phases,
                                                  std::span<StepSegment> out);

  /// For the StepTimer that will run them.
  std::int64_t start_offset() const { return start_offset_; }
  std::int64_t start_steps() const { return start_steps_; }
  /// Of all that was converted: steps at its end, and position minus steps there.
  std::int64_t steps() const { return state_.steps; }
  std::int64_t offset() const { return state_.offset; }
  std::uint64_t clock() const { return state_.clock; }  ///< ticks
  int merged_reversals() const { return state_.merged_reversals; }

 private:
  using Reason = StepRefusal::Reason;

  struct Made {
    std::uint64_t tick = 0;
    std::int8_t direction = 0;       ///< 0: none yet
    StepSegment* segment = nullptr;  ///< nullptr: converted earlier, cannot be taken back
  };
  struct State {
    std::uint64_t clock = 0;  ///< ticks, end of the last segment
    double rest = 0;          ///< ticks from there to the end of the last phase, within half a tick
    std::int64_t steps = 0;
    std::int64_t offset = 0;
    double q = 0;               ///< end of the last phase
    std::int8_t direction = 0;  ///< of the last step
    Made made;                  ///< the last step of earlier calls
    int merged_reversals = 0;
  };
  struct Room {
    std::span<StepSegment> out;
    std::size_t size = 0;
  };
  struct Stretch;
  using Result = std::expected<void, StepRefusal>;

  Result add_phase(const JerkPhase& phase, Room& room);
  Result add_stretch(const Stretch& stretch, Room& room);
  Result mind_reversal(StepSegment& segment, Room& room);
  Made last_step(const Room& room) const;
  std::uint32_t count(const StepSegment& segment) const;
  StepRefusal refusal(Reason reason, double measured, double limit) const;

  StepHardware hardware_;
  std::int64_t start_steps_ = 0;
  std::int64_t start_offset_ = 0;
  State state_;
};

}  // namespace sinew::motion
