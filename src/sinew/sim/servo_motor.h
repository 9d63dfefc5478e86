#pragma once

namespace sinew::sim {

/// A hobby servo: a small DC motor with its gear, a sensor and a proportional controller.
struct ServoDrive {
  double stall_torque = 1.7;       ///< Nm at the horn, nominal supply
  double no_load_speed = 6.2;      ///< rad/s, nominal supply
  double inertia = 2e-3;           ///< kg m^2 at the horn: armature through the gear, and the link
  double friction = 0.12;          ///< Nm at the horn; holds it without power too
  double deadband = 0.0035;        ///< rad: no current while the error is smaller
  double full_drive_error = 0.05;  ///< rad of error at which it gets full voltage
  double end_lower = -2.2;         ///< rad, mechanical ends of its gear
  double end_upper = 2.2;
};

/// The physics of one servo; angles at the horn, rad, torques Nm.
///
/// Torque is stall (u - w / w0), u the drive in -1..1 times the supply ratio, w0 the no-load speed:
/// the straight line of a DC motor's data sheet. @rt
class ServoMotor {
 public:
  explicit ServoMotor(const ServoDrive& drive, double angle = 0) : drive_(drive), angle_(angle) {}

  /// Supply against its nominal voltage; below half of it the servo's electronics sleep.
  void set_supply_ratio(double ratio) { supply_ratio_ = ratio; }
  /// What its controller lets it do from now on.
  /// @param torque  share of what it can. @param stiffness  against `full_drive_error`
  void set_drive(double torque, double stiffness) {
    torque_ = torque;
    stiffness_ = stiffness;
  }
  /// A thing in the way: it cannot go above (below) this.
  void block_above(double angle) { block_upper_ = angle; }
  void block_below(double angle) { block_lower_ = angle; }
  void unblock();

  /// @param target  where its pulse tells it to be; @param driven  it gets pulses at all
  /// @param load    Nm from outside, positive pushes the angle up
  void advance(double target, bool driven, double load, double dt);

  /// It is there and turns so fast, rad and rad/s.
  void place(double angle, double speed) {
    angle_ = angle;
    speed_ = speed;
  }

  double angle() const { return angle_; }
  double speed() const { return speed_; }
  /// It pushes against an end or a thing in the way.
  bool at_end() const { return at_end_; }
  /// What it draws against what it draws when stalled, 0..1.
  double effort() const { return effort_; }

 private:
  void step(double target, bool driven, double load, double h);

  ServoDrive drive_;
  double supply_ratio_ = 1;
  double torque_ = 1;
  double stiffness_ = 1;
  double block_lower_ = -1e9;
  double block_upper_ = 1e9;
  double angle_;
  double speed_ = 0;
  double effort_ = 0;
  bool at_end_ = false;
};

}  // namespace sinew::sim
