#pragma once

#include <optional>
#include <vector>

#include "sinew/control/motion_source.h"
#include "sinew/model/robot_model.h"
#include "sinew/planning/timing/path_follower.h"

namespace sinew::control {

/// A path that a streaming device is led along, segment by segment, and that can be changed under
/// way: its feed, a hold, on again. The constructor and start() allocate.
class PathMotion final : public MotionSource {
 public:
  /// @param overlaps  as overlaps() tells them
  explicit PathMotion(const RobotModel& robot, std::vector<LinkPair> overlaps = {});

  /// From rest at the beginning of the path, of which a copy is kept.
  /// @param feed  0..2
  /// @param time  as PathFollower::start. @error as there
  std::optional<Error> start(const planning::PlannedPath& path, double feed = 1, double time = 0);
  /// s, as planned at the feed of start().
  double duration() const { return duration_; }

  const JointVector& q_start() const override { return q_start_; }
  const JointMove* next(Instant now) override;
  void taken() override;
  bool finished() const override { return follower_.finished(); }
  /// A piece that was not taken is made anew.
  void hold() override;
  void resume() override;
  /// 0..2
  Expected<void> set_feed(double share) override;
  std::span<const LinkPair> overlaps() const override { return overlaps_; }
  std::unique_ptr<planning::CellWay> way() const override {
    return std::make_unique<planning::CellWay>(path_.joints);
  }
  double progress() const override { return follower_.progress().path_share; }
  double time_left() const override { return follower_.time_left(); }

 private:
  std::vector<motion::AxisLimits> limits_;
  double shared_velocity_;
  double segment_;  ///< s
  std::vector<LinkPair> overlaps_;
  planning::PlannedPath path_;
  planning::PathFollower follower_;
  JointVector q_start_;
  double duration_ = 0;
  bool begun_ = false;
  bool made_ = false;  ///< piece_, which follows the state of the follower by ahead_ s
  double ahead_ = 0;
  JointMove piece_;
};

/// s in whole nanoseconds, as pieces last, no less but for rounding: at 3 rad/s half a nanosecond
/// is more than the governor lets pass.
double piece_time(double seconds);

/// How long the next segment of a streamed motion shall be that rests after `left` s: equal ones,
/// none longer than `longest`; a rest of less than half of it is taken in half of it, which every
/// wire can say and every limit allows (the governor's four inequalities hold for a motion that
/// comes to rest earlier than its piece ends).
struct SegmentTime {
  double motion = 0;  ///< s of the motion
  double wire = 0;    ///< s of the piece
};
SegmentTime segment_time(double left, double longest);

}  // namespace sinew::control
