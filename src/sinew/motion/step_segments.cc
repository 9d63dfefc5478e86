#include "sinew/motion/step_segments.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::motion {
namespace {

constexpr double kPerStep = static_cast<double>(StepSegment::kStep);  // units of 2^-40 step
/// Of the coefficients, before a stretch is cut in two: room for the aim to move them.
constexpr double kCoefficientsMax = static_cast<double>(StepSegment::kCoefficientsMax) / 2;

/// What ldexp and llround do, without a call: these run for every few steps of a spline.
double power_of_two(int exponent) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(exponent + 1023) << 52);
}
std::int64_t rounded(double value) {
  return static_cast<std::int64_t>(value + std::copysign(0.5, value));
}

/// Tick of step number `index` of a segment that begins at 0: as the axis will find it.
std::uint64_t tick_of(const StepSegment& segment, std::int64_t offset, std::uint32_t index) {
  StepSegment alone = segment;
  alone.steps = 1;
  StepTimer timer(offset -
                  segment.direction * static_cast<std::int64_t>(index) * StepSegment::kStep);
  timer.load(alone);
  TimedStep step;
  timer.next(step);
  return step.tick;
}

/// Times inside (0, duration) at which the axis turns, ascending.
struct Turns {
  std::array<double, 2> at{};
  std::size_t size = 0;
};

Turns turns_of(const JerkPhase& phase) {
  Turns turns;
  const AxisState& s = phase.start;
  // qd + qdd t + jerk t^2 / 2 = 0, in the form that loses no digits.
  const double root = s.qdd * s.qdd - 2 * phase.jerk * s.qd;
  if (root < 0) return turns;
  const double w = -(s.qdd + std::copysign(std::sqrt(root), s.qdd));
  for (const double t : {w / phase.jerk, 2 * s.qd / w}) {
    if (t > 0 && t < phase.duration) turns.at[turns.size++] = t;
  }
  if (turns.size == 2 && turns.at[0] > turns.at[1]) std::swap(turns.at[0], turns.at[1]);
  return turns;
}

double speed_max(const JerkPhase& phase) {
  const auto speed = [&](double t) { return std::abs(advanced(phase.start, phase.jerk, t).qd); };
  double most = std::max(std::abs(phase.start.qd), speed(phase.duration));
  const double peak = -phase.start.qdd / phase.jerk;
  if (peak > 0 && peak < phase.duration) most = std::max(most, speed(peak));
  return most;
}

}  // namespace

std::array<JerkPhase, 7> jerk_phases(const JerkLimitedMove& move, double q, double distance) {
  const double jerk = std::copysign(move.jerk, distance);
  const double steady = std::max(0.0, move.ramp_time - 2 * move.jerk_time);
  const std::array<double, 3> durations{move.jerk_time, steady, move.jerk_time};
  std::array<JerkPhase, 7> phases;
  // The second ramp is the first one backwards from the target, so that it ends exactly there.
  AxisState state{0, 0, 0};
  for (std::size_t i = 0; i < 3; ++i) {
    const double sign = 1 - static_cast<double>(i);
    phases[i] = {{q + state.q, state.qd, state.qdd}, sign * jerk, durations[i]};
    state = advanced(state, sign * jerk, durations[i]);
    if (i == 2) state.qdd = 0;
    phases[6 - i] = {{q + distance - state.q, state.qd, -state.qdd}, sign * jerk, durations[i]};
  }
  phases[3] = {{q + state.q, state.qd, 0}, 0, move.cruise_time};
  return phases;
}

/// A part of a phase, in one direction.
struct StepSegments::Stretch {
  const JerkPhase& phase;
  double start = 0;        ///< s in the phase; half a tick outside of it at most
  std::int64_t ticks = 0;  ///< > 0
  std::int8_t direction = 1;
};

StepSegments::StepSegments(const StepHardware& hardware, double q) : hardware_(hardware) {
  SINEW_ASSERT(hardware.steps_per_unit != 0 && hardware.ticks_per_second > 0);
  SINEW_ASSERT(std::isfinite(q) && hardware.step_interval_min > 0);
  const double position = q * hardware.steps_per_unit;
  start_steps_ = std::llround(position);
  constexpr std::int64_t kMost = StepSegment::kStep / 2 - 1;
  start_offset_ = std::clamp<std::int64_t>(
      std::llround((position - static_cast<double>(start_steps_)) * kPerStep), -kMost, kMost);
  state_.steps = start_steps_;
  state_.offset = start_offset_;
  state_.q = q;
}

StepRefusal StepSegments::refusal(Reason reason, double measured, double limit) const {
  return {reason, static_cast<double>(state_.clock) / hardware_.ticks_per_second, measured, limit};
}

std::expected<std::size_t, StepRefusal> StepSegments::convert(std::span<const JerkPhase> phases,
                                                              std::span<StepSegment> out) {
  const State before = state_;
  Room room{out};
  for (const JerkPhase& phase : phases) {
    if (const Result added = add_phase(phase, room); !added) {
      state_ = before;
      return std::unexpected(added.error());
    }
  }
  // The next call's segments cannot take it back any more.
  state_.made = last_step(room);
  state_.made.segment = nullptr;
  return room.size;
}

StepSegments::Result StepSegments::add_phase(const JerkPhase& phase, Room& room) {
  const AxisState& start = phase.start;
  const double sum = start.q + start.qd + start.qdd + phase.jerk + phase.duration;
  if (!std::isfinite(sum) || phase.duration < 0) {
    return std::unexpected(refusal(Reason::kNotANumber, phase.duration, 0));
  }
  const double scale = std::abs(hardware_.steps_per_unit);
  const double gap = std::abs(start.q - state_.q) * scale;
  if (gap > kGapMax) return std::unexpected(refusal(Reason::kGap, gap, kGapMax));
  const double rate = hardware_.ticks_per_second;
  // Ticks are rounded by half of one each, so an interval may lose one.
  const double interval = 1 / (speed_max(phase) * scale) - 1 / rate;
  if (interval < hardware_.step_interval_min) {
    return std::unexpected(refusal(Reason::kTooFast, interval, hardware_.step_interval_min));
  }

  const double rest = state_.rest;
  const Turns turns = turns_of(phase);
  std::int64_t done = 0;
  for (std::size_t i = 0; i <= turns.size; ++i) {
    const double end = i < turns.size ? turns.at[i] : phase.duration;
    const double begin = i > 0 ? turns.at[i - 1] : 0;
    const std::int64_t ticks = rounded(rest + end * rate) - done;
    if (ticks <= 0) continue;
    const double middle = advanced(start, phase.jerk, (begin + end) / 2).qd;
    // At rest the direction stays, so that standing on a middle between two steps is no step.
    const bool forwards =
        middle == 0 ? state_.direction >= 0 : (middle > 0) == (hardware_.steps_per_unit > 0);
    const Stretch stretch{phase, (static_cast<double>(done) - rest) / rate, ticks,
                          static_cast<std::int8_t>(forwards ? 1 : -1)};
    if (const Result added = add_stretch(stretch, room); !added) return added;
    done += ticks;
  }
  state_.rest = rest + phase.duration * rate - static_cast<double>(done);
  state_.q = advanced(start, phase.jerk, phase.duration).q;
  return {};
}

StepSegments::Result StepSegments::add_stretch(const Stretch& stretch, Room& room) {
  const JerkPhase& phase = stretch.phase;
  const AxisState from = advanced(phase.start, phase.jerk, stretch.start);
  const double rate = hardware_.ticks_per_second;
  const double scale = stretch.direction * hardware_.steps_per_unit * kPerStep;
  const auto bits = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(stretch.ticks)));
  const double span = power_of_two(bits) / rate;  // s
  const double c1 = scale * from.qd * span;
  const double c2 = scale * from.qdd / 2 * span * span;
  const double c3 = scale * phase.jerk / 6 * span * span * span;
  if (stretch.ticks > StepSegment::kTicksMax ||
      std::abs(c1) + std::abs(c2) + std::abs(c3) > kCoefficientsMax) {
    Stretch half = stretch;
    half.ticks = stretch.ticks / 2;
    if (const Result added = add_stretch(half, room); !added) return added;
    half.start += static_cast<double>(half.ticks) / rate;
    half.ticks = stretch.ticks - half.ticks;
    return add_stretch(half, room);
  }
  if (room.size == room.out.size()) {
    const auto limit = static_cast<double>(room.out.size());
    return std::unexpected(refusal(Reason::kTooMany, limit, limit));
  }

  StepSegment& segment = room.out[room.size];
  segment = {.duration = static_cast<std::uint32_t>(stretch.ticks),
             .direction = stretch.direction,
             .c1 = rounded(c1),
             .c2 = rounded(c2),
             .c3 = rounded(c3)};
  const std::uint32_t u_end = segment.u_at(segment.duration);
  const bool stands = segment.c1 == 0 && segment.c2 == 0 && segment.c3 == 0;
  if (!stands) {
    const double end = stretch.start + static_cast<double>(stretch.ticks) / rate;
    const double q_end = advanced(phase.start, phase.jerk, end).q;
    const double ahead = q_end * hardware_.steps_per_unit - static_cast<double>(state_.steps);
    const std::int64_t wanted = stretch.direction * (rounded(ahead * kPerStep) - state_.offset);
    const auto missing = static_cast<double>(wanted - segment.way(u_end));
    segment.c1 += rounded(missing * power_of_two(32) / u_end);
  }
  segment.steps = count(segment);
  if (segment.steps > 0) {
    if (const Result minded = mind_reversal(segment, room); !minded) return minded;
    if (segment.steps > 0) state_.direction = segment.direction;
  }
  const std::int64_t made = static_cast<std::int64_t>(segment.steps) * segment.direction;
  state_.steps += made;
  state_.offset += segment.direction * segment.way(u_end) - made * StepSegment::kStep;
  state_.clock += segment.duration;
  ++room.size;
  return {};
}

/// Middles between two steps that are behind it half a tick before its end. The one that may come
/// in that half tick is due at the next segment's first tick.
std::uint32_t StepSegments::count(const StepSegment& segment) const {
  const std::int64_t way =
      segment.direction * state_.offset + segment.way(segment.u_after(segment.duration - 1));
  const std::int64_t middles = way + StepSegment::kStep / 2;
  return middles < 0 ? 0 : static_cast<std::uint32_t>(middles >> StepSegment::kFractionBits);
}

/// The last step that is made so far.
StepSegments::Made StepSegments::last_step(const Room& room) const {
  std::uint64_t clock = state_.clock;
  std::int64_t offset = state_.offset;
  for (std::size_t i = room.size; i-- > 0;) {
    StepSegment& segment = room.out[i];
    clock -= segment.duration;
    offset -= segment.direction * (segment.way(segment.u_at(segment.duration)) -
                                   static_cast<std::int64_t>(segment.steps) * StepSegment::kStep);
    if (segment.steps == 0) continue;
    return {clock + tick_of(segment, offset, segment.steps - 1), segment.direction, &segment};
  }
  return state_.made;
}

/// Takes steps to and fro back that would be too close. `segment` is the next one, with steps.
StepSegments::Result StepSegments::mind_reversal(StepSegment& segment, Room& room) {
  if (state_.direction == segment.direction) return {};
  const double setup = std::ceil(hardware_.direction_setup * hardware_.ticks_per_second);
  while (segment.steps > 0) {
    const Made last = last_step(room);
    if (last.direction == 0 || last.direction == segment.direction) return {};
    const std::uint64_t first = state_.clock + tick_of(segment, state_.offset, 0);
    const auto interval = static_cast<double>(first - last.tick);
    if (interval >= setup) return {};
    if (last.segment == nullptr) {
      return std::unexpected(refusal(Reason::kReversalQuick, interval / hardware_.ticks_per_second,
                                     hardware_.direction_setup));
    }
    --last.segment->steps;
    state_.steps -= last.direction;
    state_.offset += last.direction * StepSegment::kStep;
    ++state_.merged_reversals;
    segment.steps = count(segment);
  }
  return {};
}

}  // namespace sinew::motion
