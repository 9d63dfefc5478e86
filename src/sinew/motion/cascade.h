#pragma once

namespace sinew::motion {

/// Gains of a position loop around a velocity loop, and why they are what they are.
struct CascadeSettings {
  /// 1/s. The first firmware's Kp. The motor already follows its steps, so the loop only takes out
  /// what load and gear add, in 0.2 s; the rotor's own oscillation (40 to 100 Hz) is far above.
  double position_gain = 5;
  /// Share of a velocity error that is added to the rate: stiffens against a load that changes.
  /// Measured velocity trails by some 20 ms, and more than 0.5 would wake the rotor's oscillation.
  double velocity_gain = 0.2;
  double integral_gain = 1;  ///< 1/s
  double feed_forward = 1;   ///< share of the reference's velocity that needs no error to be made
  /// Of rate_max, what the integral may hold: a load bends the field by a fraction of a turn and
  /// never needs a steady rate, so this much is ample.
  double integral_share = 0.05;
  double rate_max = 0;  ///< rad/s, of the output
  /// At rest, errors below this are left alone: less than a microstep cannot be taken out.
  double dead_band = 0;  ///< rad
};

/// Position P, velocity PI, with feed-forward of the reference's velocity: the rate at which the
/// axis shall be stepped. The integral stands still while the output is at its limit and pushes
/// further. @rt
class Cascade {
 public:
  Cascade() = default;
  explicit Cascade(const CascadeSettings& settings) : settings_(settings) {}

  /// @param q, qd           measured, rad and rad/s
  /// @param q_ref, qd_ref   where it shall be now, and how fast
  /// @param dt              s since the last call, > 0
  /// @return                rad/s, within rate_max
  double rate(double q_ref, double qd_ref, double q, double qd, double dt);
  void reset() { integral_ = 0; }
  double integral() const { return integral_; }

 private:
  CascadeSettings settings_;
  double integral_ = 0;  ///< rad/s
};

}  // namespace sinew::motion
