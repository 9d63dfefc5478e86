#include "sinew/planning/timing/path_sweep.h"

#include <algorithm>
#include <cmath>

namespace sinew::planning {
namespace {

// Rounding's breadth: a state that misses a limit by so much is on it. The promise is 1e-9.
constexpr double kOnLimit = 1 + 1e-12;

constexpr int kRoughly = 8;      // halvings until it is clear what stands in the way
constexpr double kShort = 0.25;  // of a ramp from rest: a step of a slope, not a cruise
constexpr int kSlideSteps = 12;  // halvings of a slide's jerk

/// `state` after the time in which it comes to `s`, with s itself exact.
PathState arrived(const PathState& state, double jerk, double t, double s) {
  PathState end = advanced(state, jerk, t);
  end.s = s;
  return end;
}

}  // namespace

double time_over(double distance, const PathState& state, double jerk) {
  const double v = state.v;
  const double a = state.a;
  if (distance <= 0) return 0;
  if (jerk == 0) {
    const double square = v * v + 2 * a * distance;
    return square < 0 ? std::numeric_limits<double>::infinity()
                      : 2 * distance / (v + std::sqrt(square));
  }
  const bool falling = a < 0 || (a == 0 && jerk < 0);
  double t = v > 0 ? distance / v : std::numeric_limits<double>::infinity();
  if (falling) {
    // It may stop before it is there.
    double stop = std::numeric_limits<double>::infinity();
    const double square = a * a - 2 * jerk * v;
    if (square >= 0) stop = 2 * v / (-a + std::sqrt(square));
    if (jerk > 0) stop = std::min(stop, -a / jerk);
    if (!(v > 0)) return std::numeric_limits<double>::infinity();
    if (std::isfinite(stop)) {
      const double way = stop * (v + stop * (a / 2 + stop * jerk / 6));
      // Newton would come from below and never turn: the end itself is the answer near to it.
      if (way <= distance) {
        return way >= distance * (1 - 1e-14) ? stop : std::numeric_limits<double>::infinity();
      }
    }
  } else {
    if (a > 0) t = std::min(t, std::sqrt(2 * distance / a));
    if (jerk > 0) {
      t = std::min(t, std::cbrt(6 * distance / jerk));
    } else {
      t = std::min(v > 0 ? distance / v : std::numeric_limits<double>::infinity(), -a / jerk);
    }
  }
  // The way is convex (concave where it falls) in t and starts on the side from which Newton's
  // steps do not overshoot.
  for (int i = 0; i < 60; ++i) {
    const double miss = t * (v + t * (a / 2 + t * jerk / 6)) - distance;
    const double speed = v + t * (a + t * jerk / 2);
    if (!(speed > 0)) break;
    const double change = miss / speed;
    t -= change;
    if (std::abs(change) <= 4e-16 * t) break;
  }
  return std::max(t, 0.0);
}

PathState state_at(const Stretch& stretch, double s) {
  if (s <= stretch.from.s) return stretch.from;
  if (s >= stretch.to.s) return stretch.to;
  const double t =
      std::min(time_over(s - stretch.from.s, stretch.from, stretch.jerk), stretch.duration);
  return arrived(stretch.from, stretch.jerk, t, s);
}

bool UpSweep::enters(const SweepState& at) const {
  const PathCell& cell = cells_[at.cell];
  return at.state.v <= cell.v * kOnLimit && at.state.a <= cell.a * kOnLimit;
}

UpSweep::Wall UpSweep::level_off(SweepState at) const {
  for (; at.cell < cells_.size(); ++at.cell) {
    if (!enters(at)) return {at.cell, at.state.v > cells_[at.cell].v * kOnLimit};
    const PathCell& cell = cells_[at.cell];
    const auto& [s, v, a] = at.state;
    const double t = a / cell.u;
    const double level = v + a * t / 2;
    const double end = cells_.end(at.cell);
    if (s + t * (v + a * t / 3) <= end) {
      return level <= cell.v * kOnLimit ? Wall{} : Wall{at.cell + 1, true};
    }
    const double over = time_over(end - s, at.state, -cell.u);
    at.state = arrived(at.state, -cell.u, over, end);
    if (at.state.v > cell.v * kOnLimit) return {at.cell + 1, true};
  }
  return {};
}

UpSweep::Push UpSweep::push(const SweepState& at) const {
  const PathCell& cell = cells_[at.cell];
  const double end = cells_.end(at.cell);
  Push result;
  PathState state = at.state;
  const auto add = [&](double jerk, double t, double s) {
    Stretch& part = result.parts[result.size++];
    part = {state, arrived(state, jerk, t, s), jerk, t};
    state = part.to;
  };
  if (state.a < cell.a) {
    const double rise = (cell.a - state.a) / cell.u;
    const double t = time_over(end - state.s, state, cell.u);
    if (t <= rise) {
      add(cell.u, t, end);
      return result;
    }
    add(cell.u, rise, advanced(state, cell.u, rise).s);
    result.parts[0].to.a = state.a = cell.a;
  }
  add(0, time_over(end - state.s, state, 0), end);
  return result;
}

void UpSweep::cruise(SweepState& at, std::vector<Stretch>& out) const {
  const double end = cells_.end(at.cell);
  at.state.a = 0;
  const double t = time_over(end - at.state.s, at.state, 0);
  PathState to{end, at.state.v, 0};
  if (t > 0) out.push_back({at.state, to, 0, t});
  at.state = to;
  ++at.cell;
}

void UpSweep::follow_level_off(SweepState& at, std::size_t stop, std::vector<Stretch>& out) const {
  while (at.cell < stop && at.cell < cells_.size()) {
    const PathCell& cell = cells_[at.cell];
    const double end = cells_.end(at.cell);
    const PathState from = at.state;
    const double level = from.a / cell.u;
    const PathState top = advanced(from, -cell.u, level);
    if (top.s <= end) {
      at.state = {top.s, top.v, 0};
      // On the cell's speed but for rounding.
      if (std::abs(top.v - cell.v) < 1e-12 * cell.v) at.state.v = cell.v;
      if (level > 0) out.push_back({from, at.state, -cell.u, level});
      return;
    }
    const double t = time_over(end - from.s, from, -cell.u);
    at.state = arrived(from, -cell.u, t, end);
    out.push_back({from, at.state, -cell.u, t});
    ++at.cell;
  }
}

/// Whether the wall before cell `wall` is one of many small steps up and near.
bool UpSweep::on_a_slope(std::size_t from, std::size_t wall) const {
  if (wall >= cells_.size() || wall > from + kSlideLook) return false;
  const PathCell& cell = cells_[wall - 1];
  const double ramp = cell.v / cell.a + cell.a / cell.u;
  const double time = (cells_.end(wall - 1) - cells_.begin(wall - 1)) / cell.v;
  return cells_[wall].v > cell.v * (1 + 1e-9) && time < kShort * ramp;
}

/// Where the acceleration has followed its limit, to the limit of the next cell in one steady jerk:
/// neither a jump of jerk at every cell nor less than allowed for long.
bool UpSweep::ride(SweepState& at, std::vector<Stretch>& out) const {
  const std::size_t k = at.cell;
  if (k == 0 || k + 1 >= cells_.size() || at.state.s > cells_.begin(k)) return false;
  const PathCell& cell = cells_[k];
  const PathState& from = at.state;
  if (std::abs(from.a - std::min(cells_[k - 1].a, cell.a)) > 1e-9 * cell.a) return false;
  const double to = std::min(cell.a, cells_[k + 1].a);
  // distance = v t + (2 from + to) t^2 / 6
  const double c = (2 * from.a + to) / 3;
  const double distance = cells_.end(k) - from.s;
  const double t = 2 * distance / (from.v + std::sqrt(from.v * from.v + 2 * c * distance));
  const double jerk = std::abs(to - from.a) > 1e-9 * to ? (to - from.a) / t : 0;
  if (!(std::abs(jerk) <= cell.u)) return false;
  PathState end = arrived(from, jerk, t, cells_.end(k));
  if (jerk != 0) end.a = to;
  if (end.v > cell.v * kOnLimit || !level_off({k + 1, end}).none()) return false;
  out.push_back({from, end, jerk, t});
  at = {k + 1, end};
  return true;
}

void UpSweep::step(SweepState& at, std::vector<Stretch>& out) const {
  const PathCell& cell = cells_[at.cell];
  const double end = cells_.end(at.cell);
  // The next cell is slower: on at its speed.
  if (at.state.v > cell.v && at.state.a <= 0) at.state.v = cell.v;
  if (end - at.state.s <= 1e-15 * end) {
    at.state.s = end;
    ++at.cell;
    return;
  }
  if (at.state.a <= 0 && at.state.v >= cell.v / kOnLimit) return cruise(at, out);

  if (ride(at, out)) return;
  const Push all = push(at);
  const PathState& far = all.parts[all.size - 1].to;
  const auto fails = [&](const PathState& state, std::size_t k) {
    return state.v > cell.v * kOnLimit ? Wall{k, true} : level_off({k, state});
  };
  Wall wall = fails(far, at.cell + 1);
  if (wall.none()) {
    for (std::size_t i = 0; i < all.size; ++i) out.push_back(all.parts[i]);
    at = {at.cell + 1, far};
    return;
  }
  // The last instant from which it can still level off.
  std::size_t part = 0;
  if (all.size == 2) {
    const Wall first = fails(all.parts[0].to, at.cell);
    if (first.none()) {
      part = 1;
    } else {
      wall = first;
    }
  }
  const Stretch& last = all.parts[part];
  double low = 0;
  double high = last.duration;
  for (int i = 0; i < 100 && high - low > 1e-16 * high; ++i) {
    const double t = low + (high - low) / 2;
    if (!(t > low && t < high)) break;
    const Wall then = fails(advanced(last.from, last.jerk, t), at.cell);
    if (then.none()) {
      low = t;
    } else {
      high = t, wall = then;
    }
    if (i == kRoughly) {
      // It would meet the speed of a cell near by while that rises: along it instead.
      if (wall.speed && at.state.v > 0 && on_a_slope(at.cell, wall.cell) && slide(at, out)) return;
    }
  }
  const double before = at.state.s;
  if (part == 1) out.push_back(all.parts[0]);
  at.state = advanced(last.from, last.jerk, low);
  if (low > 0) out.push_back({last.from, at.state, last.jerk, low});
  // A start that is beyond its limits comes back as soon as it can.
  follow_level_off(at, low > 0 || part == 1 ? wall.cell : at.cell + 1, out);
  // A way too short to count for anything must not hold the sweep up.
  if (!(at.state.s > before)) cruise(at, out);
}

/// Steady jerk (as much of it as the cell allows) to the end of the cell, or until a is back to 0
/// and from there at that speed.
void UpSweep::glide(SweepState& at, double jerk, std::vector<Stretch>* out) const {
  const PathCell& cell = cells_[at.cell];
  const double end = cells_.end(at.cell);
  jerk = std::clamp(jerk, -cell.u, cell.u);
  const auto add = [&](double u, double t, double s) {
    const PathState to = arrived(at.state, u, t, s);
    if (out != nullptr && t > 0) out->push_back({at.state, to, u, t});
    at.state = to;
  };
  if (jerk < 0 && at.state.a > 0) {
    const double t = -at.state.a / jerk;
    const double s = at.state.s + t * (at.state.v + t * at.state.a / 3);
    if (s < end) {
      add(jerk, t, s);
      at.state.a = 0;
      if (out != nullptr) out->back().to.a = 0;
    }
  }
  if (at.state.s < end) {
    const double u = jerk < 0 && at.state.a <= 0 ? 0 : jerk;
    add(u, time_over(end - at.state.s, at.state, u), end);
  }
  ++at.cell;
}

/// Whether this steady jerk stays below the cells' speeds as far as a slide looks.
bool UpSweep::slides(SweepState at, double jerk) const {
  const std::size_t until = std::min(at.cell + kSlideLook, cells_.size());
  while (at.cell < until) {
    if (!enters(at)) return at.state.a <= 0;
    const PathCell& cell = cells_[at.cell];
    glide(at, jerk, nullptr);
    if (at.state.v > cell.v * kOnLimit || at.state.a > cell.a * kOnLimit) return false;
  }
  return at.cell >= cells_.size() || at.state.a <= 0 || level_off(at).none();
}

/// @return false: only full jerk, cell by cell, keeps below.
bool UpSweep::slide(SweepState& at, std::vector<Stretch>& out) const {
  double high = 0;
  for (std::size_t k = at.cell; k < std::min(at.cell + kSlideLook, cells_.size()); ++k) {
    high = std::max(high, cells_[k].u);
  }
  double low = -high;
  if (!slides(at, low)) return false;
  for (int i = 0; i < kSlideSteps; ++i) {
    const double jerk = low + (high - low) / 2;
    (slides(at, jerk) ? low : high) = jerk;
  }
  const std::size_t until = std::min(at.cell + kSlideGo, cells_.size());
  while (at.cell < until) {
    glide(at, low, &out);
    if (at.state.a <= 0) break;
  }
  return true;
}

}  // namespace sinew::planning
