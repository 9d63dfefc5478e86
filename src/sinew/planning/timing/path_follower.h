#pragma once

#include <limits>
#include <optional>
#include <span>

#include "sinew/planning/timing/path_timing.h"
#include "sinew/planning/timing/trajectory.h"

namespace sinew::planning {

/// Follows a path in time, and changes its mind on the way: another feed, a pause, a stop. Every
/// change plans anew from the state at hand, so that acceleration never jumps and all limits hold;
/// the way itself never changes. Sans-IO: time comes in as steps.
///
/// pause(), stop() and a feed of 0 plan the braking alone: measured (time of the processor, random
/// instants of ways of 40 to 140 pieces) 0.04 ms at the mean and 1.1 ms at worst. Another feed and
/// resume() plan the rest of the path at once: 0.3 ms at the mean, 5 ms at worst, and it grows with
/// the pieces that are left. That is not cut into cycles: a loop at 1 kHz calls it from its command
/// side, between two steps. Every such law is held against all limits before it is followed.
/// @rt except the constructor and start(), in that nothing is allocated or locked.
class PathFollower {
 public:
  static constexpr double kFeedMax = 2;
  static constexpr double kFeedMin = 1e-3;        ///< below it counts as 0
  static constexpr double kTimeTolerance = 1e-4;  ///< s

  explicit PathFollower(std::size_t cells_max = PathTiming::kCellsMax);

  /// From rest at the beginning of the path, which outlives the motion.
  /// @param limits  one per joint. @param feed  0..kFeedMax; 0 waits for another.
  /// @param shared_velocity  as PathTiming::prepare.
  /// @param time   s that it takes at feed 1, short of it by a thousandth at most; 0: as quick as
  /// it
  ///               can.
  /// @error kMoveInput: a feed that is no number or outside of that; kSegmentTime (limit: what it
  ///        can take, s); as PathTiming::prepare and plan.
  std::optional<Error> start(const PlannedPath& path, std::span<const motion::AxisLimits> limits,
                             double feed = 1,
                             double shared_velocity = std::numeric_limits<double>::infinity(),
                             double time = 0);
  /// What it follows, and what limited that.
  const TimeLaw& law() const { return law_; }
  LimitTimes limit_times() const { return timing_.limit_times(); }

  /// Time goes on by dt (s) >= 0; where the motion is then.
  const JointMotion& step(double dt);
  const JointMotion& now() const { return now_; }
  /// Where step(dt) would lead, without going there; whether it is at rest there for good.
  bool look_ahead(double dt, JointMotion& out) const;
  const PathState& state() const { return state_; }
  PathProgress progress() const;

  /// Rarely no such plan begins at the state at hand: then it brakes, waits() is true, and each
  /// step tries again, at rest at the latest.
  /// @param feed  0..kFeedMax; 0 (or less than kFeedMin) is a pause that ends with the next feed
  /// above that.
  /// @error kMoveInput: no number, or outside of that. The motion then goes on as it was.
  std::optional<Error> set_feed(double feed);
  double feed() const { return feed_; }
  /// To rest on the path, as soon as the limits allow; resume() goes on, from wherever it is.
  void pause();
  void resume();
  /// The same for good: only start() moves again.
  void stop();

  bool waits() const { return waits_; }
  bool paused() const { return paused_; }
  bool stopped() const { return stopped_; }
  bool at_rest() const;
  /// At rest at the end of the path.
  bool finished() const;
  /// Until it is at rest, s.
  double time_left() const;

 private:
  std::optional<Error> try_plan(bool rest);
  std::optional<Error> try_feed(double feed);
  std::optional<Error> begin_next(const std::optional<Error>& error);
  void creep();
  std::optional<Error> find_pace(double time);
  void replan();

  PathTiming timing_;
  TimeLaw law_;
  TimeLaw next_;  ///< so that a plan that fails changes nothing
  const PlannedPath* path_ = nullptr;
  PathState state_;
  JointMotion now_;
  double t_ = 0;
  double feed_ = 1;
  double pace_ = 1;  ///< a feed of 1 is that share of the quickest
  bool paused_ = false;
  bool stopped_ = false;
  bool waits_ = false;
  std::size_t piece_ = 0;
};

}  // namespace sinew::planning
