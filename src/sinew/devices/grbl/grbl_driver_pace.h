#pragma once

#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/devices/grbl/grbl_wire.h"

namespace sinew {

/// How fast each line of a streamed motion is asked for. A GRBL board changes its speed inside a
/// line, from that of the line before: with mean speeds it comes later and later while a motion
/// speeds up and slows down. So each line may be asked for faster, up to the highest speed of its
/// piece, by as much as the motion is late by the board's own arithmetic: a change of speed by D
/// under the acceleration a costs D^2 / (2 a v) at the higher speed v, and where the path turns
/// back the board stands. @rt
class GrblPace {
 public:
  /// @param acceleration  of each axis, units/s^2
  explicit GrblPace(std::span<const double> acceleration) : acceleration_(acceleration) {}

  /// The next line begins at rest.
  void begin() {
    late_ = before_ = 0;
    way_.clear();
  }
  /// @param way       of each axis, units; not all 0
  /// @param peak      highest speed on the piece, units/s over all axes
  /// @param duration  s that the piece is planned to take
  /// @param rest      it ends at rest
  /// @return          s that its line shall say, `duration` at most
  double line_duration(const grbl::Values& way, double peak, double duration, bool rest);
  /// s by which the motion is behind its plan, so far as has been asked for.
  double late() const { return late_; }

 private:
  FixedVector<double, grbl::kAxesMax> acceleration_;
  double late_ = 0;
  double before_ = 0;  ///< speed of the line before, units/s
  grbl::Values way_;   ///< of the line before
};

}  // namespace sinew
