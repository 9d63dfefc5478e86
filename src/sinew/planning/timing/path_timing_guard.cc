#include <algorithm>
#include <cmath>

#include "sinew/planning/timing/path_timing.h"

/// What is given out of laws that begin in motion: whatever made them, they are held against the
/// cells that they pass.
namespace sinew::planning {
namespace {

constexpr double kOnLimit = 1 + 1e-9;
constexpr double kBorder = 1e-11;     // of the path: a phase ends on a border but for rounding
constexpr double kSame = 1e-9;        // of the limits, where phases join
constexpr double kSamePlace = 2e-11;  // of the path
constexpr double kSameSpeed = 1e-9;   // of the largest speed
constexpr double kRounding = 1e-9;    // of a speed that should not be below 0
constexpr int kStopTries = 12;
constexpr double kTryLater = 1.0 / 32;  // of what is left of the law at hand

/// Calls look(cell, other, from, to, jerk), where `other` is another cell that will do, for each
/// part of a law that lies in one cell and whose acceleration keeps its sign, until one returns
/// false.
template <class Look>
void for_each_part(const PathGrid& grid, const TimeLaw& law, Look&& look) {
  const auto phases = law.phases();
  const double near = kBorder * grid.length();
  std::size_t cell = 0;
  for (std::size_t i = 0; i < phases.size(); ++i) {
    PathState x = phases[i].state;
    const double jerk = phases[i].jerk;
    double left = (i + 1 < phases.size() ? phases[i + 1].t : law.duration()) - phases[i].t;
    if (i == 0) cell = grid.cell_at(x.s);
    while (left > 0) {
      const double turn = jerk != 0 ? -x.a / jerk : 0;
      const bool turns = turn > 0 && turn < left;
      double t = turns ? turn : left;
      PathState y = advanced(x, jerk, t);
      if (turns) y.a = 0;
      const double end = grid.begin(cell + 1);
      const bool leaves = cell + 1 < grid.size() && y.s > end + near;
      if (leaves && end - x.s <= near) {
        ++cell;
        continue;
      }
      if (leaves) {
        t = std::min(t, time_over(end - x.s, x, jerk));
        y = advanced(x, jerk, t);
        y.s = end;
      }
      // What is all within rounding of a border may be of either side.
      std::size_t other = cell;
      if (cell + 1 < grid.size() && end - x.s <= near) other = cell + 1;
      if (cell > 0 && y.s - grid.begin(cell) <= near) other = cell - 1;
      if (!look(cell, other, x, y, jerk)) return;
      left -= t;
      x = y;
      if (leaves) ++cell;
    }
  }
}

}  // namespace

/// @return the first cell in which the law does not hold what that allows; none: it holds all
std::optional<std::size_t> PathTiming::broken_cell(const TimeLaw& law, double feed_most) const {
  std::optional<std::size_t> broken;
  for_each_part(
      grid_, law,
      [&](std::size_t k, std::size_t other, const PathState& x, const PathState& y, double jerk) {
        const auto holds = [&](std::size_t i) {
          const PathCell& cell = grid_[i];
          const double v = grid_.speed_at(i, feed_most);
          return std::max(x.v, y.v) <= v * kOnLimit && std::min(x.v, y.v) >= -kRounding * v &&
                 std::max(std::abs(x.a), std::abs(y.a)) <= cell.a * kOnLimit &&
                 std::abs(jerk) <= cell.u * kOnLimit;
        };
        if (!holds(k) && (other == k || !holds(other))) broken = k;
        return !broken;
      });
  if (broken) return broken;
  const auto phases = law.phases();
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const bool last = i + 1 == phases.size();
    const LawPhase& phase = phases[i];
    const PathState& to = last ? law.end() : phases[i + 1].state;
    const PathState end =
        advanced(phase.state, phase.jerk, (last ? law.duration() : phases[i + 1].t) - phase.t);
    const std::size_t k = grid_.cell_at(to.s);
    const double a = std::max(grid_[k].a, k > 0 ? grid_[k - 1].a : 0);
    const bool joins = std::abs(end.s - to.s) <= kSamePlace * grid_.length() &&
                       std::abs(end.v - to.v) <= kSameSpeed * grid_.speed_at(k, feed_most) &&
                       std::abs(end.a - to.a) <= kSame * a;
    if (!joins) return k;
  }
  return {};
}

/// The largest feed of which a motion at `start` may still have the speed.
double PathTiming::feed_at(const PathState& start) const {
  const double feed = start.s > quick_until_ ? feed_given_ : feed_most_;
  return start.v <= grid_.speed_at(grid_.cell_at(start.s), feed) * kOnLimit ? feed : feed_max_;
}

/// Remembers what may be asked about a law that is given out.
void PathTiming::give_out(const TimeLaw& law, double feed, double feed_most) {
  feed_given_ = feed;
  feed_most_ = feed_most;
  quick_until_ = -1;
  for_each_part(grid_, law,
                [&](std::size_t k, std::size_t, const PathState& x, const PathState& y, double) {
                  if (std::max(x.v, y.v) > grid_.speed_at(k, feed) * kOnLimit) quick_until_ = y.s;
                  return true;
                });
}

/// Begins `out` with what `law` does from `t` to `to`, s.
void PathTiming::follow(const TimeLaw& law, double t, double to, TimeLaw& out) {
  begin_law(law.sample(t), out);
  const auto phases = law.phases();
  for (std::size_t i = 0; i < phases.size() && phases[i].t < to; ++i) {
    const bool last = i + 1 == phases.size();
    const double end = last ? law.duration() : phases[i + 1].t;
    if (end <= t) continue;
    const PathState state = end > to ? law.sample(to) : last ? law.end() : phases[i + 1].state;
    out.append(phases[i].jerk, std::min(end, to) - std::max(phases[i].t, t), state);
  }
  cell_ = grid_.cell_at(out.end().s);
}

std::optional<Error> PathTiming::stop(const TimeLaw& at_hand, double t, TimeLaw& out) {
  const double duration = at_hand.duration();
  t = std::clamp(t, 0.0, duration);
  const double feed_most = ceiling_ = feed_at(at_hand.sample(t));
  double from = t;
  for (int i = 0; use_ == LawUse::kChangeable && i < kStopTries && from < duration; ++i) {
    follow(at_hand, t, from, out);
    const bool rests = brake(out);
    if (rests && out.duration() > duration - t) break;
    const auto broken = rests ? broken_cell(out, feed_most) : grid_.cell_at(out.end().s);
    if (!broken) {
      give_out(out, feed_given_, feed_most);
      return {};
    }
    // On as it is until it has come by what is too narrow for the braking.
    double low = std::min(from + kTryLater * (duration - from), duration);
    double high = duration;
    const double past = grid_.begin(*broken + 1);
    for (int k = 0; k < 40 && at_hand.sample(low).s < past; ++k) {
      const double middle = low + (high - low) / 2;
      (at_hand.sample(middle).s < past ? low : high) = middle;
    }
    from = high < duration ? high : low;
  }
  follow(at_hand, t, duration, out);
  give_out(out, feed_given_, feed_most);
  return {};
}

}  // namespace sinew::planning
