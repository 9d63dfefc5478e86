#pragma once

#include <cstdint>

#include "sinew/devices/axis/axis_device.h"
#include "sinew/devices/axis/axis_device_settings.h"

namespace sinew {

/// A switch that must hold its level for a while before it is believed.
class Debouncer {
 public:
  Debouncer() = default;
  explicit Debouncer(double time) : time_(time) {}
  void read(bool closed, double dt);
  bool closed() const { return closed_; }
  bool closing() const { return level_ > 0; }  ///< perhaps closed

 private:
  double time_ = 0;
  double level_ = 0;  ///< s, 0..time_
  bool closed_ = false;
};

/// The search for the end stop, as a sequence of wishes to a controller that moves the joint.
///
/// | phase | does | next |
/// |---|---|---|
/// | kLeaveSwitch | the switch is closed already: backs off | open: kEdge |
/// | kApproach | towards the stop, at approach_speed | closed: kContact |
/// | kContact | comes to rest inside the limits | at rest: kBackOff |
/// | kBackOff | away from the stop, by back_off from the contact | open: kEdge |
/// | kEdge | towards the stop, at slow_speed; marks where the switch closes | closed: kZero |
/// | kZero | names the mark end_stop_angle, comes to rest | at rest: kClear |
/// | kClear | to clear_angle | at rest and open: done |
///
/// No phase is without an end: each has a farthest way and a longest time. A switch that does not
/// open is kEndStopStuck, one that does not close kHomingTimeout. @rt
class Homing {
 public:
  enum class Phase : std::uint8_t {
    kIdle,
    kLeaveSwitch,
    kApproach,
    kContact,
    kBackOff,
    kEdge,
    kZero,
    kClear,
  };

  struct Wish {
    enum class Kind : std::uint8_t {
      kNone,
      kMoveTo,    ///< to `q`, at most at `speed`
      kStop,      ///< inside the limits
      kMark,      ///< here the switch closes, perhaps
      kNameMark,  ///< that place is `q`, and the joint shall come to rest
      kDone,
      kFail,
    } kind = Kind::kNone;
    double q = 0;
    double speed = 0;
    AxisFault fault = AxisFault::kNone;
  };

  /// @param limits  of the axis, for the longest time that a way may take
  Homing(const HomingSettings& settings, const motion::AxisLimits& limits)
      : settings_(settings), limits_(limits) {}

  void start() { phase_ = Phase::kIdle, started_ = true; }
  void cancel() { started_ = false; }
  bool running() const { return started_; }
  Phase phase() const { return phase_; }

  /// @param q        where the joint shall be now, in the frame of the moment
  /// @param at_rest  nothing of the last wish is left to do
  Wish tick(const Debouncer& end_stop, double q, bool at_rest, double dt);

 private:
  Wish enter(Phase phase, double q, bool closed);
  Wish move(double q_from, double q_to, double speed);
  Wish fail(AxisFault fault);

  HomingSettings settings_;
  motion::AxisLimits limits_;
  bool started_ = false;
  Phase phase_ = Phase::kIdle;
  bool maybe_closing_ = false;
  double contact_ = 0;    ///< rad, where it came to rest on the switch
  double time_left_ = 0;  ///< s, of the phase
};

}  // namespace sinew
