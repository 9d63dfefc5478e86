#pragma once

#include <span>

#include "sinew/control/journal_record.h"
#include "sinew/driver/driver.h"
#include "sinew/motion/rest_to_rest.h"

namespace sinew::control {

/// Where the joints may be by what was sent: the pieces that the driver has and has not ended, the
/// next one, and the way to rest from its end. What the journal reserves. All members are @rt.
class SentWay {
 public:
  /// More pieces at once than any driver takes; what is beyond them counts as one.
  static constexpr std::size_t kPiecesMax = 16;

  /// @param limits    one a joint: what it brakes with
  /// @param together  StopFacts::together: each joint takes as long to come to rest as the slowest
  explicit SentWay(std::span<const motion::AxisLimits> limits, bool together = false);

  /// It rests there, and nothing is under way.
  void rest(std::span<const double> q);
  void sent(const JointMove& piece, bool braking = false);
  /// The oldest one was carried out.
  void ended();

  /// Of each joint once `next` is sent too.
  /// @param now      as the driver says it; those of lost joints are without meaning
  /// @param braking  it is coming to rest by its limits: then it needs no more than was reserved
  ///                 before, so that a stop never waits for a disk.
  std::span<const JointInterval> with(std::span<const JointPosition> now, const JointMove& next,
                                      bool braking = false);

 private:
  using Intervals = FixedVector<JointInterval, kMaxJoints>;

  Intervals way_of(const JointMove& piece, bool braking) const;
  double braking_time(std::span<const double> qd, bool braking) const;

  FixedVector<motion::AxisLimits, kMaxJoints> limits_;
  bool together_;
  JointVector q_;   ///< where the last one ends
  JointVector qd_;  ///< and how fast
  FixedVector<Intervals, kPiecesMax> pieces_;
  std::size_t merged_ = 0;  ///< pieces beyond those, in the last entry
  Intervals reach_;
};

}  // namespace sinew::control
