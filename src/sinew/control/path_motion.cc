#include "sinew/control/path_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"
#include "sinew/planning/paths/motion_limits.h"

namespace sinew::control {

double piece_time(double seconds) {
  return std::ceil(seconds * 1e9 - 1e-3) * 1e-9;
}

SegmentTime segment_time(double left, double longest) {
  if (left <= longest / 2) return {left, longest / 2};
  // What rounding leaves of a whole number of segments is no segment.
  const double segments = std::max(1.0, std::ceil(left / longest - 1e-6));
  const double whole = piece_time(left / segments);
  return {segments == 1 ? left : whole, whole};
}

PathMotion::PathMotion(const RobotModel& robot, std::vector<LinkPair> overlaps)
    : limits_(planning::motion_limits(robot)),
      shared_velocity_(planning::shared_velocity(robot)),
      segment_(to_seconds(robot.device.capability.segment)),
      overlaps_(std::move(overlaps)),
      path_(robot.joints.size(), 0, 0) {
  SINEW_ASSERT(robot.device.capability.motion == MotionKind::kStream && segment_ > 0);
}

std::optional<Error> PathMotion::start(const planning::PlannedPath& path, double feed,
                                       double time) {
  path_ = path;
  begun_ = made_ = false;
  if (const auto error = follower_.start(path_, limits_, feed, shared_velocity_, time)) {
    return error;
  }
  duration_ = follower_.time_left();
  const std::size_t size = limits_.size();
  q_start_.clear();
  for (std::size_t j = 0; j < size; ++j) q_start_.push_back(follower_.now().q[j]);
  return {};
}

const JointMove* PathMotion::next(Instant /*now*/) {
  if (made_) return &piece_;
  if (follower_.at_rest()) return nullptr;
  const SegmentTime time = segment_time(follower_.time_left(), segment_);
  planning::JointMotion at;
  const bool rests = follower_.look_ahead(time.motion, at);
  piece_ = {.q = {}, .qd = {}, .duration = from_seconds(time.wire)};
  for (std::size_t j = 0; j < limits_.size(); ++j) {
    piece_.q.push_back(at.q[j]);
    piece_.qd.push_back(rests ? 0 : at.qd[j]);
  }
  if (!begun_) piece_.q_start = q_start_;
  ahead_ = time.motion;
  made_ = true;
  return &piece_;
}

void PathMotion::taken() {
  SINEW_ASSERT(made_);
  follower_.step(ahead_);
  begun_ = true;
  made_ = false;
}

void PathMotion::hold() {
  made_ = false;
  follower_.pause();
}

void PathMotion::resume() {
  made_ = false;
  follower_.resume();
}

Expected<void> PathMotion::set_feed(double share) {
  if (!std::isfinite(share) || share < 0 || share > planning::PathFollower::kFeedMax) {
    return std::unexpected(
        Error{ErrorCode::kMoveInput, -1, share, planning::PathFollower::kFeedMax});
  }
  made_ = false;
  if (const auto error = follower_.set_feed(share)) return std::unexpected(*error);
  return {};
}

}  // namespace sinew::control
