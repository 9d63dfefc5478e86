#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"
#include "sinew/planning/motion_planner.h"

/// Which blends of a motion cost time: there it stops.
namespace sinew::planning {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
/// So much longer than from stop to stop, of its time, is rounding.
constexpr double kNoCost = 1e-9;
/// So often a motion is planned anew, before it ends at its first corner.
constexpr int kRoundsMax = 6;

}  // namespace

/// What move `k` takes from stop to stop at least, s: its joints know nothing of its way.
double MotionPlanner::quickest_alone(std::size_t k, const Move& move) const {
  double longest = 0, ways = 0;
  for (std::size_t j = 0; j < limits_.size(); ++j) {
    motion::AxisLimits limits = limits_[j];
    limits.velocity *= move.joint_share;
    const double way = std::abs(corners_[k + 1].q[j] - corners_[k].q[j]);
    if (way > 0) longest = std::max(longest, motion::plan_axis(way, limits).duration());
    ways += way;
  }
  return std::max(longest, ways / (move.joint_share * shared_velocity_));
}

/// What move `k` takes from stop to stop, s; infinity where it cannot be made so.
double MotionPlanner::alone(std::size_t k, Move move) {
  if (!std::isnan(alone_[k])) return alone_[k];
  move.blend_radius = move.blend_joints = 0;
  alone_[k] = std::numeric_limits<double>::infinity();
  if (builder_.build(corners_[k], {&move, 1}, 0, scratch_) && !scratch_.joints.empty() &&
      !timing_.prepare(scratch_, limits_, 1, LawUse::kQuickest, shared_velocity_) &&
      !timing_.plan({}, 1, scratch_law_)) {
    alone_[k] = scratch_law_.duration();
  }
  return alone_[k];
}

/// What moves [from, to) of the motion, each to the middle of the blends at its ends, take longer
/// than from stop to stop, s. What is quicker than the joints alone could be is not looked at
/// closer.
double MotionPlanner::cost(std::size_t from, std::size_t to, std::span<const Move> moves) {
  double time = 0, least = 0, stopping = 0;
  for (std::size_t k = from; k < to; ++k) {
    time += section_times_[k];
    least += quickest_alone(k, moves[k]);
  }
  if (time <= least) return time - least;
  for (std::size_t k = from; k < to; ++k) stopping += alone(k, moves[k]);
  return time <= stopping * (1 + kNoCost) ? std::min(time - stopping, 0.0) : time - stopping;
}

/// The corner whose two moves lose most by its blend.
std::optional<CornerStop> MotionPlanner::costliest(std::span<const Move> moves) {
  const std::size_t count = section_times_.size();
  CornerStop worst{count, -std::numeric_limits<double>::infinity()};
  for (std::size_t k = 0; k + 1 < count; ++k) {
    if (needed_[k]) continue;
    const double lost = cost(k, k + 2, moves);
    if (lost > worst.lost) worst = {k, lost};
  }
  if (worst.move == count) return std::nullopt;
  // Ends may lose what no corner between them does by itself.
  if (!(worst.lost > 0)) worst.lost = cost(0, count, moves);
  return worst.lost > 0 ? std::optional(worst) : std::nullopt;
}

/// Whether the moves behind corner `k` can be made from rest.
bool MotionPlanner::can_stop_at(std::size_t k, std::span<const Move> moves, std::size_t first) {
  const RobotPlace& from = corners_[k + 1];
  const std::size_t next = first + k + 1;
  double clearance = 0;
  return builder_.build(from, moves, next, scratch_) &&
         (scratch_.joints.empty() || !check_contacts(from, next, scratch_, clearance));
}

void MotionPlanner::leave_out_blends(const RobotPlace& start, std::span<const Move> moves,
                                     std::size_t first, PlannedMotion& out) {
  const std::size_t blended = out.stretch.moves;
  corners_.clear();
  for (std::size_t k = 0; k < blended; ++k) corners_.push_back(builder_.corner_before(k));
  corners_.push_back(out.stretch.end);
  alone_.assign(blended, kUnknown);
  needed_.assign(blended, false);
  for (int round = 0; out.stretch.moves > 1; ++round) {
    section_times_.clear();
    for (const LimitTimes& section : timing_.section_limit_times()) {
      section_times_.push_back(section.total());
    }
    const std::size_t count = section_times_.size();
    std::optional<CornerStop> stop;
    while ((stop = costliest(moves.subspan(first))) && !can_stop_at(stop->move, moves, first)) {
      needed_[stop->move] = true;
    }
    if (!stop) break;
    if (round == kRoundsMax && can_stop_at(0, moves, first)) stop->move = 0;
    stop->move += first;
    if (!make(start, moves.first(stop->move + 1), first, out)) {
      out.stop = stop;
    } else {
      // Not without this blend: as it was, which could be made.
      needed_[stop->move - first] = true;
      const auto refusal = make(start, moves.first(first + count), first, out);
      SINEW_ASSERT(!refusal);
    }
    if (round > kRoundsMax) break;
  }
}

}  // namespace sinew::planning
