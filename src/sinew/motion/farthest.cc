#include "sinew/motion/farthest.h"

#include <algorithm>
#include <cmath>

namespace sinew::motion {

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr int kMeetSteps = 100;
constexpr double kMeetTolerance = 4e-16;
/// Halley's step triples the digits: after one of this size, relative, there are no more to gain.
constexpr double kMeetStep = 1e-8;

double square(double x) {
  return x * x;
}

/// From rest of the acceleration to rest of the acceleration, `gain` >= 0 faster.
double ramp_time(double gain, double cap) {
  return gain >= cap * cap ? cap + gain / cap : 2 * std::sqrt(gain);
}

}  // namespace

Farthest::Farthest(const UnitState& from, const UnitState& to, const UnitCaps& caps)
    : rise_(std::max({caps.rise, from.acceleration, to.acceleration})),
      fall_(std::max({caps.fall, -from.acceleration, -to.acceleration})) {
  const auto [v0, a0] = from;
  const auto [v1, a1] = to;
  v_s_ = v0 - a0 * a0 / 2;
  v_e_ = v1 - a1 * a1 / 2;
  // Differences of velocities first: a hold is a small difference over a small acceleration.
  gain_ = (v1 - v0) + (a0 - a1) * (a0 + a1) / 2;
  time_shift_ = a0 - a1;
  way_shift_ = a0 * (v0 - a0 * a0 / 3) - a1 * (v1 - a1 * a1 / 3);
  // Ends that touch a limit may be beyond it by rounding's breadth.
  top_ = std::max({caps.top, v0 + std::max(a0, 0.0) * a0 / 2, v1 + std::min(a1, 0.0) * a1 / 2});
  climb_ = std::max((top_ - v0) + a0 * a0 / 2, square(std::max(a0, 0.0)));
  descent_ = std::max((top_ - v1) + a1 * a1 / 2, square(std::min(a1, 0.0)));
  reversed_ = gain_ < 0;
  if (reversed_) {
    gain_ = -gain_;
    std::swap(v_s_, v_e_);
    std::swap(rise_, fall_);
    std::swap(climb_, descent_);
  }
  first_ = reversed_ ? -a1 : a0;
  last_ = reversed_ ? -a0 : a1;
  set_pieces();
}

/// With the valley at y, the peak is sqrt(gain + y^2) where it is not held. As t grows the valley
/// falls from above 0 to below, so the peak first falls and then rises again.
void Farthest::set_pieces() {
  const double a = rise_;
  const double b = fall_;
  const double rise_time = ramp_time(climb_, a);
  const double fall_time = ramp_time(descent_, b);
  cruise_start_ = rise_time + fall_time;
  cruise_way_ = (rise_time * (v_s_ + top_) + fall_time * (v_e_ + top_)) / 2;

  std::size_t n = 0;
  const auto add = [&](Kind kind, double end) { pieces_[n++] = {kind, end}; };
  const double free_square = a * a - gain_;
  if (free_square > 0) {
    const double valley = std::sqrt(free_square);  // above and below this the peak is held
    add(Kind::kPeakHeld, 2 * gain_ / (a + valley));
    if (valley < b) {
      add(Kind::kFree, 2 * (a + valley));
    } else {
      add(Kind::kFree, 2 * (b + std::sqrt(gain_ + b * b)));
      add(Kind::kValleyHeld, b + free_square / b + 2 * a);
    }
  }
  if (n == 0 || pieces_[n - 1].kind == Kind::kFree) {
    add(Kind::kPeakHeld, a + (gain_ + b * b) / a + 2 * b);
  }
  add(Kind::kBothHeld, kNever);
  std::size_t last = 0;
  while (pieces_[last].end < cruise_start_) ++last;
  pieces_[last].end = cruise_start_;
  pieces_[last + 1] = {Kind::kCruise, kNever};
}

/// The peak must be above the first acceleration, the valley below the last one. Where both are
/// positive, the peak sinks below the first one and rises again as the valley falls: a gap.
std::array<TimeSpan, 2> Farthest::spans(double slack) const {
  const double a = rise_;
  const double b = fall_;
  // A longer time changes the velocity by the acceleration of the peak, or of the valley.
  const auto time_slack = [&](double acceleration) {
    return slack / std::max(std::abs(acceleration), std::sqrt(slack));
  };
  std::array<TimeSpan, 2> result;
  auto& [early, late] = result;
  late.last = kNever;
  // Valley at the last acceleration: no phase after it.
  const double peak = std::sqrt(gain_ + last_ * last_);
  TimeSpan start;
  start.slack_first = time_slack(std::min(peak, a));
  if (peak > a)
    start.first = a + (gain_ + last_ * last_) / a - 2 * last_;
  else
    start.first = last_ > 0 ? 2 * gain_ / (peak + last_) : 2 * (peak - last_);

  const double gap = first_ > 0 ? std::sqrt(std::max(0.0, first_ * first_ - gain_)) : 0;
  if (gap == 0 || last_ <= -gap) {
    late.first = start.first;
    late.slack_first = start.slack_first;
  } else {
    // Peak at the first acceleration: no phase before it.
    if (last_ >= gap) {
      early = start;
      early.last = 2 * gain_ / (first_ + gap);
      early.slack_last = time_slack(gap);
    }
    late.first = gap <= b ? 2 * (first_ + gap) : b + (first_ * first_ - gain_) / b + 2 * first_;
    late.slack_first = time_slack(std::min(gap, b));
  }
  for (TimeSpan& span : result) {
    span.first -= time_shift_;
    span.last -= time_shift_;
  }
  return result;
}

const Farthest::Piece* Farthest::piece_at(double t) const {
  const Piece* piece = pieces_.data();
  while (t >= piece->end) ++piece;
  return piece;
}

double Farthest::valley_at(double t) const {
  return rise_ - std::sqrt(std::max(0.0, rise_ * t - gain_));
}

double Farthest::peak_at(double t) const {
  return std::sqrt(std::max(0.0, fall_ * t + gain_)) - fall_;
}

double Farthest::climb_at(double t) const {
  return ((t - rise_ - fall_) * fall_ + gain_) * rise_ / (rise_ + fall_);
}

Farthest::Growth Farthest::growth(Kind kind, double t) const {
  const double a = rise_;
  const double b = fall_;
  switch (kind) {
    case Kind::kFree: {
      const double D = t / 2;
      const double slant = gain_ > 0 ? gain_ / D : 0;
      const double sum = v_s_ + v_e_;
      return {D * (sum + (D * D - slant * slant) / 4), (sum + (3 * D * D + slant * slant) / 4) / 2,
              D > 0 ? (3 * D - slant * slant / D) / 8 : 0};
    }
    case Kind::kPeakHeld: {
      const double y = valley_at(t);
      const double climb = gain_ + y * y;
      return {(a + climb / a) * (v_s_ + climb / 2) - y * (2 * v_e_ + y * y), y * (y - a / 2) + v_e_,
              (y - a / 4) * a / (y - a)};
    }
    case Kind::kValleyHeld: {
      const double x = peak_at(t);
      const double drop = x * x - gain_;
      return {x * (2 * v_s_ + x * x) + (b + drop / b) * (v_e_ + drop / 2), x * (x + b / 2) + v_s_,
              (x + b / 4) * b / (x + b)};
    }
    case Kind::kBothHeld: {
      const double climb = climb_at(t);
      const double drop = climb - gain_;
      return {(a + climb / a) * (v_s_ + climb / 2) + (b + drop / b) * (v_e_ + drop / 2),
              v_s_ + climb + a * b / 2, a * b / (a + b)};
    }
    case Kind::kCruise:
      break;
  }
  return {cruise_way_ + top_ * (t - cruise_start_), top_, 0};
}

Farthest::Turns Farthest::turns(Kind kind) const {
  const double a = rise_;
  const double b = fall_;
  switch (kind) {
    case Kind::kFree: {
      const double sum = v_s_ + v_e_;
      const double root = 4 * sum * sum - 3 * gain_ * gain_;
      if (!(sum < 0 && root > 0)) return {};
      const double high = (std::sqrt(root) - 2 * sum) / 3;  // D^2
      return {2 * gain_ / std::sqrt(3 * high), 2 * std::sqrt(high)};
    }
    case Kind::kPeakHeld: {
      const double root = a * a / 16 - v_e_;
      if (!(root > 0)) return {};
      const double high = a / 4 + std::sqrt(root);
      const double low = a / 2 - high;
      const auto time = [&](double y) { return a + (gain_ + y * y) / a - 2 * y; };
      return {high < a ? time(high) : -kNever, time(low)};
    }
    case Kind::kValleyHeld: {
      const double root = b * b / 16 - v_s_;
      if (!(root > 0)) return {};
      const double high = std::sqrt(root) - b / 4;
      const double low = -b / 2 - high;
      const auto time = [&](double x) { return b + (x * x - gain_) / b + 2 * x; };
      return {low > -b ? time(low) : -kNever, time(high)};
    }
    case Kind::kBothHeld: {
      const double climb = -a * b / 2 - v_s_;
      return {-kNever, a + b + climb / a + (climb - gain_) / b};
    }
    case Kind::kCruise:
      break;
  }
  return {};
}

/// The time in [low, high] at which the way is met, which grows between: Halley's method inside a
/// bracket, by halves where it would leave that.
double Farthest::meet(Kind kind, double low, double high, double way) const {
  if (kind == Kind::kCruise) return cruise_start_ + (way - cruise_way_) / top_;
  double t = (low + high) / 2;
  for (int i = 0; i < kMeetSteps; ++i) {
    const Growth now = growth(kind, t);
    const double excess = now.way - way;
    if (excess == 0) return t;
    (excess < 0 ? low : high) = t;
    const double slope = now.first - excess * now.second / (2 * now.first);
    double next = t - excess / slope;
    const bool safe = next > low && next < high && slope > 0;
    if (!safe) next = (low + high) / 2;
    const double step = std::abs(next - t);
    t = next;
    if (step <= (safe ? kMeetStep : kMeetTolerance) * t) break;
  }
  return t;
}

std::optional<double> Farthest::first_time(double from, double until, double way,
                                           double tolerance) const {
  const double target = way + way_shift_;
  const double last = until + time_shift_;
  double t = from + time_shift_;
  for (const Piece* piece = piece_at(t);; ++piece) {
    const auto reached = [&](double s) { return growth(piece->kind, s).way >= target - tolerance; };
    if (piece->kind == Kind::kCruise) {
      const double time = meet(Kind::kCruise, t, last, target);
      if (time > last) return std::nullopt;
      return time - time_shift_;
    }
    const double end = std::min(piece->end, last);
    const auto [crest, trough] = turns(piece->kind);
    if (t < crest) {
      const double stop = std::min(crest, end);
      if (reached(stop)) return meet(piece->kind, t, stop, target) - time_shift_;
    }
    if (trough < end && reached(end)) {
      return meet(piece->kind, std::max(t, trough), end, target) - time_shift_;
    }
    if (last <= end) return std::nullopt;
    t = end;
  }
}

double Farthest::way(double T) const {
  const double t = T + time_shift_;
  return growth(piece_at(t)->kind, t).way - way_shift_;
}

double Farthest::way_growth(double T) const {
  const double t = T + time_shift_;
  return growth(piece_at(t)->kind, t).first;
}

/// Beside the durations that exist by rounding's breadth, the first or last phase would be shorter
/// than nothing: the time is taken from the next one.
void Farthest::keep_order(Swing& swing) const {
  const double early = first_ - swing.peak;
  if (early > 0) {
    swing.peak = first_;
    if (swing.valley_hold > 2 * early)
      swing.valley_hold -= 2 * early;
    else
      swing.valley += early;
  }
  const double late = swing.valley - last_;
  if (late > 0) {
    swing.valley = last_;
    if (swing.peak_hold > 2 * late)
      swing.peak_hold -= 2 * late;
    else
      swing.peak -= late;
  }
}

Swing Farthest::swing(double T) const {
  const double a = rise_;
  const double b = fall_;
  const double t = T + time_shift_;
  Swing result{a, 0, -b, 0, -1};
  switch (piece_at(t)->kind) {
    case Kind::kFree: {
      const double D = t / 2;
      const double slant = gain_ > 0 ? gain_ / D : 0;
      result.peak = (slant + D) / 2;
      result.valley = (slant - D) / 2;
      break;
    }
    case Kind::kPeakHeld:
      result.valley = valley_at(t);
      result.peak_hold = (gain_ + square(result.valley) - a * a) / a;
      break;
    case Kind::kValleyHeld:
      result.peak = peak_at(t);
      result.valley_hold = (square(result.peak) - gain_ - b * b) / b;
      break;
    case Kind::kBothHeld: {
      const double climb = climb_at(t);
      result.peak_hold = climb / a - a;
      result.valley_hold = (climb - gain_) / b - b;
      break;
    }
    case Kind::kCruise: {
      if (climb_ < a * a)
        result.peak = std::sqrt(climb_);
      else
        result.peak_hold = climb_ / a - a;
      if (descent_ < b * b)
        result.valley = -std::sqrt(descent_);
      else
        result.valley_hold = descent_ / b - b;
      result.cruise = t - cruise_start_;
      break;
    }
  }
  keep_order(result);
  if (!reversed_) return result;
  return {-result.valley, result.valley_hold, -result.peak, result.peak_hold, result.cruise};
}

Binding Farthest::binding(double T) const {
  const Kind kind = piece_at(T + time_shift_)->kind;
  if (kind == Kind::kCruise) return Binding::kVelocity;
  return kind == Kind::kFree ? Binding::kJerk : Binding::kAcceleration;
}

}  // namespace sinew::motion
