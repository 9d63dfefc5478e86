#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/model/device.h"

namespace sinew {

/// One motion as the real board makes it. A loop polls the five motors and makes at most one step
/// of each in a round, so that the more of them step, the slower it goes round, and speeds above
/// its rate are not reached. A motor's ramp counts steps, not time.
///
/// With x motors stepping in a round it lasts a + b x + c x (5 - x); a motor slower than the loop
/// loses a part of a round at each step, since steps fall on the loop's own instants. The constants
/// are fitted to what was measured on the firmware in a cycle-accurate emulation: 3430..3470 steps
/// a second for one motor, 1300 each for four, 1010 each for five, and the joints of the
/// document's goto arriving after 2.12, 2.60, 3.40, 1.19 and 1.39 s. The fit is within 6 % of each.
///
/// Steps, s. Time runs forward. @rt
class BigRobotArmStepping {
 public:
  struct Joint {
    double distance = 0;      ///< steps, either sign
    double speed = 0;         ///< steps/s; 0: it makes one step and never arrives
    double acceleration = 0;  ///< steps/s^2
    /// Steps/s, signed, that it still believes to have. Unless it can stop by the target it first
    /// runs on to where it can.
    double old_speed = 0;
  };
  using Joints = std::array<Joint, kBigRobotArmJoints>;

  /// At rest.
  BigRobotArmStepping() = default;
  /// Each joint with its own ramps.
  static BigRobotArmStepping ramped(const Joints& joints);
  /// All at constant speeds that let them arrive together: the firmware's sync mode. Measured: 5600
  /// steps a second for one motor, 10 300 for five with rates as 16 : 1 : 8 : 8 : 8.
  static BigRobotArmStepping level(const Joints& joints);

  void advance_to(double t);
  /// Steps from where it began, signed, at the last advance_to().
  double position(std::size_t joint) const;
  /// Steps/s of a level motion, signed.
  double level_speed(std::size_t joint) const;
  /// s from start to arrival of the last joint; nothing where one never arrives.
  std::optional<double> duration() const;

 private:
  struct Leg {
    double run_on = 0;  ///< steps, signed, away to where it can stop
    double way = 0;     ///< steps, signed, from there to the target
    double speed = 0;
    double acceleration = 0;
    double done = 0;         ///< steps of both, unsigned
    double rate = 0;         ///< steps/s now
    bool held_back = false;  ///< by the loop
    bool stuck = false;

    double length() const;
    double left() const { return length() - done; }
    double own_rate() const;
  };

  void set_rates();
  double steady_time() const;
  bool arrived() const;

  std::array<Leg, kBigRobotArmJoints> legs_;
  double time_ = 0;       ///< of `done` and `rate`
  double seen_ = 0;       ///< the last advance_to()
  double last_step_ = 0;  ///< when the last joint so far arrived
  double level_time_ = 0;
};

}  // namespace sinew
