#include "sinew/planning/timing/time_law.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew::planning {

PathState advanced(const PathState& state, double jerk, double t) {
  return {state.s + t * (state.v + t * (state.a / 2 + t * jerk / 6)),
          state.v + t * (state.a + t * jerk / 2), state.a + t * jerk};
}

TimeLaw::TimeLaw(std::size_t capacity) {
  phases_.reserve(capacity);
}

void TimeLaw::clear(const PathState& start) {
  phases_.clear();
  duration_ = 0;
  end_ = start;
}

void TimeLaw::append(double jerk, double duration) {
  append(jerk, duration, advanced(end_, jerk, std::max(duration, 0.0)));
}

void TimeLaw::append(double jerk, double duration, const PathState& end) {
  if (duration > 0) {
    if (phases_.empty() || phases_.back().jerk != jerk) {
      SINEW_ASSERT(has_room(1));
      phases_.push_back({duration_, end_, jerk});
    }
    duration_ += duration;
  }
  end_ = end;
}

void TimeLaw::end_at_rest(double s) {
  end_ = {s, 0, 0};
  if (phases_.empty() || !(phases_.back().jerk > 0)) return;
  constexpr double kRounding = 1e-3;  // of the phase
  const LawPhase& last = phases_.back();
  const double until = last.t - last.state.a / last.jerk;
  if (std::abs(until - duration_) <= kRounding * (duration_ - last.t)) duration_ = until;
}

std::size_t TimeLaw::phase_at(double t) const {
  const auto after =
      std::upper_bound(phases_.begin(), phases_.end(), t,
                       [](double at, const LawPhase& phase) { return at < phase.t; });
  return after == phases_.begin() ? 0 : static_cast<std::size_t>(after - phases_.begin()) - 1;
}

PathState TimeLaw::sample(double t) const {
  if (phases_.empty() || t >= duration_) return end_;
  if (t <= 0) return phases_.front().state;
  const LawPhase& phase = phases_[phase_at(t)];
  return advanced(phase.state, phase.jerk, t - phase.t);
}

double TimeLaw::jerk(double t) const {
  if (phases_.empty() || t < 0 || t >= duration_) return 0;
  return phases_[phase_at(t)].jerk;
}

}  // namespace sinew::planning
