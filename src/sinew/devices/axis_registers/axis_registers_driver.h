#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/axis_registers/axis_registers_driver_facts.h"
#include "sinew/devices/axis_registers/axis_registers_driver_link.h"
#include "sinew/devices/axis_registers/axis_registers_driver_units.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/axis_registers/axis_registers_wire.h"
#include "sinew/driver/driver.h"
#include "sinew/model/device.h"
#include "sinew/model/robot_model.h"

namespace sinew {

struct AxisRegistersTiming {
  AxisRegisterTiming link;
  Duration watch = std::chrono::milliseconds(200);  ///< between two reads at rest
  Duration retry = std::chrono::seconds(2);  ///< between two tries on an axis that does not answer
  double move_factor = 1.5;                  ///< of the expected duration, and
  Duration move_margin = std::chrono::seconds(2);    ///< this on top, until a move has failed
  Duration stop_margin = std::chrono::seconds(2);    ///< on top of a joint's slowest deceleration
  Duration homing_limit = std::chrono::minutes(10);  ///< one axis; two turns at 3 deg/s are 4
  Duration test_limit = std::chrono::seconds(5);     ///< a full step and back take a second
  /// Opening waits so long for boards to end the motion that a host before left them with.
  Duration finish_limit = std::chrono::minutes(1);
};

/// Host side of the register protocol: one board per axis, one target per move, each board makes
/// its own profile. docs/wires/axis_registers.md has the wire and what it can lose.
///
///   activity  | what happens                            | next
///   ----------+-----------------------------------------+----------------------------------
///   kClosed   | open                                    | kOpening
///   kOpening  | every board was asked, one answered,    | kIdle, kReady; with the fault where
///             | and ended what it was left with         | an emergency stop is latched: kFailed
///   kOpening  | none answered                           | kOpening again, kFailed once
///   kIdle     | move, home, clear_fault                 | kMoving, kHoming, kClearing
///   kMoving   | every board arrived and tells its target| kIdle, kDone
///   kHoming   | each board in turn is homed             | kIdle, kDone
///   kClearing | every board was told                    | kIdle, kDone or kFailed
///   kIdle     | service(kSelfTest)                      | kTesting
///   kTesting  | every board stands behind its test      | kIdle, kDone or kFailed
///   kMoving,  | a board fails, silent or faulted        | kStopping, kFailed, then kIdle with
///   kHoming   |                                         | the fault latched
///   any       | stop                                    | kStopping
///   kStopping | every board says that it stands         | kIdle (or kOpening), kStopped
///   any       | close                                   | kClosed
///
/// The wire has one stop, EMERGENCY_STOP, and that is what stop() sends: to all boards at once,
/// then each is asked, and told again alone where it did not hear. The latch stays until the next
/// move or home, which take it back first. A latch that this driver did not set is a fault of the
/// whole arm until clear_fault(): kStopLatched where the host's record says that a run before set
/// it, else kEmergencyStop.
///
/// A board that fails `tries` transactions in a row, or reports a fault, is out: axis_fault() says
/// why, a silent one is tried again every `retry`. The others go on; move() takes targets that
/// leave a board that is out where positions() shows it.
///
/// A board that is left out by choice (model/left_out.h) is never selected: its joint stays kLost,
/// and what a move says of it counts for nothing.
///
/// positions(): kLost before homing, while a board is silent, and from a board that stalled or had
/// too little supply until it is homed again: its joint may have fallen to its mechanical end.
/// kUncertain while moving, after a move that was stopped or failed, and for a board that was homed
/// by somebody else, always over an interval that holds the truth; kCommanded after a move, at the
/// angle that the board was really told.
///
/// Opened with declared positions, a board that is homed has kept its supply since. What was
/// declared holds where MOVE_ANGLE agrees; an interval of a motion whose host died in it shrinks to
/// MOVE_ANGLE once the board stands. One of a stop does not: the register reads the target. What a
/// person declares there keeps how far the register is off (count_zero), until the next move. A
/// board that is not homed, or counts elsewhere, takes no declaration. A move from an uncertain
/// position is allowed: the board knows where it stands. All members are @rt.
class AxisRegistersDriver : public SpiDriver {
 public:
  /// @param joints  one per board.
  AxisRegistersDriver(const AxisRegistersDevice& device, std::span<const Joint> joints,
                      const AxisRegistersTiming& timing = {});

  void open(Instant now) override;
  void close(Instant now) override;
  DriverState state() const override;
  std::optional<Error> fault() const override { return fault_; }
  std::span<const JointPosition> positions() const override;
  DriverHealth health() const override { return link_.health(); }
  DeviceFacts facts() const override;
  bool wants_move(Instant now) const override;

  /// @error kPortClosed, kBusy, the fault, kJointLimit, kPositionUnknown (a joint is lost),
  ///        kUnsendable (the number of joints), or the fault of a board that is out
  Expected<void> move(const JointMove& move, Instant now) override;
  void stop(Instant now) override;
  /// The boards one after the other; nothing moves where one of them is out.
  /// @error kTaskNotSupported (boards without a status: nothing would say whether it happened),
  ///        kPortClosed, kBusy, the fault, or the one of a board that is out
  Expected<void> home(Instant now, std::uint8_t joints = kAllJoints) override;
  std::optional<std::size_t> homing_joint() const override;
  /// DIAG_CONTROL 1 and EMERGENCY_STOP 0 on every board. kDone follows where one is fit to move.
  /// @error kPortClosed, kBusy
  Expected<void> clear_fault(Instant now) override;
  bool clearing() const override { return activity_ == Activity::kClearing; }
  /// kSelfTest: DIAG_CONTROL 2 on all boards at once; what fails is the fault of the whole arm.
  /// Nothing moves where one of them is out.
  /// @error kNoSuchService (also boards without a status), kPortClosed, kBusy, the fault, or the
  ///        one of a board that is out
  Expected<void> service(DeviceService what, Instant now) override;
  /// At rest only; what the boards report goes before it, and positions() shows what was kept.
  void declare_positions(std::span<const JointPosition> positions) override;
  void remember(const DriverMemory& memory) override { memory_ = memory; }
  bool held_by_stop() const override;
  /// What MOVE_ANGLE read when the port was opened, of a board that stood, homed, in no stop.
  std::optional<JointInterval> counted(std::size_t joint) const override;
  /// While boards that were told to stop have not said that they stand, or go on with what a host
  /// before asked for.
  std::optional<Instant> goes_on_until() const override;

  void poll(Instant now) override;
  std::optional<Instant> next_deadline() const override;
  std::optional<DriverEvent> take_event() override;

  std::optional<spi::Transfer> take_transfer(Instant now) override;
  void exchanged(std::span<const std::uint8_t> miso, Instant now) override;

  /// Why a board is out. @pre joint < joints
  std::optional<Error> axis_fault(std::size_t joint) const { return axes_[joint].fault; }
  /// Some board answers, and DIAG_STATUS is all zero on each that does: no board that fills this
  /// register tells so, and the first firmware always.
  bool statuses_are_blank() const;
  std::uint16_t frame_id() const { return link_.frame_id(); }

 private:
  enum class Activity : std::uint8_t {
    kClosed,
    kOpening,
    kIdle,
    kMoving,
    kHoming,
    kStopping,
    kClearing,
    kTesting,
  };

  /// What an axis has to be asked next. Those before kPoll go first, on all axes.
  enum class Phase : std::uint8_t {
    kClear,       ///< DIAG_CONTROL 1
    kStop,        ///< EMERGENCY_STOP 1, this axis alone
    kCancel,      ///< HOMING 0
    kRelease,     ///< EMERGENCY_STOP 0
    kBefore,      ///< MOVE_ANGLE as it is before homing
    kHome,        ///< HOMING 1
    kWrite,       ///< MOVE_ANGLE
    kTest,        ///< DIAG_CONTROL 2
    kPollHoming,  ///< HOMING, until it is 0
    kPoll,        ///< DIAG_STATUS, until it stands
    kReadBack,    ///< MOVE_ANGLE, which must be the target
    kVerify,      ///< the stop is latched, and it stands
    kFind,        ///< is it there, and how is it
    kDone,
  };

  struct Axis {
    std::optional<Error> fault;  ///< why it is out
    bool answers = false;
    bool blank = false;           ///< its last status was all zero
    bool knows = false;           ///< its last status: homed, and its position is fine
    bool adrift = false;          ///< MOVE_ANGLE reads where it was sent before a stop
    bool latched = false;         ///< by us
    bool latched_before = false;  ///< by us, in an earlier run
    bool stop_due = false;        ///< it never confirmed a stop
    bool homing = false;          ///< told to, and not seen to end
    bool unheld = false;          ///< its current was weak or off since it was homed
    bool moves = false;           ///< has a target of its own in this move
    bool was_known = false;       ///< `knows`, when its test began
    Phase phase = Phase::kDone;
    Instant not_before;
    Instant deadline;
    int stops_left = 0;
    double expected = 0;  ///< s, of its move
    axis_registers::ToldAngle target;
    std::optional<axis_registers::ToldAngle> before;  ///< MOVE_ANGLE, before homing
    std::optional<axis_registers::ToldAngle> found;   ///< MOVE_ANGLE at opening
    std::array<LastHeard<AxisRegisterValue>, AxisRegistersFacts::kRegisters> heard;
  };
  struct Asked {
    std::size_t axis = 0;
    Phase phase = Phase::kDone;
    AxisRegisterRequest request;
  };

  // axis_registers_driver.cc: what is to be done
  std::optional<Error> check_ready() const;
  bool is_out_by_choice(std::size_t i) const;
  Error why_none_is_fit() const;
  Expected<axis_registers::ToldAngle> target_for(std::size_t i, double q) const;
  bool all_done() const;
  void begin(Activity activity);
  void begin_opening(Instant now);
  void begin_stopping(Instant now);
  void begin_homing_of(std::size_t place);
  void finish(Instant now);
  void finish_opening(Instant now);
  void finish_stopping(Instant now);
  void finish_clearing();
  void finish_testing(Instant now);
  void pump(Instant now);
  bool broadcast_stop(Instant now);
  std::optional<std::size_t> next_axis(Instant now);
  std::optional<std::size_t> next_idle_axis(Instant now);
  void fail_motion(Error error, Instant now);
  void tell(DriverEvent::Kind kind, const Error& error = {});

  // axis_registers_driver_steps.cc: what one axis is asked, and what its answers mean
  void ask(std::size_t i, Instant now);
  AxisRegisterRequest request_for(std::size_t i) const;
  void take(const AxisRegisterOutcome& outcome, Instant now);
  void note(const Asked& asked, const axis_registers::Data& value, Instant now);
  void take_value(std::size_t i, Phase phase, const axis_registers::Data& value, Instant now);
  void take_homing(std::size_t i, const axis_registers::Data& value, Instant now);
  void take_poll(std::size_t i, const axis_registers::Data& value, Instant now);
  void take_test(std::size_t i, const axis_registers::Status& status, Instant now);
  void take_read_back(std::size_t i, const axis_registers::Data& value, Instant now);
  void take_stop_check(std::size_t i, const axis_registers::Data& value, Instant now);
  void take_found(std::size_t i, const axis_registers::Data& value, Instant now);
  bool finishes(std::size_t i, const axis_registers::Data& value, Instant now);
  void take_found_angle(std::size_t i, const axis_registers::ToldAngle& read);
  bool take_statement(std::size_t i, JointPosition& declared) const;
  std::optional<axis_registers::Status> take_status(std::size_t i,
                                                    const axis_registers::Data& value);
  void axis_fails(std::size_t i, Error error, Instant now);
  void after_release(std::size_t i);
  void set_everywhere(std::size_t i);
  bool is_everywhere(std::size_t i) const;
  void set_lost(std::size_t i);
  std::optional<Error> latched_stop() const;
  void set_at(std::size_t i, const axis_registers::ToldAngle& where);
  void stretch_to_target(std::size_t i);

  AxisRegistersDevice device_;
  AxisRegistersTiming timing_;
  FixedVector<Joint, kMaxJoints> joints_;
  FixedVector<Axis, kMaxJoints> axes_;
  FixedVector<JointPosition, kMaxJoints> positions_;
  FixedVector<std::uint8_t, kMaxJoints> buses_;  ///< select of the boards on each bus

  AxisRegisterLink link_;
  Activity activity_ = Activity::kClosed;
  std::optional<Asked> asked_;
  std::size_t cursor_ = 0;  ///< round robin
  Instant watch_at_;
  FixedVector<std::uint8_t, kMaxJoints> homing_order_;
  std::size_t homing_place_ = 0;  ///< in the order
  std::uint8_t to_home_ = kAllJoints;
  std::size_t buses_stopped_ = 0;  ///< broadcasts sent
  bool command_ = false;           ///< a move, home or clear_fault whose end is to be told
  bool stop_asked_ = false;
  bool open_again_ = false;  ///< the stop interrupted opening
  bool silence_told_ = false;
  DriverMemory memory_;
  Instant opened_at_;
  std::optional<Instant> goes_on_until_;  ///< boards go on with what a host before asked for
  std::optional<Error> fault_;
  std::optional<Error> stop_error_;
  std::optional<Instant> wake_at_;
  FixedVector<DriverEvent, 32> events_;
};

}  // namespace sinew
