#pragma once

#include <vector>

#include "sinew/program/plans/row_planner.h"

namespace sinew::program {

/// What a device that takes whole moves makes of a motion: its joints go from stop to stop, with
/// the profiles and at the times that the plan expects of it.
class WholeMoves {
 public:
  /// @param q_start  where the first piece begins
  /// @param speed    share of the limits that was asked for, where the device can be asked
  /// @param robot    takes whole moves
  WholeMoves(const JointVector& q_start, const RowMotion& motion, double speed,
             const RobotModel& robot);

  /// s, from the first piece's order until the driver has told that the last one is done.
  double duration() const { return duration_; }
  /// At t (s) since the first order, held at both ends.
  void sample(double t, planning::JointMotion& out) const;

 private:
  /// Joints that go together.
  struct Lane {
    std::size_t first = 0;  ///< joint
    motion::RestToRest profile;
    double begin = 0;    ///< s
    double stretch = 1;  ///< how many times as long as its limits allow
  };
  struct Piece {
    double begin = 0;  ///< s, its order
    JointVector q;     ///< where it ends
    std::vector<Lane> lanes;
  };

  void add_together(Piece& piece, const JointVector& from, double seconds, double speed,
                    const RobotModel& robot) const;
  static double add_separate(Piece& piece, const JointVector& from, SeparateMoves& times,
                             const RobotModel& robot);

  MotionDelay delay_;
  JointVector q_start_;
  std::vector<Piece> pieces_;
  double duration_ = 0;
};

}  // namespace sinew::program
