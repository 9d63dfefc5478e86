#include "sinew/motion/state_to_state.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sinew/core/error_code.h"

namespace sinew::motion {

namespace {

/// Limits are met within rounding of their size.
constexpr double kRounding = 1e-12;
/// Ends that lie by so much (m or rad, relative above 1) beside a motion that is the only one for
/// miles around are taken for ends of it: where a motion is planned again from one of its own
/// states, that state is rounded.
constexpr double kEndTolerance = 1e-12;
constexpr double kVelocityTolerance = 1e-13;
/// s, relative: how far a duration may lie beside one that is possible.
constexpr double kTimeTolerance = 1e-14;

bool finite(const AxisState& state) {
  return std::isfinite(state.q) && std::isfinite(state.qd) && std::isfinite(state.qdd);
}

AxisState mirrored(const AxisState& state) {
  return {-state.q, -state.qd, -state.qdd};
}

UnitState per_jerk(const AxisState& state, double jerk) {
  const double k = 1 / jerk;
  return {k * state.qd, k * state.qdd};
}

UnitCaps upward(const ProfileBounds& bounds) {
  const double k = 1 / bounds.jerk;
  return {k * bounds.acceleration_upper, -k * bounds.acceleration_lower, k * bounds.velocity_upper};
}

double velocity_slack(const ProfileBounds& bounds) {
  return kRounding * std::max(bounds.velocity_upper, -bounds.velocity_lower);
}

double acceleration_slack(const ProfileBounds& bounds) {
  return kRounding * std::max(bounds.acceleration_upper, -bounds.acceleration_lower);
}

/// Velocity where the acceleration would be 0 with full jerk downwards, now or in the past.
double crest(const AxisState& state, double jerk) {
  return state.qd + state.qdd * state.qdd / (2 * jerk);
}

/// rad/s: a velocity that was computed on the way is off by less.
double velocity_noise(const AxisState& start, const AxisState& target) {
  return kVelocityTolerance * (1 + std::abs(start.qd) + std::abs(target.qd));
}

class RecoveryBuilder {
 public:
  RecoveryBuilder(Recovery& recovery, const ProfileBounds& bounds)
      : recovery_(recovery), bounds_(bounds), slack_(velocity_slack(bounds)) {}

  void add(double jerk, double duration) {
    if (!(duration > 0)) return;
    recovery_.phases.push_back({jerk, duration});
    recovery_.duration += duration;
    recovery_.state = advanced(recovery_.state, jerk, duration);
  }

  void bring_back_acceleration() {
    const double slack = acceleration_slack(bounds_);
    const double now = recovery_.state.qdd;
    const double inside = std::clamp(now, bounds_.acceleration_lower, bounds_.acceleration_upper);
    if (std::abs(now - inside) <= slack) return;
    add(std::copysign(bounds_.jerk, inside - now), std::abs(inside - now) / bounds_.jerk);
    recovery_.state.qdd = inside;
  }

  /// Whether the velocity is, or must come, beyond the bound on one side (+1 or -1).
  bool beyond(double side) const {
    const AxisState state = seen_from(side);
    const double bound = velocity_bound(side) + slack_;
    return state.qd > bound || (state.qdd > 0 && crest(state, bounds_.jerk) > bound);
  }

  /// To the velocity bound on that side, as soon as possible with an acceleration with which the
  /// velocity does not leave on the other side.
  void bring_back_velocity(double side) {
    const double jerk = bounds_.jerk;
    const auto [q, v, a] = seen_from(side);
    const double bound = velocity_bound(side);
    const double lowest = side > 0 ? bounds_.acceleration_lower : -bounds_.acceleration_upper;
    const double range = bounds_.velocity_upper - bounds_.velocity_lower;
    const double end = -std::sqrt(2 * jerk * range);

    // Jerk downwards until the bound is met, unless that is with too much acceleration.
    const double excess = 2 * jerk * std::max(0.0, crest({q, v, a}, jerk) - bound);
    double valley = std::max(lowest, -std::sqrt(excess));
    double hold = (excess - valley * valley) / (-2 * jerk * valley);
    double last = valley;
    bool arrives = true;
    if (valley < end) {
      const double square = std::max(0.0, (a * a + end * end) / 2 + jerk * (v - bound));
      valley = std::max(lowest, -std::sqrt(square));
      hold = (square - valley * valley) / (-jerk * valley);
      last = end;
      // So much of it already that full jerk upwards is due at once.
      arrives = valley <= std::min(a, end);
      if (!arrives) valley = a;
    }
    const auto add_to = [&](double sign, double duration, double acceleration) {
      add(side * sign * jerk, duration);
      recovery_.state.qdd = side * acceleration;
    };
    add_to(-1, (a - valley) / jerk, std::min(a, valley));
    if (arrives) add_to(0, hold, valley);
    add_to(1, (last - valley) / jerk, last);
    if (arrives) recovery_.state.qd = side * bound;
  }

 private:
  AxisState seen_from(double side) const {
    return side > 0 ? recovery_.state : mirrored(recovery_.state);
  }
  double velocity_bound(double side) const {
    return side > 0 ? bounds_.velocity_upper : -bounds_.velocity_lower;
  }

  Recovery& recovery_;
  const ProfileBounds& bounds_;
  double slack_;
};

/// The phases of one swing, from a state.
class Legs {
 public:
  /// @param side  +1, or -1 for a swing in the mirror.
  Legs(const Swing& swing, const AxisState& from, double last, double side, double jerk)
      : state_(from) {
    jerk_ = side * jerk;
    add(1, swing.peak - side * from.qdd / jerk);
    add(0, swing.peak_hold);
    if (swing.cruise >= 0) {
      add(-1, swing.peak);
      add(0, swing.cruise);
      add(-1, -swing.valley);
    } else {
      add(-1, swing.peak - swing.valley);
    }
    add(0, swing.valley_hold);
    add(1, side * last / jerk - swing.valley);
  }

  struct Leg {
    double start, end;  // s
    double jerk;
    AxisState state;
    AxisState at(double t) const { return advanced(state, jerk, t - start); }
  };
  const Leg& operator[](std::size_t i) const { return legs_[i]; }
  std::size_t size() const { return size_; }
  double end() const { return end_; }

 private:
  void add(double sign, double duration) {
    if (!(duration > 0)) return;
    legs_[size_++] = {end_, end_ + duration, sign * jerk_, state_};
    state_ = advanced(state_, sign * jerk_, duration);
    end_ += duration;
  }

  std::array<Leg, 7> legs_;
  std::size_t size_ = 0;
  double end_ = 0;
  double jerk_ = 0;
  AxisState state_;
};

void append(const Legs& legs, JointProfile& out) {
  for (std::size_t i = 0; i < legs.size(); ++i) {
    out.append(legs[i].state, legs[i].jerk, legs[i].end - legs[i].start);
  }
}

/// Both at once: `share` of the other and the rest of the one. Each state is the mean of the two,
/// which are exact at their own phases: long times cost no digits of short phases.
void append_mean(const Legs& one, const Legs& other, double share, JointProfile& out) {
  if (one.size() == 0 || other.size() == 0) return;
  const double nothing = kTimeTolerance * one.end();
  const auto mean = [share](double x, double y) { return x + share * (y - x); };
  double t = 0;
  std::size_t i = 0;
  std::size_t k = 0;
  AxisState a = one[0].state;
  AxisState b = other[0].state;
  for (;;) {
    const auto& x = one[i];
    const auto& y = other[k];
    const double until = std::min(x.end, y.end);
    out.append({mean(a.q, b.q), mean(a.qd, b.qd), mean(a.qdd, b.qdd)}, mean(x.jerk, y.jerk),
               until - t);
    t = until;
    const bool x_ends = x.end <= until + nothing;
    const bool y_ends = y.end <= until + nothing;
    if (x_ends && ++i == one.size()) return;
    if (y_ends && ++k == other.size()) return;
    a = x_ends ? one[i].state : x.at(until);
    b = y_ends ? other[k].state : y.at(until);
  }
}

}  // namespace

std::optional<Error> refusal(const AxisState& start, const ProfileBounds& bounds) {
  const bool in_order = bounds.velocity_lower < 0 && bounds.velocity_upper > 0 &&
                        bounds.acceleration_lower < 0 && bounds.acceleration_upper > 0 &&
                        bounds.jerk > 0;
  const bool all_finite = std::isfinite(bounds.velocity_upper - bounds.velocity_lower) &&
                          std::isfinite(bounds.acceleration_upper - bounds.acceleration_lower) &&
                          std::isfinite(bounds.jerk);
  if (in_order && all_finite && finite(start)) return std::nullopt;
  return Error{.code = ErrorCode::kMotionInput};
}

std::optional<Error> refusal_of_target(const AxisState& target, const ProfileBounds& bounds) {
  if (!finite(target)) return Error{.code = ErrorCode::kMotionInput};
  const double a = target.qdd;
  const double a_limit = a > 0 ? bounds.acceleration_upper : bounds.acceleration_lower;
  if (std::abs(a) > std::abs(a_limit) + acceleration_slack(bounds)) {
    return Error{ErrorCode::kTargetAcceleration, -1, a, a_limit};
  }
  // With full jerk, before it or after it, the velocity is by this farther from 0.
  const double margin = a * a / (2 * bounds.jerk);
  const double slack = velocity_slack(bounds);
  if (target.qd + margin > bounds.velocity_upper + slack) {
    return Error{ErrorCode::kTargetVelocity, -1, target.qd + margin, bounds.velocity_upper};
  }
  if (target.qd - margin < bounds.velocity_lower - slack) {
    return Error{ErrorCode::kTargetVelocity, -1, target.qd - margin, bounds.velocity_lower};
  }
  return std::nullopt;
}

Recovery recovery(const AxisState& start, const ProfileBounds& bounds) {
  Recovery result;
  result.state = start;
  RecoveryBuilder builder(result, bounds);
  builder.bring_back_acceleration();
  // Braking from one side may be too late for the other one, but not the way back as well.
  const double first = builder.beyond(1) ? 1 : -1;
  if (builder.beyond(first)) builder.bring_back_velocity(first);
  if (builder.beyond(-first)) builder.bring_back_velocity(-first);
  return result;
}

StateToState::StateToState(const AxisState& start, const AxisState& target,
                           const ProfileBounds& bounds)
    : start_(start),
      target_(target),
      jerk_(bounds.jerk),
      recovery_(recovery(start, bounds)),
      way_((target.q - recovery_.state.q) / bounds.jerk),
      way_tolerance_(kEndTolerance * (1 + std::abs(start.q) + std::abs(target.q)) / bounds.jerk),
      upper_(per_jerk(recovery_.state, bounds.jerk), per_jerk(target, bounds.jerk), upward(bounds)),
      lower_(per_jerk(mirrored(recovery_.state), bounds.jerk),
             per_jerk(mirrored(target), bounds.jerk), upward(bounds.mirrored())),
      spans_(upper_.spans(velocity_noise(start, target) / bounds.jerk)) {
  const AxisState& from = recovery_.state;
  const double time = std::abs(target.qdd - from.qdd) / jerk_;
  const double jerk = target.qdd > from.qdd ? jerk_ : -jerk_;
  const AxisState end = advanced(from, jerk, time);
  if (std::abs(end.qd - target.qd) <= velocity_noise(start, target) &&
      std::abs(end.q - target.q) <= jerk_ * way_tolerance_) {
    direct_ = true;
    direct_time_ = time;
    direct_jerk_ = jerk;
  }
}

std::optional<StateToState::Reach> StateToState::next_in(const TimeSpan& span, double time) const {
  const double last = span.last + span.slack_last;
  if (span.empty() || time > last * (1 + kTimeTolerance)) return std::nullopt;
  const double begin = std::max(time, span.first);
  const auto reach = [&](const Farthest& edge, double at) {
    return Reach{at + recovery_.duration, edge.binding(at)};
  };
  const double high = upper_.way(begin);
  if (begin == span.first) {  // both edges meet here
    if (std::abs(way_ - high) <= way_tolerance_) return reach(upper_, begin);
    const double before = begin + (way_ - high) / upper_.way_growth(begin);
    const bool possible = before < begin && before >= begin - span.slack_first && before >= time;
    if (possible && std::abs(way_ - upper_.way(before)) <= way_tolerance_) {
      return reach(upper_, before);
    }
  }
  if (way_ > high + way_tolerance_) {
    const auto at = upper_.first_time(begin, last, way_, way_tolerance_);
    if (!at) return std::nullopt;
    return reach(upper_, *at);
  }
  const double low = begin == span.first ? high : -lower_.way(begin);
  if (way_ < low - way_tolerance_) {
    const auto at = lower_.first_time(begin, last, -way_, way_tolerance_);
    if (!at) return std::nullopt;
    return reach(lower_, *at);
  }
  return Reach{begin + recovery_.duration, std::nullopt};
}

StateToState::Reach StateToState::next(double duration) const {
  const double time = duration - recovery_.duration;
  if (direct_ && time <= direct_time_ * (1 + kTimeTolerance)) {
    const auto binding = direct_time_ > 0 ? std::optional(Binding::kJerk) : std::nullopt;
    return {direct_time_ + recovery_.duration, binding};
  }
  if (const auto reach = next_in(spans_[0], time)) return *reach;
  const auto reach = next_in(spans_[1], time);
  SINEW_ASSERT(reach.has_value());  // in the end it cruises towards its target
  return *reach;
}

void StateToState::profile(double duration, JointProfile& out) const {
  out.restart(start_);
  for (const auto& [jerk, time] : recovery_.phases) out.append(jerk, time);
  const double time = duration - recovery_.duration;
  if (direct_ && std::abs(time - direct_time_) <= kTimeTolerance * duration) {
    out.append(direct_jerk_, direct_time_);
    return out.finish(target_);
  }
  const AxisState& from = recovery_.state;
  const double high = upper_.way(time);
  const double low = -lower_.way(time);
  const auto up = [&] { return Legs(upper_.swing(time), from, target_.qdd, 1, jerk_); };
  const auto down = [&] { return Legs(lower_.swing(time), from, target_.qdd, -1, jerk_); };
  if (way_ >= high - way_tolerance_ / 2) {
    append(up(), out);
  } else if (way_ <= low + way_tolerance_ / 2) {
    append(down(), out);
  } else {
    append_mean(up(), down(), (high - way_) / (high - low), out);
  }
  out.finish(target_);
}

JointProfile StateToState::profile(double duration) const {
  JointProfile result;
  profile(duration, result);
  return result;
}

}  // namespace sinew::motion
