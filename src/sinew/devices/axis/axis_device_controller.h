#pragma once

#include <cstdint>
#include <optional>

#include "sinew/core/instant.h"
#include "sinew/devices/axis/axis_device.h"
#include "sinew/devices/axis/axis_device_encoders.h"
#include "sinew/devices/axis/axis_device_homing.h"
#include "sinew/devices/axis/axis_device_settings.h"
#include "sinew/devices/axis/axis_device_step_check.h"
#include "sinew/motion/cascade.h"
#include "sinew/motion/online_profile.h"
#include "sinew/motion/setpoint_follower.h"

namespace sinew {

/// One axis of robot-arm-2: what runs on its board, 1000 times a second (100 Hz to 5 kHz work).
///
/// A reference (position, velocity, acceleration) is moved by one of the modes below; a position
/// and velocity loop on the motor's encoder turns it into microsteps. Only what was asked moves it:
///
/// | mode | reference | ends |
/// |---|---|---|
/// | kHold | stands | with a request |
/// | kProfile | a jerk-limited profile: move_to(), stop(), leaving a fault | at rest: kHold |
/// | kTracking | follows track() | stream silent: a stop |
/// | kHoming | axis_device_homing.h | homed, cancelled or failed |
/// | kSelfTest | stands; the motor is wiggled by one full step | done or failed |
///
/// Whatever the mode, and before anything else:
///
/// | what | at once | position afterwards |
/// |---|---|---|
/// | emergency_stop() | steps freeze in the same tick; latched | still known |
/// | kStalled, driver_fault, kEndStop | steps freeze | known; not where an end stop closed far off
/// | | kFollowingError, measured outside the limits | brakes from the measured state | known | |
/// kSupplyLow, kTooHot, kLinkSilent | brakes from the reference | known | | kEncodersDisagree,
/// kJointEncoder | brakes | not known: homing again | | kMotorEncoder | brakes, steps alone | not
/// known | | kHomingTimeout, kEndStopStuck, kSelfTest | brakes | not known; kSelfTest: known |
///
/// The first fault stays until clear_faults(), which resumes nothing; if its cause is still there
/// it comes back within its own detection time. driver_fault has no number of its own on the wires:
/// it is kStalled, with motor_ok off and the current off.
///
/// emergency_stop() is a word on a wire, not a safety function: it freezes and holds (category 2
/// of IEC 60204-1), or cuts the current where the settings say so (category 0). Real emergency
/// stops act on the supply.
///
/// Current flows from the first moment that the supply has been good for 20 ms; the rotor then
/// snaps to the next place that its windings know, up to two full steps (0.2 deg of the joint)
/// away. Nothing allocates, no loop is unbounded, time never runs back. @rt
class AxisController : public Axis {
 public:
  explicit AxisController(const AxisSettings& settings);

  /// One control cycle. Cycles that come late are made up for in steps of at most kTickMax, so
  /// that a pause of the processor is a pause of the motion and not a jump.
  AxisOutputs tick(const AxisInputs& inputs, Instant now);
  static constexpr double kTickMax = 0.02;  ///< s

  AxisStatus status() const override;
  AxisVerdict home() override;
  void cancel_homing() override;
  AxisVerdict move_to(double q) override;
  AxisVerdict track(double q, double qd) override;
  void stop(AxisFault why = AxisFault::kNone) override;
  void emergency_stop() override;
  void release_emergency_stop() override;
  void clear_faults() override;
  /// Supply, temperature, encoders and power stage as they are now; at rest and homed also one
  /// full step to and fro, which the motor's encoder must see. A failure is kSelfTest.
  void self_test() override;

  /// Where the joint is told to be: what keeps the limits.
  const motion::AxisState& reference() const { return reference_; }
  const AxisSettings& settings() const { return settings_; }

 private:
  enum class Mode : std::uint8_t { kHold, kProfile, kTracking, kHoming, kSelfTest };

  void power(double dt);
  void supervise(double dt);
  void supervise_motion(double dt);
  void supervise_end_stop();
  void fail(AxisFault why);
  void freeze();
  void forget_slip();

  std::optional<AxisVerdict> refusal() const;
  bool ready() const { return outputs_.enabled && settle_left_ <= 0; }
  bool frozen() const { return emergency_ || fault_frozen_; }
  bool busy() const { return mode_ == Mode::kHoming || mode_ == Mode::kSelfTest; }
  void begin_hold();
  void begin_profile(const motion::OnlineProfile& profile);
  std::optional<double> allowed(double q) const;
  motion::OnlineProfile way_to(double q, double speed) const;
  motion::OnlineProfile way_to_rest() const;
  bool swings_back() const;
  bool keeps_limits(const motion::OnlineProfile& profile) const;
  void move_reference(double dt);
  void run_homing(double dt);
  void make_steps(double dt);
  double field_angle() const;

  AxisSettings settings_;
  double steps_per_rad_;
  AxisEncoders encoders_;
  Debouncer end_stop_;
  Homing homing_;
  StepCheck step_check_;
  motion::Cascade cascade_;
  motion::SetpointFollower follower_;
  motion::OnlineProfile profile_;
  double profile_time_ = 0;
  bool streamed_ = false;  ///< since it last stood: the tracking jerk may have been used

  std::optional<Instant> last_tick_;
  AxisInputs inputs_;
  Mode mode_ = Mode::kHold;
  motion::AxisState reference_;
  double target_ = 0;
  double steps_ = 0;  ///< microsteps, exact
  AxisOutputs outputs_;

  AxisFault fault_ = AxisFault::kNone;
  bool emergency_ = false;
  bool cut_ = false;  ///< steps were cut off since the last tick
  bool homed_ = false;
  bool was_closed_ = false;
  bool fault_frozen_ = false;  ///< the fault stopped the steps themselves
  double settle_left_ = 0;     ///< s until the rotor is at rest after the current came on
  double supply_good_for_ = 0, supply_low_for_ = 0;  ///< s
  double following_for_ = 0, stalled_for_ = 0;
  double slip_ = 0;  ///< rad of the motor: what field and rotor were apart when last in step
};

}  // namespace sinew
