#pragma once

#include <algorithm>
#include <cmath>

namespace sinew {

/// The cubic between two positions with given speeds, over a time: the only one that has all four.
/// Units as they come; a speed is per s.
///
/// Source: C. de Boor, A Practical Guide to Splines, 1978, ch. IV (cubic Hermite interpolation).
/// @rt
class Cubic {
 public:
  struct State {
    double q = 0;
    double qd = 0;
  };

  Cubic() = default;
  /// @pre duration > 0, s
  Cubic(const State& from, const State& to, double duration)
      : from_(from), to_(to), duration_(duration) {
    const double mean = (to.q - from.q) / duration;
    c2_ = (3 * mean - 2 * from.qd - to.qd) / duration;
    c3_ = (from.qd + to.qd - 2 * mean) / (duration * duration);
  }

  const State& end() const { return to_; }
  double duration() const { return duration_; }

  /// @param t  s from its start; its end from there on.
  State at(double t) const {
    if (t >= duration_) return to_;
    return {position(t), from_.qd + t * (2 * c2_ + t * 3 * c3_)};
  }

  /// The largest that its speed comes to, either way.
  double peak_speed() const {
    double peak = std::max(std::abs(from_.qd), std::abs(to_.qd));
    const double t = -c2_ / (3 * c3_);  // where its acceleration is 0
    if (t > 0 && t < duration_) peak = std::max(peak, std::abs(at(t).qd));
    return peak;
  }

  /// Calls `visit(q)` where it turns back on its way: twice at most.
  template <class Visit>
  void for_turns(Visit&& visit) const {
    // Where its speed is 0: 3 c3 t^2 + 2 c2 t + qd = 0, in the form that also takes c3 = 0.
    const double root = std::sqrt(std::max(0.0, c2_ * c2_ - 3 * c3_ * from_.qd));
    for (const double sum : {-c2_ - root, -c2_ + root}) {
      for (const double t : {sum / (3 * c3_), from_.qd / sum}) {
        if (t > 0 && t < duration_) visit(position(t));
      }
    }
  }

 private:
  double position(double t) const { return from_.q + t * (from_.qd + t * (c2_ + t * c3_)); }

  State from_;
  State to_;
  double duration_ = 0;
  double c2_ = 0;
  double c3_ = 0;
};

}  // namespace sinew
