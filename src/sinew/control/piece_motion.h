#pragma once

#include <vector>

#include "sinew/control/motion_source.h"
#include "sinew/model/robot_model.h"

namespace sinew::control {

/// A motion whose pieces are made already: whole moves of a device that makes its own profiles, or
/// segments of a way that nobody means to change. A hold ends it between two pieces; where its
/// device streams, only between two that rest.
class PieceMotion final : public MotionSource {
 public:
  /// @param q_start  empty for a first move, which begins nobody knows where
  /// @param pieces   one after the other from there, a number for each joint
  /// @param overlaps as overlaps() tells them
  PieceMotion(const JointVector& q_start, std::vector<JointMove> pieces, const RobotModel& robot,
              std::vector<LinkPair> overlaps = {});

  const JointVector& q_start() const override { return q_start_; }
  const JointMove* next(Instant now) override;
  void taken() override;
  bool finished() const override { return next_ == pieces_.size(); }
  void hold() override { held_ = true; }
  void resume() override { held_ = false; }
  /// Slower only, and only where the device can be asked for it.
  Expected<void> set_feed(double share) override;
  std::span<const LinkPair> overlaps() const override { return overlaps_; }
  std::span<const JointInterval> whole() const override { return {whole_.data(), whole_.size()}; }
  std::unique_ptr<planning::CellWay> way() const override;
  double progress() const override;
  double time_left() const override;

 private:
  bool between_rests() const;

  JointVector q_start_;
  std::vector<JointMove> pieces_;
  std::vector<LinkPair> overlaps_;
  bool streams_;
  bool takes_speed_;
  bool together_;  ///< its joints are told together, and go so
  FixedVector<JointInterval, kMaxJoints> whole_;
  std::size_t next_ = 0;
  bool held_ = false;
  double feed_ = 1;
  bool made_ = false;
  JointMove piece_;  ///< the next one, at the feed at hand
};

}  // namespace sinew::control
