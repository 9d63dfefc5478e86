#include "sinew/program/plans/whole_moves.h"

#include <algorithm>

#include "sinew/planning/paths/motion_limits.h"

namespace sinew::program {

WholeMoves::WholeMoves(const JointVector& q_start, const RowMotion& motion, double speed,
                       const RobotModel& robot)
    : delay_(robot.device.settings->motion_delay()), q_start_(q_start), duration_(motion.duration) {
  const auto times = robot.device.settings->separate_moves(robot);
  double order = 0;
  JointVector from = q_start;
  pieces_.reserve(motion.pieces.size());
  for (const JointMove& move : motion.pieces) {
    Piece& piece = pieces_.emplace_back(Piece{order, move.q, {}});
    if (times) {
      order += add_separate(piece, from, *times, robot);
    } else {
      const double seconds = to_seconds(move.duration);
      add_together(piece, from, seconds, speed, robot);
      order += seconds + to_seconds(delay_.report);
    }
    from = move.q;
  }
}

void WholeMoves::add_together(Piece& piece, const JointVector& from, double seconds, double speed,
                              const RobotModel& robot) const {
  const motion::RestToRest profile = profile_between(from, piece.q, robot, speed);
  if (!(profile.duration() > 0)) return;
  piece.lanes.push_back(
      {0, profile, piece.begin + to_seconds(delay_.arrival), seconds / profile.duration()});
}

/// Each by itself, once it was commanded.
/// @return  s until the driver has reported that all joints are there
double WholeMoves::add_separate(Piece& piece, const JointVector& from, SeparateMoves& times,
                                const RobotModel& robot) {
  const auto limits = planning::motion_limits(robot);
  JointVector own;
  for (std::size_t j = 0; j < from.size(); ++j) {
    const double begin = times.target(j, from[j]);
    const double end = times.target(j, piece.q[j]);
    piece.q[j] = end;
    const motion::RestToRest profile({&begin, 1}, {&end, 1}, {&limits[j], 1});
    own.push_back(profile.duration());
    if (profile.duration() > 0) piece.lanes.push_back({j, profile, 0, 1});
  }
  const SeparateMoves::Move move = times.next({own.data(), own.size()});
  for (Lane& lane : piece.lanes) lane.begin = piece.begin + move.start[lane.first];
  return move.report;
}

void WholeMoves::sample(double t, planning::JointMotion& out) const {
  out = {};
  const auto after =
      std::upper_bound(pieces_.begin(), pieces_.end(), t,
                       [](double at, const Piece& piece) { return at < piece.begin; });
  if (after == pieces_.begin()) {
    std::ranges::copy(q_start_, out.q.begin());
    return;
  }
  const Piece& piece = *(after - 1);
  std::ranges::copy(piece.q, out.q.begin());
  for (const Lane& lane : piece.lanes) {
    const double own = (t - lane.begin) / lane.stretch;
    const double rate = 1 / lane.stretch;
    // What a profile's jerk is between its corners its acceleration tells.
    constexpr double kStep = 1e-6;  // s
    motion::AxisStates at;
    motion::AxisStates before;
    motion::AxisStates behind;
    lane.profile.sample(own, at);
    lane.profile.sample(own - kStep, before);
    lane.profile.sample(own + kStep, behind);
    const bool moves = own > 0 && own < lane.profile.duration();
    for (std::size_t k = 0; k < lane.profile.size(); ++k) {
      const std::size_t j = lane.first + k;
      out.q[j] = at.q[k];
      if (!moves) continue;
      out.qd[j] = at.qd[k] * rate;
      out.qdd[j] = at.qdd[k] * rate * rate;
      out.qddd[j] = (behind.qdd[k] - before.qdd[k]) / (2 * kStep) * rate * rate * rate;
    }
  }
}

}  // namespace sinew::program
