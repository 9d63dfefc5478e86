#include <algorithm>
#include <cmath>

#include "sinew/planning/timing/path_timing.h"

/// How a motion that is too quick, or shall stop, brakes.
namespace sinew::planning {
namespace {

constexpr double kSameSpeed = 1e-10;  // relative: rounding
constexpr double kOnLimit = 1 + 1e-9;
constexpr double kEarly = 1e-3;    // of a part of braking
constexpr double kStands = 1e-12;  // of the speed before
constexpr int kBlockedLooks = 16;  // at a part of braking that cannot be taken back at once

}  // namespace

/// Largest braking from `at` to the end of its cell, or to where it stops.
std::size_t PathTiming::brake_parts(const SweepState& at, Stretch (&parts)[3]) const {
  const PathCell& cell = grid_[at.cell];
  const double end = grid_.begin(at.cell + 1);
  PathState x = at.state;
  std::size_t size = 0;
  const auto add = [&](double jerk, double t) {
    const double over = time_over(end - x.s, x, jerk);
    const bool ends = over <= t;
    t = std::min(t, over);
    PathState y = advanced(x, jerk, t);
    if (ends) y.s = end;
    y.v = std::max(y.v, 0.0);
    if (t > 0) parts[size++] = {x, y, jerk, t};
    x = y;
    return ends || y.v <= 0;
  };
  if (x.a > 0) {
    if (add(-cell.u, x.a / cell.u)) return size;
    x.a = 0;
  }
  if (x.a > -cell.a) {
    const double to_stop = (x.a + std::sqrt(x.a * x.a + 2 * cell.u * x.v)) / cell.u;
    const double to_limit = (x.a + cell.a) / cell.u;
    if (add(-cell.u, std::min(to_stop, to_limit))) return size;
    if (to_limit <= to_stop) x.a = -cell.a;
  }
  add(0, x.a < 0 ? x.v / -x.a : 0);
  return size;
}

/// The first cell that would be entered with more braking than it allows if the braking were taken
/// back from here on with full jerk; size() where there is none.
std::size_t PathTiming::blocked_at(SweepState at) const {
  while (at.state.a < 0 && at.state.v > 0) {
    const double jerk = grid_[at.cell].u;
    const double end = grid_.begin(at.cell + 1);
    const double level = -at.state.a / jerk;
    const double over = time_over(end - at.state.s, at.state, jerk);
    if (!(over < level) || at.cell + 1 >= grid_.size()) break;
    at.state = advanced(at.state, jerk, over);
    at.state.s = end;
    ++at.cell;
    // Too quick for a narrow cell in any case: only braking on makes it slow enough in time.
    if (at.state.v > grid_.speed_at(at.cell, ceiling_) * kOnLimit) break;
    if (-at.state.a > grid_[at.cell].a * kOnLimit) return at.cell;
  }
  return grid_.size();
}

/// What full jerk upwards makes of a state.
PathTiming::Look PathTiming::look(const SweepState& from, Target target) const {
  const Meeting meeting = meet(from, 1, target, nullptr);
  Look result;
  // Slower, but on the way up too steeply: not there yet.
  const double near = target == Target::kDown ? kSameSpeed * from.state.v : 0;
  result.lands = meeting.found && meeting.gap >= -near &&
                 !(meeting.at_once && target == Target::kDown && !stays_below(from));
  result.blocked = result.lands ? grid_.size() : blocked_at(from);
  if (target == Target::kRest && meeting.found) {
    // It stands with some braking left: that would have stopped so much more.
    const PathState& own = meeting.own;
    result.slower = result.lands ? own.a * own.a / (2 * grid_[in_cell(own).cell].u) : meeting.gap;
  }
  return result;
}

/// The last instant of a part at whose end it `fails` to go on, up to which it does: [.., after).
/// Below 0: nowhere on it.
double PathTiming::goes_on_until(const SweepState& at, const Stretch& part, Target target,
                                 Look& fails, double& after) const {
  const std::size_t none = grid_.size();
  double low = 0;
  after = part.duration;
  Look begin = look({at.cell, part.from}, target);
  // Taken back at once the braking would come too late, which is too quick as well: where it has
  // braked for longer there is more time to take it back.
  for (int k = 1; k < kBlockedLooks && !begin.goes_on(none); ++k) {
    const double t = part.duration * k / kBlockedLooks;
    const Look there = look({at.cell, advanced(part.from, part.jerk, t)}, target);
    if (there.goes_on(none)) low = t, begin = there;
    if (there.lands) {
      after = t, fails = there;
      break;
    }
  }
  if (!begin.goes_on(none) && fails.blocked != none) return -1;
  double slower_low = begin.slower;
  for (int i = 0;; ++i) {
    const bool lands = fails.blocked == none;
    // Where less braking is allowed ahead, a stop that relaxes a little early costs next to
    // nothing.
    const bool early = target == Target::kRest && !lands;
    if (after - low <= (early ? kEarly : 1e-16) * part.duration) break;
    double t = low + (after - low) / 2;
    const bool knows = target == Target::kRest && lands && slower_low < 0 && fails.slower > 0;
    if (knows && -slower_low <= kStands * part.from.v) break;
    if (knows && i % 4 != 3) {
      t = (low * fails.slower - after * slower_low) / (fails.slower - slower_low);
    }
    if (!(t > low && t < after)) t = low + (after - low) / 2;
    if (!(t > low && t < after)) break;
    const Look there = look({at.cell, advanced(part.from, part.jerk, t)}, target);
    if (there.goes_on(none)) {
      low = t, slower_low = there.slower;
    } else {
      after = t, fails = there;
    }
  }
  return low;
}

/// Brakes as hard as it can until full jerk the other way leads into the target: onto the backward
/// motion, below it where that jumps, or to rest. @return on the target; none: the path ends before
std::optional<bool> PathTiming::descend(SweepState& at, Target target, TimeLaw& out) {
  const std::size_t none = grid_.size();
  if (look(at, target).lands) return land(at, target, out);
  while (at.cell < grid_.size()) {
    Stretch parts[3];
    const std::size_t size = brake_parts(at, parts);
    std::size_t next = at.cell + 1;
    for (std::size_t i = 0; i < size; ++i) {
      const Stretch& part = parts[i];
      const bool ends = part.to.s >= grid_.begin(at.cell + 1);
      Look fails = look({at.cell + (ends ? 1 : 0), part.to}, target);
      if (ends && next < none && -part.to.a > grid_[next].a * kOnLimit) {
        fails = {.blocked = next};
      }
      if (fails.goes_on(none) && part.to.v > 0) {
        emit(part, out);
        at.state = part.to;
        continue;
      }
      double after = 0;
      double until = goes_on_until(at, part, target, fails, after);
      const bool enters = !ends || next >= none || -part.to.a <= grid_[next].a * kOnLimit;
      if (until < 0 && enters && part.to.v > 0) {
        emit(part, out);
        at.state = part.to;
        continue;
      }
      until = std::max(until, 0.0);
      const bool lands = fails.blocked == none;
      // The instant after it: there it leads below the target where that jumps.
      if (lands && target == Target::kDown) until = after;
      at.state = advanced(part.from, part.jerk, until);
      emit({part.from, at.state, part.jerk, until}, out);
      // On the very last way into the end of the path.
      if (lands && !meet(at, 1, target, nullptr).found) return {};
      if (lands) return land(at, target, out);
      // Less braking is allowed from a cell on: there with as much as that.
      relax_until(at, fails.blocked, out);
      next = at.cell;
      break;
    }
    at.cell = next;
  }
  return {};
}

void PathTiming::relax_until(SweepState& at, std::size_t cell, TimeLaw& out) {
  while (at.cell < cell && at.state.a < 0) {
    const double jerk = grid_[at.cell].u;
    const double end = grid_.begin(at.cell + 1);
    const double over = time_over(end - at.state.s, at.state, jerk);
    if (!std::isfinite(over)) break;
    PathState to = advanced(at.state, jerk, over);
    to.s = end;
    emit({at.state, to, jerk, over}, out);
    at = {at.cell + 1, to};
  }
}

/// Full jerk upwards into the target. @return it is on it and not below
bool PathTiming::land(SweepState& at, Target target, TimeLaw& out) {
  way_.clear();
  const Meeting meeting = meet(at, 1, target, &way_);
  for (const Stretch& stretch : way_) emit(stretch, out);
  at = in_cell(meeting.own);
  const PathState other = down_at(meeting.down, at.state.s, target);
  const double same = kSameSpeed * grid_[at.cell].a;
  const bool touches = meeting.gap <= kSameSpeed * at.state.v && at.state.a <= other.a + same;
  if (target == Target::kRest) at.state = {at.state.s, 0, 0};
  if (target == Target::kDown && touches) at.state = other;
  put(at.state, out);
  return touches;
}

/// From the end of `out` to rest. @return on the path
bool PathTiming::brake(TimeLaw& out) {
  const PathState end = out.end();
  if (end.v == 0 && end.a == 0) return true;
  SweepState at = in_cell(end);
  return descend(at, Target::kRest, out).has_value() && unbroken_;
}

}  // namespace sinew::planning
