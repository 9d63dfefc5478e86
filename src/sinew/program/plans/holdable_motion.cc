#include "sinew/program/plans/holdable_motion.h"

#include <utility>

#include "sinew/control/path_motion.h"
#include "sinew/control/piece_motion.h"

namespace sinew::program {

Expected<std::unique_ptr<control::MotionSource>> holdable_motion(
    const RobotModel& limits, const JointVector& q_start, const RowMotion& motion,
    const planning::PlannedMotion& planned, double feed, std::vector<LinkPair> overlaps) {
  if (limits.device.capability.motion != MotionKind::kStream) {
    return std::make_unique<control::PieceMotion>(q_start, motion.pieces, limits,
                                                  std::move(overlaps));
  }
  auto path = std::make_unique<control::PathMotion>(limits, std::move(overlaps));
  if (const auto error = path->start(planned.path, feed, motion.time)) {
    return std::unexpected(*error);
  }
  return path;
}

}  // namespace sinew::program
