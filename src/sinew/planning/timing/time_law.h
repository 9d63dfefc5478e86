#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace sinew::planning {

/// Where on a path a motion is: s and its derivatives with respect to time, 1/s powers.
struct PathState {
  double s = 0;
  double v = 0;
  double a = 0;
};

/// From `state` on, `jerk` holds until the next phase begins.
struct LawPhase {
  double t = 0;  ///< s from the beginning of the law
  PathState state;
  double jerk = 0;
};

/// s as a function of time: phases of constant jerk. Appending does not allocate up to the capacity
/// that it was made with; sampling is @rt.
class TimeLaw {
 public:
  explicit TimeLaw(std::size_t capacity);

  /// Empty, standing (or moving) at `start`.
  void clear(const PathState& start = {});
  std::size_t size() const { return phases_.size(); }
  bool has_room(std::size_t phases) const { return size() + phases <= phases_.capacity(); }
  std::span<const LawPhase> phases() const { return phases_; }
  double duration() const { return duration_; }
  /// Where it ends. What was appended last is integrated from its own beginning, so nothing drifts.
  const PathState& end() const { return end_; }

  /// Goes on with `jerk` for `duration` s; nothing where that is not above 0. Neighbours of equal
  /// jerk are one phase.
  void append(double jerk, double duration);
  /// The same, and puts the end to `end`, by rounding's breadth from where it came.
  void append(double jerk, double duration, const PathState& end);

  /// At rest at `s`: a last phase that takes braking back lasts until there is none left, by
  /// rounding's breadth longer or shorter.
  void end_at_rest(double s);

  /// At t (s), held at both ends: its first state before, its end behind.
  PathState sample(double t) const;
  /// Of the phase that begins where two meet; 0 outside.
  double jerk(double t) const;

 private:
  std::size_t phase_at(double t) const;

  double duration_ = 0;
  PathState end_;
  std::vector<LawPhase> phases_;
};

/// `state` after `t` s of `jerk`. @rt
PathState advanced(const PathState& state, double jerk, double t);

}  // namespace sinew::planning
