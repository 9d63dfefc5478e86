#include "sinew/planning/timing/path_timing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew::planning {
namespace {

// Rounding's breadth of speeds that should be equal, relative.
constexpr double kSameSpeed = 1e-10;

// A law with a larger jump than this, as shares of length, speed and acceleration, is not given
// out.
constexpr double kBreak = 1e-7;
constexpr double kBreakAcceleration = 1e-3;
// Of the speed and braking before: what is left of them at the end of a path is rounding.
constexpr double kAtRest = 1e-3;
constexpr double kOnLimit = 1 + 1e-9;
constexpr double kSlowest = 1e-12;  // of a cell's speed, acceleration and jerk
constexpr double kNoSpeed = 1e-9;   // of a cell's: below 0 by so much is rounding
constexpr double kSlides = 0.9;     // of a cell's speed: it is what binds
constexpr double kInstant = 1e-13;  // s; shorter is rounding

bool finite(const PathState& state) {
  return std::isfinite(state.s) && std::isfinite(state.v) && std::isfinite(state.a);
}

Error bad_input(int index, double measured = 0, double limit = 0) {
  return {ErrorCode::kMotionInput, static_cast<std::int8_t>(index), measured, limit};
}

/// From the beginning of `stretch` to a state in it: near to rest the way hardly tells the time.
double time_between(const Stretch& stretch, const PathState& state) {
  const auto& [s, v, a] = stretch.from;
  if (stretch.jerk == 0 || state.v > 0.01 * v)
    return time_over(state.s - s, stretch.from, stretch.jerk);
  return (state.a - a) / stretch.jerk;
}

}  // namespace

void LimitTimes::add(const LimitTimes& other) {
  for (std::size_t i = 0; i < seconds_.size(); ++i) seconds_[i] += other.seconds_[i];
}

double LimitTimes::total() const {
  double sum = 0;
  for (const double seconds : seconds_) sum += seconds;
  return sum;
}

PathLimit LimitTimes::largest() const {
  const auto i = static_cast<std::size_t>(std::max_element(seconds_.begin(), seconds_.end()) -
                                          seconds_.begin());
  return {static_cast<LimitKind>(i / (kMaxJoints + 1)),
          static_cast<std::int8_t>(static_cast<int>(i % (kMaxJoints + 1)) - 1)};
}

PathTiming::PathTiming(std::size_t cells_max)
    : grid_(cells_max), curve_(cells_max), draft_(kStretchesPerCell * cells_max) {
  down_.reserve(phases_max());
  up_.reserve(phases_max());
  way_.reserve(phases_max());
  speeds_.reserve(cells_max);
  limit_times_.reserve(kSectionsMax);
}

std::optional<Error> PathTiming::prepare(const PlannedPath& path,
                                         std::span<const motion::AxisLimits> limits, double feed,
                                         LawUse use, double shared_velocity) {
  const auto good = [](double x) { return std::isfinite(x) && x > 0; };
  if (limits.size() != path.joints.joints() || path.joints.empty() ||
      path.tool.size() != path.joints.size() || path.sections.empty() || !good(feed) ||
      !(shared_velocity > 0)) {
    return bad_input(-1);
  }
  for (std::size_t j = 0; j < limits.size(); ++j) {
    const auto& [v, a, u] = limits[j];
    if (!good(v) || !good(a) || !good(u)) return bad_input(static_cast<int>(j));
  }
  for (const PathSection& section : path.sections) {
    if (!(section.tool_speed > 0) || !(section.tool_acceleration > 0) ||
        !(section.joint_share > 0 && section.joint_share <= 1)) {
      return bad_input(-1);
    }
  }
  if (path.sections.size() > kSectionsMax) {
    return Error{ErrorCode::kProgramTooLong, -1, static_cast<double>(path.sections.size()),
                 static_cast<double>(kSectionsMax)};
  }
  if (!grid_.build(path, limits, shared_velocity)) {
    return Error{ErrorCode::kProgramTooLong, -1, static_cast<double>(path.joints.size()),
                 static_cast<double>(grid_.capacity())};
  }
  for (std::size_t i = 0; i < grid_.size(); ++i) {
    const PathCell& cell = grid_[i];
    for (const double x : {cell.v_joints * cell.share, cell.v_tool, cell.v_shape, cell.a, cell.u}) {
      if (!(x >= kSlowest)) return bad_input(-1, x, kSlowest);
    }
  }
  feed_max_ = feed_given_ = feed_most_ = ceiling_ = feed;
  quick_until_ = -1;
  grid_.set_feed(feed);
  limit_times_.resize(path.sections.size());
  use_ = use;
  refined_ = false;
  const bool curve =
      use == LawUse::kQuickest && grid_.curved() && curve_.prepare(path, limits, shared_velocity);
  if (!curve) curve_.clear();
  if (use == LawUse::kChangeable) refine();
  return {};
}

std::optional<Error> PathTiming::begin(double s, double feed) {
  if (!(s >= 0 && s < grid_.length()) || !(feed > 0 && feed <= feed_max_)) return bad_input(-1);
  if (use_ != LawUse::kQuickest || !curve_.prepared()) return bad_input(-1);
  curve_.begin(s, feed);
  return {};
}

bool PathTiming::advance(std::size_t cells, TimeLaw& out) {
  if (!curve_.advance(cells)) return false;
  write_curve(out);
  return true;
}

/// @return false: no such law.
bool PathTiming::write_curve(TimeLaw& out) {
  begin_law({curve_.start(), 0, 0}, out);
  if (!curve_.found()) return false;
  curve_.for_each_phase([&](const SpeedCurve::Phase& phase, const PathState& end,
                            const PathLimit& limit, std::size_t section) {
    out.append(phase.jerk, phase.duration, end);
    limit_times_[section].add(limit, phase.duration);
  });
  return true;
}

/// Plans once from rest to rest, and gives what its speeds leave to acceleration and jerk.
void PathTiming::refine() {
  if (refined_ || !grid_.curved()) return;
  refined_ = true;
  if (grid_.feed() != feed_max_) grid_.set_feed(feed_max_);
  draft_.clear();
  begin_law({}, draft_);
  if (sweep_back(0)) static_cast<void>(go({}, draft_));
  grid_.refine(speeds_);
}

void PathTiming::begin_law(const PathState& start, TimeLaw& out) {
  out.clear(start);
  unbroken_ = true;
  speeds_.assign(grid_.size(), 0);
  cell_ = grid_.cell_at(start.s);
  std::fill(limit_times_.begin(), limit_times_.end(), LimitTimes{});
}

/// How long a stretch takes as the next one of `out`: at steady speed its way tells that, so that
/// nothing jumps at its end.
double PathTiming::exact_duration(const Stretch& stretch, const TimeLaw& out) {
  const auto phases = out.phases();
  const bool same = !phases.empty() && phases.back().jerk == stretch.jerk;
  const PathState& begin = same ? phases.back().state : out.end();
  const double gone = same ? out.duration() - phases.back().t : 0;
  double duration = stretch.duration;
  if (stretch.jerk == 0 && begin.a == 0 && begin.v > 0) {
    duration = (stretch.to.s - begin.s) / begin.v - gone;
  }
  const double off = std::abs(duration - stretch.duration);
  return off <= kBreakAcceleration * (gone + stretch.duration) ? duration : stretch.duration;
}

/// Puts the end of `out` to a state that it has come to but for rounding.
void PathTiming::put(const PathState& state, TimeLaw& out) {
  state.v == 0 && state.a == 0 ? out.end_at_rest(state.s) : out.append(0, 0, state);
}

void PathTiming::emit(const Stretch& stretch, TimeLaw& out) {
  const PathState end = advanced(stretch.from, stretch.jerk, stretch.duration);
  const PathCell& near = grid_[std::min(cell_, grid_.size() - 1)];
  const auto same = [&](const PathState& one, const PathState& other) {
    return std::abs(one.s - other.s) <= kBreak * grid_.length() &&
           std::abs(one.v - other.v) <= kBreak * near.v &&
           std::abs(one.a - other.a) <= kBreakAcceleration * near.a;
  };
  unbroken_ =
      unbroken_ && stretch.to.v >= 0 && same(stretch.from, out.end()) && same(end, stretch.to);
  if (!out.has_room(1)) {
    unbroken_ = false;
    return;
  }
  // What takes no time but for rounding is no phase.
  if (!(stretch.duration > kInstant)) return put(stretch.to, out);
  out.append(stretch.jerk, exact_duration(stretch, out), stretch.to);
  const double middle = stretch.from.s + (stretch.to.s - stretch.from.s) / 2;
  while (cell_ + 1 < grid_.size() && grid_.begin(cell_ + 1) <= middle) ++cell_;
  speeds_[cell_] = std::max({speeds_[cell_], stretch.from.v, stretch.to.v});
  limit_times_[grid_[cell_].section].add(binding(stretch), stretch.duration);
}

PathLimit PathTiming::binding(const Stretch& stretch) const {
  const PathCell& cell = grid_[cell_];
  constexpr double kNearly = 0.99;
  if (std::abs(stretch.jerk) >= kNearly * cell.u) return {LimitKind::kJointJerk, cell.jerk_joint};
  const double a = std::max(std::abs(stretch.from.a), std::abs(stretch.to.a));
  const double v = std::max(stretch.from.v, stretch.to.v);
  if (a >= kNearly * cell.a && a > 0) return cell.acceleration;
  // A slide along rising speeds touches only some of them.
  if (a == 0 || v >= kSlides * cell.v) return grid_.speed_limit(cell_);
  return a / cell.a > v / cell.v ? cell.acceleration : grid_.speed_limit(cell_);
}

LimitTimes PathTiming::limit_times() const {
  LimitTimes all;
  for (const LimitTimes& section : limit_times_) all.add(section);
  return all;
}

/// For one more step of a sweep, of which there were `steps`: a step comes by a cell, but for a
/// few.
bool PathTiming::has_room(const std::vector<Stretch>& stretches, std::size_t cell,
                          std::size_t steps) const {
  constexpr std::size_t kStretchesPerStep = 16;
  return stretches.size() + grid_.size() - cell + kStretchesPerStep <= stretches.capacity() &&
         steps <= kStretchesPerCell * grid_.size() + kStretchesPerStep;
}

/// @return false: not in as many steps as there may be
bool PathTiming::sweep_back(double to) {
  down_.clear();
  const UpSweep sweep(grid_, false);
  const double end = grid_.length() - to;
  SweepState at;
  for (std::size_t steps = 0; at.cell < grid_.size() && at.state.s <= end; ++steps) {
    if (!has_room(down_, at.cell, steps)) return false;
    sweep.step(at, down_);
  }
  const double length = grid_.length();
  std::reverse(down_.begin(), down_.end());
  // Borders of cells are the same number in both directions: L - (L - s) is not always s.
  std::size_t border = grid_.cell_at(to);
  const auto forwards = [&](const PathState& back) {
    PathState state{length - back.s, back.v, -back.a};
    const double near = 1e-15 * length;
    while (border < grid_.size() && grid_.begin(border) < state.s - near) ++border;
    if (std::abs(grid_.begin(border) - state.s) <= near) state.s = grid_.begin(border);
    return state;
  };
  for (Stretch& stretch : down_) {
    const Stretch back = stretch;
    stretch.from = forwards(back.to);
    stretch.to = forwards(back.from);
  }
  return !down_.empty();
}

std::size_t PathTiming::down_stretch(double s) const {
  const auto after =
      std::upper_bound(down_.begin(), down_.end(), s,
                       [](double at, const Stretch& stretch) { return at < stretch.from.s; });
  return after == down_.begin() ? 0 : static_cast<std::size_t>(after - down_.begin()) - 1;
}

PathState PathTiming::down_at(std::size_t stretch, double s, Target target) const {
  return target == Target::kRest ? PathState{s, 0, 0} : state_at(down_[stretch], s);
}

SweepState PathTiming::in_cell(const PathState& state) const {
  return {grid_.cell_at(state.s), state};
}

/// `jerk` from x to `end` (s), or to where its acceleration turns or it stops, if that is before.
PathTiming::Leg PathTiming::leg(const PathState& x, double jerk, double end) {
  const double turn = -x.a / jerk;
  const PathState turned = advanced(x, jerk, turn);
  if (turn > 0 && turned.v > 0 && turned.s <= end && turned.s > x.s) {
    return {{x, {turned.s, turned.v, 0}, jerk, turn}, false};
  }
  double t = time_over(end - x.s, x, jerk);
  const bool stops = !std::isfinite(t);
  if (stops) {
    t = std::max(0.0, (-x.a - std::sqrt(std::max(0.0, x.a * x.a - 2 * jerk * x.v))) / jerk);
    end = std::clamp(advanced(x, jerk, t).s, x.s, end);
  }
  PathState y = advanced(x, jerk, t);
  y.s = end;
  if (stops) y.v = 0;
  return {{x, y, jerk, t}, stops};
}

/// Where on `own` its acceleration is that of the target: a secant with a bracket.
double PathTiming::meeting_place(const Stretch& own, double sign, Target target,
                                 std::size_t down) const {
  double low = own.from.s;
  double high = own.to.s;
  double f_low = sign * (own.from.a - down_at(down, low, target).a);
  double f_high = sign * (own.to.a - down_at(down, high, target).a);
  double s = high;
  for (int i = 0; i < 60 && high - low > 1e-16 * high && f_high != 0; ++i) {
    s = (low * f_high - high * f_low) / (f_high - f_low);
    if (!(s > low && s < high)) s = low + (high - low) / 2;
    const double f = sign * (state_at(own, s).a - down_at(down, s, target).a);
    if (f == 0) break;
    if (f > 0) {
      if (high - s < 1e-16 * high) break;
      high = s, f_high = f, f_low /= 2;
    } else {
      if (s - low < 1e-16 * high) break;
      low = s, f_low = f, f_high /= 2;
    }
  }
  return s;
}

PathTiming::Meeting PathTiming::meet(SweepState from, double sign, Target target,
                                     std::vector<Stretch>* way) const {
  std::size_t down = target == Target::kDown ? down_stretch(from.state.s) : 0;
  PathState& x = from.state;
  const double speed = x.v;
  double braking = -x.a;
  const auto meets = [&](const PathState& state) {
    return sign * (state.a - down_at(down, state.s, target).a) >= 0;
  };
  const auto meeting_at = [&](const PathState& own, bool at_once) {
    return Meeting{true, at_once, down_at(down, own.s, target).v - own.v, own, down};
  };
  if (meets(x)) return meeting_at(x, true);
  // A leg ends at a border, or where it turns or stops.
  std::size_t legs = 3 * (grid_.size() + down_.size()) + 8;
  for (; from.cell < grid_.size(); ++from.cell) {
    const double jerk = sign * grid_[from.cell].u;
    const double cell_end = grid_.begin(from.cell + 1);
    braking = std::max(braking, -x.a);
    while (x.s < cell_end) {
      if (legs-- == 0 || (way != nullptr && way->size() + 1 > way->capacity())) return {};
      const bool down_first = target == Target::kDown && down_[down].to.s <= cell_end;
      const double end = down_first ? down_[down].to.s : cell_end;
      const PathState turned = advanced(x, jerk, -x.a / jerk);
      if (sign * x.a < 0 && turned.v > 0 && !(turned.s > x.s)) {
        x.a = 0;  // it was but for rounding
        if (meets(x)) return meeting_at(x, false);
      }
      const auto [own, stops] = leg(x, jerk, end);
      if (meets(own.to)) {
        const double s = meeting_place(own, sign, target, down);
        const PathState there = s == own.to.s ? own.to : state_at(own, s);
        // The time from the acceleration: near to rest the way hardly tells it.
        if (way != nullptr) way->push_back({x, there, jerk, (there.a - x.a) / jerk});
        return meeting_at(there, false);
      }
      if (way != nullptr) way->push_back(own);
      const std::size_t next = from.cell + 1;
      // Too quick for a narrow cell: no way to what lies behind it.
      if (sign > 0 && own.to.s >= cell_end && next < grid_.size() &&
          own.to.v > grid_.speed_at(next, ceiling_) * kOnLimit) {
        return {};
      }
      if (stops) return meeting_at(own.to, false);
      x = own.to;
      if (down_first && x.s >= end) {
        if (down + 1 == down_.size()) break;
        ++down;
      }
    }
  }
  // The end of the path, at rest but for rounding.
  if (target == Target::kRest && x.v <= kAtRest * speed && -x.a <= kAtRest * braking) {
    x = {grid_.length(), 0, 0};
    if (way != nullptr && !way->empty()) way->back().to = x;
    return {true, false, 0, x, down};
  }
  return {};
}

void PathTiming::level_up(SweepState& at) {
  while (at.state.a < 0 && at.cell < grid_.size()) {
    const double jerk = grid_[at.cell].u;
    const PathState from = at.state;
    const double t = -from.a / jerk;
    const PathState level = advanced(from, jerk, t);
    const double end = grid_.begin(at.cell + 1);
    if (level.s <= end) {
      unbroken_ = unbroken_ && level.v >= -kBreak * grid_[at.cell].v;
      at.state = {level.s, std::max(level.v, 0.0), 0};
      up_.push_back({from, at.state, jerk, t});
      return;
    }
    const double over = time_over(end - from.s, from, jerk);
    at.state = advanced(from, jerk, over);
    at.state.s = end;
    up_.push_back({from, at.state, jerk, over});
    ++at.cell;
  }
}

/// Forwards and up, until it has passed over into the backward motion, or stands below of it with
/// nothing to gain from going up at once. @return on the backward motion
bool PathTiming::rise(SweepState& at, TimeLaw& out) {
  const UpSweep sweep(grid_, true);
  up_.clear();
  level_up(at);
  std::size_t checked = 0;
  std::size_t down = down_stretch(at.state.s);
  for (std::size_t steps = 0;; ++steps) {
    for (; checked < up_.size(); ++checked) {
      const PathState& to = up_[checked].to;
      while (down + 1 < down_.size() && down_[down].to.s < to.s) ++down;
      const PathState other = state_at(down_[down], to.s);
      if (to.v > other.v * (1 + kSameSpeed)) {
        up_.resize(checked + 1);
        return pass_over(at, out);
      }
      if (to.a == 0 && other.a == 0 && to.v >= other.v * (1 - kSameSpeed)) {
        up_.resize(checked + 1);
        for (const Stretch& stretch : up_) emit(stretch, out);
        at.state = to;
        return true;
      }
    }
    if (at.cell >= grid_.size()) {
      // Only rounding's breadth was left.
      for (const Stretch& stretch : up_) emit(stretch, out);
      at.state = {grid_.length(), 0, 0};
      put(at.state, out);
      return false;
    }
    if (!has_room(up_, at.cell, steps)) {
      unbroken_ = false;
      return false;
    }
    sweep.step(at, up_);
  }
}

bool PathTiming::pass_over(SweepState& at, TimeLaw& out) {
  const auto gap_from = [&](const PathState& state) {
    const Meeting meeting = meet(in_cell(state), -1, Target::kDown, nullptr);
    return meeting.found ? meeting.gap : -std::numeric_limits<double>::infinity();
  };
  // The last stretch at whose beginning it still can.
  std::size_t low_index = 0;
  std::size_t high_index = up_.size();
  // Gallop back from the crossing: the place is near to it.
  for (std::size_t back = 1; back < high_index; back *= 2) {
    const std::size_t i = up_.size() - back;
    if (gap_from(up_[i].from) >= 0) {
      low_index = i;
      break;
    }
    high_index = i;
  }
  while (high_index - low_index > 1) {
    const std::size_t i = low_index + (high_index - low_index) / 2;
    (gap_from(up_[i].from) >= 0 ? low_index : high_index) = i;
  }
  const Stretch leave = up_[low_index];
  double low = 0, high = leave.duration;
  double f_low = gap_from(leave.from);
  double f_high = gap_from(leave.to);
  if (f_high >= 0) low = high, f_low = f_high;
  int same = 0;
  for (int i = 0; i < 200 && high - low > 1e-16 * high && f_low > 0; ++i) {
    double t = low + (high - low) / 2;
    if (std::isfinite(f_high) && i % 4 != 3) t = (low * f_high - high * f_low) / (f_high - f_low);
    if (!(t > low && t < high)) t = low + (high - low) / 2;
    if (!(t > low && t < high)) break;
    const double f = gap_from(advanced(leave.from, leave.jerk, t));
    if (f >= 0) {
      low = t, f_low = f;
      if (same > 0) f_high /= 2;
      same = 1;
    } else {
      high = t, f_high = f;
      if (same < 0) f_low /= 2;
      same = -1;
    }
  }
  for (std::size_t i = 0; i < low_index; ++i) emit(up_[i], out);
  const PathState from = low > 0 ? advanced(leave.from, leave.jerk, low) : leave.from;
  emit({leave.from, from, leave.jerk, low}, out);
  way_.clear();
  const Meeting meeting = meet(in_cell(from), -1, Target::kDown, &way_);
  for (const Stretch& stretch : way_) emit(stretch, out);
  unbroken_ = unbroken_ && meeting.found;
  at = meeting.found ? in_cell(meeting.own) : in_cell(from);
  return meeting.gap <= kSameSpeed * at.state.v;
}

/// Along the backward motion, to where it jumps up: there is more to gain from there.
void PathTiming::follow_down(SweepState& at, TimeLaw& out) {
  std::size_t i = down_stretch(at.state.s);
  // At a jump the stretch that ends there is meant.
  if (i > 0 && down_[i].from.s >= at.state.s) --i;
  PathState from = state_at(down_[i], at.state.s);
  put(from, out);
  while (true) {
    const Stretch& stretch = down_[i];
    const double done = from.s > stretch.from.s ? time_between(stretch, from) : 0;
    emit({from, stretch.to, stretch.jerk, stretch.duration - done}, out);
    at.state = stretch.to;
    if (i + 1 == down_.size()) {
      at.state = {grid_.length(), 0, 0};
      put(at.state, out);
      at.cell = grid_.size();
      return;
    }
    ++i;
    from = down_[i].from;
    if (from.v > at.state.v * (1 + kSameSpeed)) break;
  }
  at.cell = grid_.cell_at(at.state.s);
}

/// Whether full jerk downwards keeps this state below the backward motion until it follows that.
bool PathTiming::stays_below(const SweepState& at) const {
  const Meeting meeting = meet(at, -1, Target::kDown, nullptr);
  return meeting.found && meeting.gap >= -kSameSpeed * (at.state.v + meeting.own.v);
}

Error PathTiming::not_planned(const PathState& start) const {
  return bad_input(-1, start.s, grid_.length());
}

std::optional<Error> PathTiming::go(const PathState& start, TimeLaw& out) {
  SweepState at = in_cell(start);
  bool on_down = false;
  if (!stays_below(at)) {
    const auto landed = descend(at, Target::kDown, out);
    if (!landed) return not_planned(start);
    on_down = *landed;
  }
  // Each turn comes by a cell at least.
  for (std::size_t turns = 0; at.cell < grid_.size(); ++turns) {
    if (!unbroken_ || turns > 2 * grid_.size() + 8) return not_planned(start);
    if (!on_down) on_down = rise(at, out);
    if (on_down) follow_down(at, out);
    on_down = false;
  }
  return unbroken_ ? std::nullopt : std::optional(not_planned(start));
}

/// What is below 0 by rounding's breadth stands.
PathState PathTiming::begun(PathState start) const {
  const double v = grid_[grid_.cell_at(start.s)].v;
  if (start.v < 0 && start.v >= -kNoSpeed * v) start.v = 0;
  return start;
}

std::optional<Error> PathTiming::plan(const PathState& from, double feed, TimeLaw& out) {
  const PathState start = begun(from);
  if (!finite(start) || start.s < 0 || start.s > grid_.length() || start.v < 0 || !(feed > 0) ||
      feed > feed_max_) {
    return bad_input(-1);
  }
  const bool moves = start.v != 0 || start.a != 0;
  if (use_ == LawUse::kQuickest) {
    if (moves) return bad_input(-1);
    constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
    if (!begin(start.s, feed) && curve_.advance(kAll) && write_curve(out)) {
      if (curve_.settled()) return {};
      const double first = out.duration();
      if (curve_.refine() && !begin(start.s, feed) && curve_.advance(kAll) && write_curve(out) &&
          curve_.settled() && out.duration() < first) {
        return {};
      }
      const double duration = curve_.found() ? out.duration() : 0;
      if (!plan_sweeps(start, feed, out) && (duration == 0 || out.duration() < duration)) return {};
      if (duration > 0) write_curve(out);
      return duration > 0 ? std::nullopt : plan_sweeps(start, feed, out);
    }
  }
  return plan_sweeps(start, feed, out);
}

std::optional<Error> PathTiming::plan_sweeps(const PathState& start, double feed, TimeLaw& out) {
  refine();
  const bool guarded = use_ == LawUse::kChangeable;
  const double feed_most = std::max(feed, start.v > 0 ? feed_at(start) : 0);
  ceiling_ = feed_most;
  if (feed != grid_.feed()) grid_.set_feed(feed);
  begin_law(start, out);
  if (start.s >= grid_.length()) return {};
  const auto given_out = [&] {
    if (!guarded) return true;
    if (broken_cell(out, feed_most)) return false;
    give_out(out, feed, feed_most);
    return true;
  };
  if (!sweep_back(start.s)) return not_planned(start);
  if (!go(start, out) && given_out()) return {};
  // Rarely a moving start lies so that neither way leads on: to rest first, and on from there.
  begin_law(start, out);
  if ((start.v != 0 || start.a != 0) && brake(out) && !go(out.end(), out) && given_out()) return {};
  return not_planned(start);
}

std::optional<Error> PathTiming::stop(const PathState& from, TimeLaw& out) {
  const PathState start = begun(from);
  if (!finite(start) || start.s < 0 || start.s > grid_.length() || start.v < 0) {
    return bad_input(-1);
  }
  begin_law(start, out);
  if (start.v == 0 && start.a == 0) return {};
  if (use_ == LawUse::kQuickest) return bad_input(-1);
  const double feed_most = ceiling_ = feed_at(start);
  if (brake(out) && !broken_cell(out, feed_most)) {
    give_out(out, feed_given_, feed_most);
    return {};
  }
  // On the last way into the end of the path: there.
  return plan(start, grid_.feed(), out);
}

}  // namespace sinew::planning
