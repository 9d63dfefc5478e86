#pragma once

#include <array>
#include <optional>
#include <span>

#include "sinew/core/units.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_channel.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_facts.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_multipliers.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_positions.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_probe.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/driver/driver.h"
#include "sinew/driver/send_range.h"

namespace sinew {

struct BigRobotArmTiming {
  BigRobotArmChannelTiming wire;
  /// Until the device has answered well: a board that was reset by the port that opened hears
  /// nothing for a second or two, and one in motion until that is over.
  Duration opening_limit = std::chrono::seconds(8);
};

/// The BigRobotArm behind the common interface. A move is a small dialogue, every step of which is
/// checked before the next:
///
///   step         | asks                                    | goes on when
///   -------------+-----------------------------------------+----------------------------------
///   kBefore      | status                                  | it is as we left it: no reset since
///   kSpeeds      | speeds with which all arrive together   | echoed
///   kRamps       | accelerations, the same                 | echoed
///   kGoto        | the target                              | the target is reported back
///   kAfter       | status                                  | it holds our speeds: no reset since
///
/// A status that differs from what is expected is read again until two readings in a row agree, and
/// three where it tells of a place where nobody sent the arm. Speeds are never those of power-up,
/// so that a board that was reset shows it.
///
///   state      | what happens                              | next
///   -----------+-------------------------------------------+------------------------------
///   kClosed    | open                                      | kOpening: probe, quiet, status twice
///   kOpening   | equal statuses                            | kReady, or kFault in sync mode
///   kReady     | move(), tool()                            | kMoving
///   kMoving    | the last step is through                  | kReady, kDone
///   kMoving    | stop()                                    | kStopping
///   kStopping  | the step under way is through             | kReady, kStopped
///   kMoving,   | a doubt: silence, garbage, a wrong value  | kOpening, kFailed
///   kStopping  |                                           |
///   kFault     | clear_fault(): sync mode off              | kOpening
///   any        | close                                     | kClosed, kFailed where moving
///
/// The device has no stop and is deaf in motion: a goto that has begun to leave is finished, and
/// kStopped follows then. It has no switches either: home() is not supported.
///
/// Positions: BigRobotArmPositions. At the beginning, and after everything that may have moved the
/// device's zero, no move is taken until declare_positions() says where the arm stands, by whoever
/// knows and has recorded it.
/// All members are @rt.
class BigRobotArmDriver : public ByteDriver {
 public:
  /// @param joints  five: limits, and the speeds and accelerations that no move exceeds.
  BigRobotArmDriver(const BigRobotArmDevice& device, std::span<const Joint> joints,
                    const BigRobotArmTiming& timing = {});

  void open(Instant now) override;
  void close(Instant now) override;
  DriverState state() const override { return state_; }
  std::optional<Error> fault() const override { return fault_; }
  std::span<const JointPosition> positions() const override { return shown_; }
  /// While its motion cannot be ended, and at the opening behind a process that died in one.
  std::optional<Instant> goes_on_until() const override;
  std::optional<JointInterval> counted(std::size_t joint) const override;
  DriverHealth health() const override;
  DeviceFacts facts() const override;
  bool wants_move(Instant) const override { return state_ == DriverState::kReady; }

  /// @param move  ends at rest. Joints arrive together, in `duration` or what the joints' limits
  ///              need, whichever is longer.
  /// @error kBusy, kPortClosed, the fault's, kPositionUnknown (index), kJointLimit (index, rad),
  ///        kStepRange, kUnsendable (index, steps), kTaskNotSupported (a speed at the end)
  Expected<void> move(const JointMove& move, Instant now) override;
  /// Counted from where the device stands by its own counters.
  Expected<void> nudge(std::size_t joint, double way, Duration duration, Instant now) override;
  void stop(Instant now) override;
  Expected<void> clear_fault(Instant now) override;
  /// GripperTo: its servo jumps to the nearest whole degree. On without an angle: to where it was
  /// last; kNotMeasured where nobody knows that.
  /// @error kToolNotFitted, kGripperRange (degrees, gripper_max), kUnsendable, kBusy, kPortClosed
  Expected<void> tool(const ToolAction& action, Instant now) override;
  /// Where the arm stands; without effect while it moves or is in doubt. `uncertain` keeps its
  /// interval from then on.
  void declare_positions(std::span<const JointPosition> positions) override;
  void remember(const DriverMemory& memory) override { memory_ = memory; }
  /// The document's command 03.
  Expected<void> zero_counters(Instant now) override;

  void poll(Instant now) override;
  std::optional<Instant> next_deadline() const override;
  std::optional<DriverEvent> take_event() override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override;

  /// What the probe found, or what the robot's file says.
  BigRobotArmFound wire() const { return {device_.wire, device_.dialect}; }
  /// True where no move is taken before declare_positions().
  bool wants_declaration() const { return belief_.unknown().has_value(); }

 private:
  using Words = bigrobotarm::Words;
  using Status = bigrobotarm::Status;

  enum class Step : std::uint8_t {
    kNone,
    kProbe,
    kRecover,  ///< the channel finds the device (again)
    kConfirm,  ///< a status that nobody expected, once more
    kBefore,
    kSpeeds,
    kRamps,
    kGoto,
    kAfter,
    kGripper,
    kZero,
    kSyncOff,
  };
  struct Limits {
    SendRange range;
    std::int32_t speed_max = 1;  ///< multiplier
    std::int32_t acceleration_max = 1;
  };
  /// Readings of a status; then the line is no line.
  static constexpr int kReadingsMax = 8;

  void pump(Instant now);
  void take(const BigRobotArmChannel::StatusRead& read, Instant now);
  void take_done(Instant now);
  void confirm(const std::optional<Status>& first, Step resume, Instant now);
  bool as_expected(const Status& status) const;
  bool is_familiar(const Status& status) const;
  bool is_outside(const Words& steps) const;
  Duration left_behind() const;
  bool may_have_wandered(Instant now) const;
  void settle(const Status& status, Instant now);
  void doubt(const Error& error, Instant now);
  Expected<void> ask(Step step, Instant now);
  void go_on(Step step, Instant now);
  void go_on_after(Step done, Instant now);
  Expected<void> check_ready() const;
  Expected<void> check_move(const JointMove& move) const;
  Expected<void> begin_move(Duration at_least, Instant now);
  Expected<BigRobotArmMultipliers> multipliers_for(const Words& deltas, Duration at_least) const;
  Duration duration_of(const Words& deltas) const;
  std::optional<std::int32_t> known_gripper() const;
  void end_command(DriverEvent::Kind kind, const Error& error);
  void tell(DriverEvent::Kind kind, const Error& error = {});
  void show(Instant now);

  BigRobotArmDevice device_;
  BigRobotArmTiming timing_;
  std::array<Limits, bigrobotarm::kJoints> limits_{};
  BigRobotArmChannel channel_;
  BigRobotArmProbe probe_;
  BigRobotArmPositions belief_;
  std::array<JointPosition, bigrobotarm::kJoints> shown_;

  DriverMemory memory_;  ///< until the device has answered
  DriverState state_ = DriverState::kClosed;
  std::optional<Error> fault_;
  Step step_ = Step::kNone;
  bool opening_ = false;  ///< open() has not been answered by an event
  bool command_ = false;  ///< nor has a command
  bool stop_wanted_ = false;
  std::optional<Instant> limit_;       ///< of opening, or of a doubt
  std::optional<Instant> deaf_until_;  ///< a motion that nobody waits for may be under way
  Error trouble_;                      ///< what is told then
  std::optional<Status> last_read_;
  Step resume_ = Step::kNone;  ///< what a confirmed status answers
  int readings_ = 0;           ///< of it so far
  int alike_ = 0;              ///< the last ones, in a row
  bool was_deaf_ = false;      ///< before the first of them

  BigRobotArmMultipliers multipliers_;  ///< the device's, as far as known
  BigRobotArmMultipliers wanted_;
  BigRobotArmAngles q_target_{};
  Words target_{};
  Instant going_since_{};
  Duration expected_{};
  std::optional<std::int32_t> gripper_;  ///< deg, as it was told to be last
  bool gripper_enabled_ = false;

  DriverHealth health_;
  LastHeard<Status> heard_;
  FixedVector<DriverEvent, 16> events_;
};

}  // namespace sinew
