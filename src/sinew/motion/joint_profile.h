#pragma once

#include <array>
#include <cstddef>

#include "sinew/core/assert.h"
#include "sinew/motion/online_profile.h"

namespace sinew::motion {

/// A piece of constant jerk: rad (or m) and seconds.
struct ProfilePhase {
  double start = 0;     ///< s after the profile's start
  double duration = 0;  ///< s, > 0
  double jerk = 0;
  AxisState state;  ///< at `start`
};

struct VelocityRange {
  double lower = 0;
  double upper = 0;
};

/// What is done from the end of a profile on.
enum class AfterEnd : unsigned char {
  kStay,      ///< at() keeps giving the end
  kContinue,  ///< goes on at the velocity of the end, which has no acceleration
};

/// Motion of one joint as phases of constant jerk. Every instant is computed from the start of its
/// phase, so nothing drifts; from the end on it is the target, exactly. @rt
class JointProfile {
 public:
  /// Back inside the limits takes at most 5, the mean of two profiles of 7 at most 13.
  static constexpr std::size_t kPhasesMax = 18;

  /// At rest at 0, for no time.
  JointProfile() : JointProfile(AxisState{}) {}
  explicit JointProfile(const AxisState& start) { restart(start); }

  /// Forgets everything and begins here.
  void restart(const AxisState& start);
  /// Goes on with this jerk for `duration` s; nothing where that is 0 or less.
  void append(double jerk, double duration);
  /// The same from a state that is known better than by coming there; finish() must follow.
  void append(const AxisState& state, double jerk, double duration) {
    if (!(duration > 0)) return;
    SINEW_ASSERT(size_ < kPhasesMax);
    starts_[size_] = duration_;
    pieces_[size_] = {duration, jerk, state.q, state.qd, state.qdd};
    ++size_;
    duration_ += duration;
  }
  /// Puts the end to where it was meant to be, by rounding's breadth from where it came.
  void finish(const AxisState& end, AfterEnd after = AfterEnd::kStay);

  double duration() const { return duration_; }  ///< s
  std::size_t size() const { return size_; }     ///< number of phases
  ProfilePhase phase(std::size_t i) const;
  const AxisState& end() const { return end_; }
  /// Where the last phase comes to by itself: end() but for rounding.
  AxisState arrival() const;

  /// State at t (s), held at the start before 0.
  AxisState at(double t) const;
  /// Jerk at t (s): of the phase that begins where two meet; 0 outside [0, duration()).
  double jerk_at(double t) const;

  /// Everywhere it comes by on its way, not what follows after the end.
  PositionRange position_range() const;
  VelocityRange velocity_range() const;

 private:
  struct Piece {
    double duration, jerk, q, qd, qdd;
  };
  std::size_t piece_at(double t) const;

  std::size_t size_ = 0;
  double duration_ = 0;
  AxisState end_{};
  AfterEnd after_ = AfterEnd::kStay;
  // Only what is used is ever filled in: a motion is planned in less time than all of it takes.
  std::array<double, kPhasesMax> starts_;  // infinite where there is no phase
  std::array<Piece, kPhasesMax> pieces_;
};

}  // namespace sinew::motion
