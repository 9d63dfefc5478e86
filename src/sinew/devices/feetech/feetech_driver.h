#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/devices/feetech/feetech_driver_bus.h"
#include "sinew/devices/feetech/feetech_driver_facts.h"
#include "sinew/devices/feetech/feetech_driver_servos.h"
#include "sinew/driver/driver_commands.h"
#include "sinew/driver/motion_segments.h"

namespace sinew {

struct FeetechTiming {
  FeetechBusTiming bus;
  int tries = 3;  ///< a servo that does not reply so often is silent
  /// Between goals while something moves; longer where the wire takes longer.
  Duration tick = std::chrono::milliseconds(10);
  Duration resting_poll = std::chrono::milliseconds(50);
  Duration free_poll = std::chrono::milliseconds(20);
  Duration silent_retry = std::chrono::milliseconds(500);
  /// From a first motion's order until it begins, while motors are switched on; longer where the
  /// wire takes longer.
  Duration lead = std::chrono::milliseconds(150);
  /// A joint that has not moved for so long has settled, and in any case after the limit.
  Duration settle = std::chrono::milliseconds(60);
  Duration settle_limit = std::chrono::milliseconds(800);
  /// Jaws that are not where they were sent so long behind their time stay where they are.
  Duration jaws_limit = std::chrono::milliseconds(1500);
};

/// Host side of Feetech's servo bus: where each joint shall be 10 ms from now is sent to all servos
/// in one packet, with the speed that takes it there; all are asked for their state in between.
/// docs/wires/feetech.md.
///
///   activity   | what happens                              | next
///   -----------+-------------------------------------------+----------------------------------
///   kClosed    | open                                      | kOpening
///   kOpening   | all servos have replied, and fit the file | kIdle, kReady
///   kOpening   | a servo does not fit, or is silent        | kIdle with the fault, kFailed
///   kOpening   | none replies                              | kOpening, kFailed; asked again
///   kIdle      | move                                      | kMoving
///   kMoving    | a segment is over, another one waits      | kMoving, kDone
///   kMoving    | the last one is over, the joints stand    | kIdle, kDone
///   kMoving    | it stands beside its target               | kIdle, kFailed (kMissedTarget)
///   kMoving    | no further segment came                   | kStopping, kFailed (kStreamEnded)
///   kMoving    | a joint falls too far behind, trouble     | kStopping with the fault, kFailed
///   kIdle      | tool(JawsTo)                              | kJaws
///   kJaws      | they are there, or something is between   | kIdle, kDone
///   kIdle      | service(kFree, kHold)                     | kSwitching
///   kSwitching | the servos report their motors so         | kIdle, kDone
///   any open   | stop                                      | kStopping
///   kStopping  | braked, and the joints stand              | kIdle, kStopped
///   any open   | a servo falls silent                      | .. with the fault, kFailed
///   any open   | all of them do                            | kOpening, kFailed; positions lost
///
/// Motors stay as they are when the port opens: the first motion switches them on, each with its
/// goal where the servo is, so nothing jumps. positions(): kMeasured, -+ a step at rest, and in
/// motion the way that a joint can have gone since it was asked. All @rt.
class FeetechDriver : public ByteDriver {
 public:
  /// @param joints  one per servo of the device, asserted
  FeetechDriver(const FeetechDevice& device, std::span<const Joint> joints,
                const std::optional<JawGripper>& gripper, const FeetechTiming& timing = {});

  void open(Instant now) override;
  void close(Instant now) override;
  DriverState state() const override;
  std::optional<Error> fault() const override { return fault_; }
  std::span<const JointPosition> positions() const override { return positions_; }
  std::optional<Instant> goes_on_until() const override;
  DriverHealth health() const override { return health_; }
  DeviceFacts facts() const override;
  bool free() const override;
  bool wants_move(Instant now) const override;
  /// @error the contract's, kUnsendable (number of joints, a speed that is no number), kJointLimit,
  ///        kSegmentTime
  Expected<void> move(const JointMove& move, Instant now) override;
  void stop(Instant now) override;
  /// JawsTo only. @error kToolNotFitted, kJawWidth, kBusy, kPortClosed, the fault
  Expected<void> tool(const ToolAction& action, Instant now) override;
  /// kFree and kHold. @error kNoSuchService, kBusy, kPortClosed, the fault
  Expected<void> service(DeviceService what, Instant now) override;
  Expected<void> clear_fault(Instant now) override;
  bool clearing() const override { return clearing_; }
  void poll(Instant now) override;
  std::optional<Instant> next_deadline() const override;
  std::optional<DriverEvent> take_event() override { return commands_.take(); }
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override { return bus_.take_output(out); }

 private:
  enum class Activity : std::uint8_t {
    kClosed,
    kOpening,
    kIdle,
    kMoving,
    kJaws,
    kSwitching,
    kStopping,
  };
  /// Units that jaws are sent on behind what they hold: a part of their force, for as long as it
  /// takes.
  static constexpr double kSqueeze = 40;
  /// rad by which a goal may be moved for a joint's load.
  static constexpr double kCorrectMost = 0.12;

  /// Motors being switched, as often as it takes.
  struct Switch {
    std::uint8_t servos = 0;  ///< a bit each
    bool on = true;
    bool anew = false;  ///< off first: a servo that protects itself
    bool said = false;
    int tries = 0;
  };
  /// Of the jaws: from where to where, units.
  struct Jaws {
    double from = 0;
    double to = 0;
    Instant start{};
    Instant end{};
    bool held = false;  ///< something is between them
    bool said = false;  ///< .. and its servo was told to hold it
  };

  // feetech_driver.cc
  Expected<void> may_begin() const;
  Expected<void> check_start(const JointMove& move) const;
  double base_of(std::size_t i) const;
  void begin_anew(const Error& why, Instant now);
  void begin_stop(Instant now);
  void fall_silent(Instant now);
  void fail(const Error& error, Instant now);
  void update_positions(Instant now);

  // feetech_driver_motion.cc
  bool ticks() const;
  Duration tick() const;
  segments::Setpoint setpoint(std::size_t joint, Instant when) const;
  void say_goals(Instant now);
  void add_goal(feetech::SyncWrite& write, std::size_t i, double units, double speed);
  void say_switch(Instant now);
  std::optional<std::size_t> not_switched() const;
  void step_switch(Instant now);
  void step_switching(Instant now);
  void wait_for_host(Instant now);
  void step_motion(Instant now);
  void step_moving(Instant now);
  void step_settling(Instant now);
  void step_jaws(Instant now);
  void step_braking(Instant now);
  bool settled(Instant now) const;
  bool correct(Instant now);
  double behind_rest(std::size_t joint) const;
  bool relieve(double from, Instant now);
  std::uint8_t joints_mask() const;

  // feetech_driver_readings.cc
  void ask_what_is_due(Instant now);
  void begin_round(Instant now);
  void ask_next(Instant now);
  void take(const feetech::Reply& reply, Instant now);
  void take_miss(const feetech::Ids& missing, Instant now);
  void round_over(Instant now);
  void ask_opening(Instant now);
  void step_opening(Instant now);
  std::optional<Error> unfit() const;
  void become_ready(Instant now);
  void watch(Instant now);
  bool follows(std::size_t joint) const;

  FeetechServos servos_;
  FeetechTiming timing_;
  FeetechBus bus_;

  Activity activity_ = Activity::kClosed;
  std::optional<Error> fault_;
  DriverCommands commands_;
  DriverHealth health_;
  FixedVector<JointPosition, kMaxJoints> positions_;
  Instant now_{};
  bool clearing_ = false;
  bool told_silent_ = false;
  std::optional<Instant> goes_on_until_;

  // Questions
  std::size_t opening_ = 0;  ///< how many of an opening's have been answered, or given up
  FixedVector<std::size_t, kMaxJoints> round_;  ///< servos that are still to be asked one by one
  bool round_open_ = false;
  bool one_by_one_ = false;  ///< they do not answer a question to all of them
  int broken_rounds_ = 0;
  bool cycled_ = false;  ///< while a fault is cleared: motors were switched off and on
  Instant poll_due_{};
  Instant tick_due_{};
  Instant opened_at_{};

  // Motion
  segments::SegmentQueue queue_;
  std::array<segments::Setpoint, kMaxJoints> target_{};  ///< behind the queue; of a stop its start
  std::array<double, kMaxJoints> goal_{};                ///< told last, units
  /// Units by which goals are beside setpoints: what a joint's load takes back, as seen at rest.
  std::array<double, kMaxJoints> beside_{};
  std::array<double, kMaxJoints> jump_{};           ///< .. and more as a motion begins, which fades
  int corrections_ = 0;                             ///< of beside_, in this motion
  std::array<double, kMaxJoints> before_{};         ///< beside_ before the last one
  std::array<double, kMaxJoints> off_{};            ///< .. and what was missing then, units
  std::array<double, kMaxJoints> rested_{};         ///< units where it was seen to move last
  std::array<Instant, kMaxJoints> moved_at_{};      ///< .. and when
  std::array<int, kMaxJoints> behind_{};            ///< replies in a row from too far behind
  std::array<std::uint16_t, kMaxJoints> limits_{};  ///< of torque, as it was switched on with
  std::array<int, kMaxJoints> restarts_{};          ///< replies in a row that have another one
  std::uint8_t told_ = 0;                           ///< servos whose goal_ they were told
  std::uint8_t on_ = 0;      ///< servos whose motors are on, as far as is known
  std::uint8_t set_up_ = 0;  ///< servos that this has switched on, with their torque's limit
  Instant began_{};
  Instant told_for_{};      ///< the time that the last goals are of
  std::uint8_t stuck_ = 0;  ///< joints that corrections do not help
  Duration lag_{};          ///< by which a motion is later than planned: its host came too late
  std::optional<Error> missed_;  ///< what the motion will have failed with
  bool relieved_ = false;        ///< of a stop: no joint pushes
  Instant over_at_{};            ///< the queue is, or the braking
  bool brakes_ = false;          ///< joints were moving when the stop began
  Instant brake_at_{};
  Instant last_piece_{};
  bool rests_ = true;  ///< the last segment ends at rest
  std::optional<Switch> switch_;
  std::optional<Jaws> jaws_;
};

}  // namespace sinew
