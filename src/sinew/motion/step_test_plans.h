#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/motion/step_segments.h"
#include "sinew/motion/step_timing.h"
#include "support/property.h"

namespace sinew::motion::test_plans {

/// robot-arm-2: 200 x 16 microsteps, 17:1.
inline constexpr double kStepsPerRad = 3200 * 17 / (2 * kPi);
/// Steps: what a double says of a position of some thousand rad, and the integers of the rest.
inline constexpr double kPositionTolerance = 4e-9;

inline StepHardware hardware(double ticks_per_second = 1e6) {
  return {.steps_per_unit = kStepsPerRad,
          .ticks_per_second = ticks_per_second,
          .step_interval_min = 2 / ticks_per_second,
          .direction_setup = 0};
}

struct Crossing {
  long double time = 0;   ///< s
  long double speed = 0;  ///< steps/s
  std::int8_t direction = 1;
};

inline long double position(const JerkPhase& phase, long double t, double scale) {
  const long double q =
      static_cast<long double>(phase.start.q) +
      t * (phase.start.qd +
           t / 2 * (phase.start.qdd + t / 3 * static_cast<long double>(phase.jerk)));
  return q * scale;
}

inline long double speed(const JerkPhase& phase, long double t, double scale) {
  return scale *
         (phase.start.qd + t * (phase.start.qdd + t / 2 * static_cast<long double>(phase.jerk)));
}

/// Where a monotonous part of a phase passes the middles between steps, by bisection.
inline void add_crossings(const JerkPhase& phase, double scale, long double begin, long double end,
                          long double offset, std::vector<Crossing>& crossings) {
  const long double from = position(phase, begin, scale);
  const long double to = position(phase, end, scale);
  const int direction = to >= from ? 1 : -1;
  long double level =
      direction > 0 ? std::ceil(from - 0.5L) + 0.5L : std::floor(from + 0.5L) - 0.5L;
  for (; direction > 0 ? level <= to : level >= to; level += direction) {
    long double lower = begin;
    long double upper = end;
    for (int i = 0; i < 100 && upper - lower > 1e-16L; ++i) {
      const long double middle = (lower + upper) / 2;
      const bool reached = (position(phase, middle, scale) - level) * direction >= 0;
      (reached ? upper : lower) = middle;
    }
    crossings.push_back({offset + upper, std::abs(speed(phase, upper, scale)),
                         static_cast<std::int8_t>(direction)});
  }
}

/// All of a plan, exactly: the reference.
inline std::vector<Crossing> crossings_of(const std::vector<JerkPhase>& phases, double scale) {
  std::vector<Crossing> crossings;
  long double offset = 0;
  for (const JerkPhase& phase : phases) {
    std::vector<long double> cuts{0};
    const long double a = phase.jerk / 2;
    const long double b = phase.start.qdd;
    const long double c = phase.start.qd;
    const long double root = b * b - 4 * a * c;
    if (a != 0 && root > 0) {
      for (const int sign : {-1, 1}) cuts.push_back((-b + sign * std::sqrt(root)) / (2 * a));
    } else if (a == 0 && b != 0) {
      cuts.push_back(-c / b);
    }
    cuts.push_back(phase.duration);
    std::erase_if(cuts, [&](long double t) { return t < 0 || t > phase.duration; });
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      add_crossings(phase, scale, cuts[i], cuts[i + 1], offset, crossings);
    }
    offset += phase.duration;
  }
  return crossings;
}

struct Played {
  std::vector<TimedStep> steps;
  StepTimer timer;
};

inline Played play(const StepSegments& converter, std::span<const StepSegment> segments) {
  Played played{{}, StepTimer(converter.start_offset())};
  TimedStep step;
  for (const StepSegment& segment : segments) {
    played.timer.load(segment);
    while (played.timer.next(step)) played.steps.push_back(step);
  }
  return played;
}

inline std::vector<StepSegment> converted(StepSegments& converter,
                                          std::span<const JerkPhase> phases) {
  std::vector<StepSegment> segments(4096);
  const auto size = converter.convert(phases, segments);
  EXPECT_TRUE(size.has_value()) << static_cast<int>(size.error().reason) << " at "
                                << size.error().time;
  segments.resize(size.value_or(0));
  return segments;
}

/// Phases that fit together, at the speeds and accelerations of arms and far beyond; among them
/// dwells, turns, and phases shorter than a tick. It ends with a dwell.
inline std::vector<JerkPhase> random_phases(test::Random& random, double speed_max) {
  std::vector<JerkPhase> phases;
  AxisState state{random.uniform(-3, 3), 0, 0};
  for (auto i = random.integer(1, 12); i > 0; --i) {
    const double duration = std::pow(10, random.uniform(-7, -0.5));
    const double ramp = std::max(duration, 0.003);
    double jerk = random.chance(0.2) ? 0 : random.uniform(-1, 1) * speed_max / ramp / ramp;
    if (random.chance(0.2)) state.qdd = 0;
    if (random.chance(0.2)) {
      phases.push_back({{state.q, state.qd, -state.qd / ramp}, 0, ramp});
      state = {advanced(phases.back().start, 0, ramp).q, 0, 0};
      if (random.chance(0.5)) jerk = 0;
    }
    JerkPhase phase{state, jerk, duration};
    for (const double t : {0.25, 0.5, 0.75, 1.0}) {
      if (std::abs(advanced(state, phase.jerk, t * duration).qd) > 0.9 * speed_max) {
        phase.start.qdd = phase.jerk = 0;
      }
    }
    phases.push_back(phase);
    state = advanced(phase.start, phase.jerk, duration);
  }
  phases.push_back({{state.q, state.qd, -state.qd / 0.01}, 0, 0.01});
  phases.push_back({{advanced(phases.back().start, 0, 0.01).q, 0, 0}, 0, 0.01});
  return phases;
}

/// A phase begins at the tick that is nearest: where the acceleration jumps, that much is added.
inline double position_tolerance(const std::vector<JerkPhase>& phases, double rate) {
  double jump = 0;
  double qdd = 0;
  for (const JerkPhase& phase : phases) {
    jump += std::abs(phase.start.qdd - qdd);
    qdd = phase.start.qdd + phase.jerk * phase.duration;
  }
  return kPositionTolerance + jump * kStepsPerRad / rate / rate / 8;
}

/// Every step of the reference, in order, within a tick; where the axis hardly moves, within the
/// time in which it moves by less than positions can say.
inline void expect_steps(const std::vector<Crossing>& expected, const std::vector<TimedStep>& steps,
                         double rate, double position_tolerance, double& worst) {
  ASSERT_EQ(steps.size(), expected.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    ASSERT_EQ(steps[i].direction, expected[i].direction) << "step " << i;
    const auto late = std::abs(static_cast<long double>(steps[i].tick) - expected[i].time * rate);
    const auto ticks = static_cast<double>(late);
    const double unsure = position_tolerance / static_cast<double>(expected[i].speed) * rate;
    ASSERT_LE(ticks, 0.5 + unsure + 1e-3) << "step " << i;
    if (unsure < 0.4) worst = std::max(worst, ticks);
  }
}

}  // namespace sinew::motion::test_plans
