#pragma once

#include <optional>
#include <span>

#include "sinew/control/command.h"
#include "sinew/control/cycle_watch.h"
#include "sinew/control/governor.h"
#include "sinew/control/jog_motion.h"
#include "sinew/control/position_journal.h"
#include "sinew/control/sent_way.h"

namespace sinew::control {

struct ControllerSettings {
  /// The longest time between two steps that counts as in time; two later ones in a row: a hold.
  Duration cycle = std::chrono::milliseconds(20);
  /// Nobody was there for so long: a fault.
  Duration gap = std::chrono::milliseconds(500);
  Duration lease_life = Lease::kLife;
  /// From enabling to the device's first good answer.
  Duration opening_limit = std::chrono::seconds(5);
  /// A stop that nobody carries out in this time is a fault of the device.
  Duration stop_limit = std::chrono::seconds(5);
  /// A driver that is ready takes the first piece of a motion within this time, or says why not.
  Duration start_limit = std::chrono::seconds(2);
  /// Without one nothing is recorded: simulated machines that begin anew each time.
  std::optional<JournalSettings> journal = std::nullopt;
};

/// What was known when the run began.
struct ControllerStart {
  /// From the journal of the run before, one a joint; empty: nothing.
  JournalPositions positions;
  JournalEnd journal_end;
  DriverMemory memory;  ///< what else that run left
};

struct Inputs {
  /// At most Controller::kCommandsMax; the rest next time.
  std::span<const Command> commands = {};
  /// The port to the device is open.
  bool port_open = true;
  /// What the journal's writer says; without meaning where nothing is recorded.
  std::uint64_t durable_sequence = 0;
  bool journal_failed = false;
  /// The program is about to end: once at rest, its last record is made.
  bool closing = false;
  std::int64_t wall_ns = 0;  ///< since 1970, for records
};

struct Outputs {
  static constexpr std::size_t kEventsMax = 96;
  static constexpr std::size_t kRecordsMax = PositionJournal::kUnsyncedMax;

  FixedVector<ControlEvent, kEventsMax> events;
  /// To be written in this order, at once.
  FixedVector<JournalRecord, kRecordsMax> records;
};

/// The one place that grants motion to one robot: its state, who may move it, what is recorded
/// before it moves, and how it is brought to rest. Deterministic, no clock, no port: step() is
/// called each cycle, behind the driver's receive() and poll(), and calls the driver's commands.
/// What leaves the driver afterwards is in order.
///
///   command -> lease, state -> motion -> governor -> journal -> driver
///
/// docs/control.md has the states, the stops and the watchdogs. All members but the constructor
/// are @rt.
class Controller {
 public:
  static constexpr std::size_t kCommandsMax = 8;
  static constexpr std::size_t kLaterCausesMax = 8;
  /// rad, of a joint that is measured: a setpoint that is kept is no farther away than this.
  static constexpr double kSag = 0.05;
  /// Share of a joint's speed with which it is moved while nobody knows where it is.
  static constexpr double kNudgeShare = 0.1;
  /// .. and of one that ends where a probe touches.
  static constexpr double kProbeShare = 0.02;

  /// @param robot, driver  outlive this. The driver is closed.
  Controller(const RobotModel& robot, Driver& driver, const ControllerSettings& settings,
             const ControllerStart& start);
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  const Outputs& step(const Inputs& inputs, Instant now);

  MachineState state() const { return state_; }
  const Driver& driver() const { return driver_; }
  const RobotModel& robot() const { return robot_; }
  /// One a joint: the driver's, and while it has none those that the run began with.
  std::span<const JointPosition> positions() const;
  /// Where the next motion begins: every joint's commanded place; nothing where one is not known.
  std::optional<JointVector> reference() const;
  /// What the gripper is like: as it was told last, and where the device measures as it was then.
  const ToolState& tool() const { return tool_; }
  /// Where the last piece that the driver took ends: what the machine was told, for records.
  /// Nothing where it was told nothing, or a joint is not known.
  std::optional<JointVector> commanded() const;
  std::optional<LeaseToken> lease_holder(Instant now) const { return lease_.holder(now); }
  const std::optional<Latched>& latched() const { return latched_; }
  std::span<const Latched> later_causes() const { return {later_.data(), later_.size()}; }
  /// Why it is stopping, held, or was stopped last.
  std::optional<StopCause> last_stop() const { return last_stop_; }
  double feed() const { return feed_; }
  /// A client has freed the arm to guide it by hand: nothing moves before it is held again.
  bool free_drive() const { return free_drive_; }
  /// Of the command under way; 0 where none is.
  std::uint32_t task() const { return task_ ? task_->command : 0; }
  double progress() const;
  /// What a jog keeps out of, from now on: what is beside the robot in its cell.
  void surround_jog(std::span<const planning::Surrounding> bodies) { jog_.surround(bodies); }
  /// A jog is under way.
  bool jogs() const { return task_ && task_->kind == TaskKind::kJog; }
  /// Where it was sent last, and how fast.
  const motion::AxisStates& jog_setpoint() const { return jog_.setpoint(); }
  planning::JogStatus jog_status() const { return jog_.status(); }
  /// All records are safe; the last one has been made.
  bool journal_settled() const { return !journal_ || journal_->settled(); }
  bool journal_closed() const { return !journal_ || closed_; }

 private:
  enum class TaskKind : std::uint8_t { kMotion, kBlindMotion, kJog, kHome, kNudge, kTool };
  struct Task {
    std::uint32_t command = 0;
    TaskKind kind = TaskKind::kMotion;
    MotionSource* motion = nullptr;
    Instant since{};
    bool begun = false;            ///< something was handed to the driver
    Nudge nudge{};                 ///< of kNudge
    Home home{};                   ///< of kHome
    std::optional<JawsTo> jaws{};  ///< of kTool
    bool holds = false;            ///< of kTool: motors are switched on where the arm is
  };
  /// A stop under way.
  struct Stopping {
    StopCause cause = StopCause::kClient;
    StopAfter after = StopAfter::kReady;
    bool by_device = false;  ///< Driver::stop() was called
    bool told = false;       ///< the driver has said kStopped, or has nothing under way
    Instant since{};
  };

  // controller.cc
  void change(Signal signal);
  void tell(ControlEvent::Kind kind, std::uint32_t command = 0, const Error& error = {},
            StopCause cause = StopCause::kClient, const LeaseToken& lease = {});
  void latch(StopCause cause, const Error& error);
  void stop(StopCause cause, const std::optional<Error>& error, Instant now);
  void stop_device(Instant now);
  void end_task(ControlEvent::Kind kind, const std::optional<Error>& error = {},
                StopCause cause = StopCause::kClient);
  void settle(Instant now);
  void rested();
  bool standing(Instant now) const;
  bool driver_knows() const;
  bool measures() const { return robot_.device.capability.feedback == PositionFeedback::kMeasured; }
  /// The next motion begins at the end of the last piece, or where the driver says.
  void stand_at_setpoint();
  /// A servo under load, or one that was turned a little by hand, still is at its setpoint where
  /// it is kept; how much is too much its driver says when the next motion begins (kMovedUnasked).
  enum class Setpoint : std::uint8_t { kKept, kForgotten };
  void stand_where_driver_says(Setpoint setpoint);
  void stand_at_reference();
  void fit(const ToolState& tool);
  /// On a motion that was granted, and not being brought to rest.
  bool granted() const {
    return state_ == MachineState::kMoving || state_ == MachineState::kRecovering;
  }

  // controller_watch.cc
  Error silence() const;
  void watch_time(Instant now);
  void watch_lease(Instant now);
  void watch_journal(const Inputs& inputs, Instant now);
  void watch_port(const Inputs& inputs, Instant now);
  void watch_driver(Instant now);
  void take_events(Instant now);
  void take(const DriverEvent& event, Instant now);
  void failed(const Error& error, Instant now);
  void enabled();
  void end_enabling(ControlEvent::Kind kind, const Error& error = {});
  void watch_acknowledging(Instant now);

  // controller_commands.cc
  struct Asked {
    const Command& command;
    const Inputs& inputs;
    Instant now;
  };
  void handle(const Command& command, const Inputs& inputs, Instant now);
  /// True: done at once; false: it goes on, and its end is told.
  Expected<bool> on(const TakeLease& take, const Asked& asked);
  Expected<bool> on(const RenewLease& renew, const Asked& asked);
  Expected<bool> on(const ReturnLease& give, const Asked& asked);
  Expected<bool> on(const Enable& enable, const Asked& asked);
  Expected<bool> on(const Disable& disable, const Asked& asked);
  Expected<bool> on(const Acknowledge& acknowledge, const Asked& asked);
  Expected<bool> on(const Begin& motion, const Asked& asked);
  Expected<bool> on(const Home& home, const Asked& asked);
  Expected<bool> on(const Nudge& nudge, const Asked& asked);
  Expected<bool> on(const JogAt& velocity, const Asked& asked);
  Expected<bool> on(const Hold& hold, const Asked& asked);
  Expected<bool> on(const Resume& resume, const Asked& asked);
  Expected<bool> on(const Stop& stop, const Asked& asked);
  Expected<bool> on(const SetFeed& feed, const Asked& asked);
  Expected<bool> on(const UseTool& tool, const Asked& asked);
  Expected<bool> on(const Declare& where, const Asked& asked);
  Expected<bool> on(const Service& service, const Asked& asked);
  void take_lease(const LeaseToken& token, bool take_over, Instant now);
  void enable(std::uint32_t command, Instant now);
  Expected<void> at_rest(Instant now) const;
  Expected<void> may_begin(Instant now) const;
  Error unknown_position() const;
  Expected<void> begin(const Command& command, const Begin& begin, Instant now);
  /// True where a jog that is under way goes on with it.
  Expected<bool> jog(const Command& command, const JogAt& velocity, Instant now);
  Expected<void> home(const Command& command, const Home& home, Instant now);
  Expected<void> nudge(const Command& command, const Nudge& nudge, Instant now);
  Expected<void> use_tool(const Command& command, const UseTool& tool, Instant now);
  Expected<void> set_feed(double share);
  Expected<void> declare(const Declare& where, const Asked& asked);
  std::optional<Error> contradiction(const Declare& where) const;
  std::optional<Error> dropped(const Declare& where) const;
  Expected<bool> acknowledge(const Command& command, const Inputs& inputs, Instant now);
  std::optional<Error> clear_device(Instant now);
  bool device_being_told() const;
  void acknowledged(Instant now);

  // controller_motion.cc
  void advance(Instant now);
  void begin_homing(Instant now);
  void follow_homing();
  std::uint8_t still_found() const;
  void begin_nudge(Instant now);
  void arrive();
  bool hand_over(const JointMove& piece, Instant now);
  bool recorded(const JointMove& piece, Instant now);
  void piece_refused(const Error& error, Instant now);
  void record_rest(Instant now);
  void record_end(Instant now);
  void offer(const std::optional<JournalRecord>& record);
  JournalTime time(Instant now) const { return {now, wall_ns_}; }

  const RobotModel& robot_;
  Driver& driver_;
  ControllerSettings settings_;
  Governor governor_;
  Lease lease_;
  CycleWatch watch_;
  SentWay sent_;
  std::optional<PositionJournal> journal_;
  JogMotion jog_;
  ToolState tool_;
  bool streams_;

  MachineState state_ = MachineState::kOff;
  std::optional<Latched> latched_;
  FixedVector<Latched, kLaterCausesMax> later_;
  std::optional<StopCause> last_stop_;
  std::optional<Task> task_;
  std::optional<Stopping> stopping_;
  DriverMemory memory_;         ///< for the driver's first opening
  std::uint32_t enabling_ = 0;  ///< the command that asked for it
  struct Acknowledging {
    std::uint32_t command;
    Instant since;
    bool cleared = false;  ///< the driver was asked to clear its fault
  };
  std::optional<Acknowledging> acknowledging_;  ///< while the device is being told
  Instant enabling_since_{};
  Error enabling_trouble_;
  std::optional<Error> notice_;  ///< of this step
  Instant jog_asked_{};
  /// Told to each jog that is asked for while the hand that asked for the refused one stays down.
  std::optional<Error> jog_refused_;
  int outstanding_ = 0;  ///< commands that the driver has taken and not ended
  double feed_ = 1;
  bool had_holder_ = false;
  bool free_drive_ = false;

  JournalPositions positions_;  ///< while the driver knows none
  bool driver_spoke_ = false;   ///< its positions count: it has been ready, or keeps ours
  JointVector reference_;
  bool reference_known_ = false;
  JointVector blind_target_;        ///< of the slow first move under way
  bool opened_ = false;             ///< the journal has its first record
  bool closed_ = false;             ///< .. and its last
  bool position_given_up_ = false;  ///< recorded for a search that has not begun yet
  std::uint8_t found_ = 0;          ///< joints whose zero the last search has found, a bit each
  std::optional<std::size_t> searched_;  ///< the one that it looks for
  JournalPositions recorded_;            ///< as last said at rest
  std::optional<Instant> waiting_since_;
  std::int64_t wall_ns_ = 0;
  Outputs out_;
};

}  // namespace sinew::control
