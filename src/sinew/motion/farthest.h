#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>

namespace sinew::motion {

/// Velocity and acceleration, per jerk limit: the jerk is 1, accelerations are seconds and
/// velocities square seconds.
struct UnitState {
  double velocity = 0;
  double acceleration = 0;
};

/// Caps per jerk limit: acceleration within [-fall, rise], velocity below `top`; rise, fall > 0.
struct UnitCaps {
  double rise = 0;
  double fall = 0;
  double top = 0;
};

/// A motion of jerk 1: the acceleration rises to `peak`, holds it, falls (resting at 0 through a
/// cruise where there is one) to `valley`, holds it, and rises to its end. All in s.
struct Swing {
  double peak = 0;
  double peak_hold = 0;
  double valley = 0;
  double valley_hold = 0;
  double cruise = -1;  ///< below 0: none, the fall is one phase
};

/// What binds a motion at some time.
enum class Binding : unsigned char { kJerk, kAcceleration, kVelocity };

/// A span of durations, s. Beyond its ends by this much, the velocity still fits within rounding.
struct TimeSpan {
  double first = 0;
  double last = -1;
  double slack_first = 0;
  double slack_last = 0;
  bool empty() const { return !(first <= last); }
};

/// Between two states with a fixed duration, the motion that comes farthest: as function of the
/// duration T. By Pontryagin's principle it is a Swing, and for each T there is one; so this is
/// the upper edge of the set of all (T, way) that a joint can have. The lower edge is the upper one
/// of the mirrored problem. Because states and limits are convex, everything between is possible.
///
/// All closed forms in T: with v_s and v_e the velocities where the first and the last rise would
/// pass acceleration 0, and t = T shifted by these two pieces, the way is a sum of ramps between
/// v_s, the crest and v_e. Where neither peak nor valley is held, t = 2 D with
/// D^4 + 4 (v_s + v_e) D^2 - 4 way D - (v_e - v_s)^2 = 0.
///
/// The ends are such that they can be reached from rest and be left to rest inside the caps. @rt
class Farthest {
 public:
  Farthest(const UnitState& from, const UnitState& to, const UnitCaps& caps);

  /// Durations in which the velocities can be met: two spans, the first of them often empty, the
  /// second without end.
  /// @param slack  s^2: how far velocities may be off
  std::array<TimeSpan, 2> spans(double slack) const;

  /// Way in T, which exists; per jerk limit, so s^3.
  double way(double T) const;
  /// How quickly that grows with T, s^2.
  double way_growth(double T) const;
  /// The first duration in [from, until] at which the way is `way`, where it is less at `from`.
  /// Where it only comes near, by `tolerance`, and goes away again, that is good enough.
  std::optional<double> first_time(double from, double until, double way, double tolerance) const;
  Swing swing(double T) const;
  Binding binding(double T) const;

 private:
  // Times below are shifted ones, ways those between the shifted ends.
  enum class Kind : unsigned char { kFree, kPeakHeld, kValleyHeld, kBothHeld, kCruise };
  struct Piece {
    Kind kind = Kind::kCruise;
    double end = std::numeric_limits<double>::infinity();
  };
  /// Way, velocity of its growth, and the growth of that.
  struct Growth {
    double way = 0;
    double first = 0;
    double second = 0;
  };
  /// Where the way of a piece stops growing, and where it starts to grow again.
  struct Turns {
    double crest = std::numeric_limits<double>::infinity();
    double trough = std::numeric_limits<double>::infinity();
  };

  void set_pieces();
  const Piece* piece_at(double t) const;
  Growth growth(Kind kind, double t) const;
  Turns turns(Kind kind) const;
  double meet(Kind kind, double low, double high, double way) const;
  void keep_order(Swing& swing) const;
  double valley_at(double t) const;
  double peak_at(double t) const;
  double climb_at(double t) const;

  double rise_ = 0, fall_ = 0, top_ = 0;
  double v_s_ = 0, v_e_ = 0;
  double gain_ = 0;                 // v_e - v_s >= 0: else the problem is turned round in time
  double climb_ = 0, descent_ = 0;  // from v_s up to the top, and down again to v_e
  bool reversed_ = false;
  double time_shift_ = 0;  // shifted time less T
  double way_shift_ = 0;
  double first_ = 0, last_ = 0;  // accelerations at the ends
  double cruise_start_ = 0, cruise_way_ = 0;
  std::array<Piece, 5> pieces_{};
};

}  // namespace sinew::motion
