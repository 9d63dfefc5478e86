#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/devices/grbl/grbl_driver_facts.h"
#include "sinew/devices/grbl/grbl_driver_motion.h"
#include "sinew/devices/grbl/grbl_driver_positions.h"
#include "sinew/devices/grbl/grbl_driver_settings.h"
#include "sinew/devices/grbl/grbl_wire.h"
#include "sinew/driver/driver_commands.h"

namespace sinew {

struct GrblTiming {
  Duration segment = std::chrono::milliseconds(50);  ///< of a streamed motion
  Duration reply_timeout = std::chrono::milliseconds(250);
  int tries = 4;                                          ///< without an answer it is silent then
  Duration welcome_timeout = std::chrono::seconds(2);     ///< behind a reset
  Duration moving_poll = std::chrono::milliseconds(100);  ///< GRBL asks for 10 Hz at most
  Duration arrival_poll = std::chrono::milliseconds(20);  ///< .. but where something ends
  Duration resting_poll = std::chrono::milliseconds(250);
  Duration silent_retry = std::chrono::milliseconds(500);
  Duration homing_limit = std::chrono::minutes(3);
  /// A motion that was accepted and does not begin, or stands before its end, was ignored.
  Duration ignored_limit = std::chrono::milliseconds(500);
};

/// Host side of a board that speaks GRBL: each segment of a motion is a line, sent ahead so far
/// that the board's planner can brake for what is planned, and never more characters than the board
/// has room for. docs/wires/grbl.md.
///
///   activity  | what happens                                | next
///   ----------+---------------------------------------------+-----------------------------------
///   kClosed   | open                                        | kOpening
///   kOpening  | it stands; reset; settings fit; unlocked    | kIdle, kReady
///   kOpening  | a setting does not fit, it stays locked     | kIdle with the fault, kFailed
///   kIdle     | move                                        | kMoving
///   kMoving   | a piece is over, another one waits          | kMoving, kDone
///   kMoving   | it is idle at the end of the last one       | kIdle, kDone
///   kMoving   | refused, ignored, or beside its path        | kStopping with the fault, kFailed
///   kMoving   | no further piece came                       | kStopping, kFailed (kStreamEnded)
///   kIdle     | home, nudge, probe                          | kHoming, kNudging
///   kHoming   | ok, and where it is                         | kIdle, kDone
///   kNudging  | it is idle, and there; or has touched       | kIdle, kDone
///   those two | refused; a nudge that was ignored           | kIdle, kFailed
///   kNudging  | beside its way                              | kStopping with the fault, kFailed
///   any open  | stop                                        | kStopping
///   kStopping | it has braked; reset                        | kIdle, kStopped
///   any open  | an alarm                                    | kAlarm, then kIdle with the fault
///   any open  | it sleeps: its motors are off               | kIdle with the fault, kFailed
///   any open  | nothing is answered                         | kOpening, kFailed
///   any open  | it restarts                                 | kOpening, kFailed or kNotice
///
/// A fault stays until it is cleared, whatever happens to the board meanwhile.
/// positions(): kCommanded; in motion its way on the lines that the board has.
/// All @rt.
class GrblDriver : public ByteDriver {
 public:
  /// @param joints  as many as the device has axes
  GrblDriver(const GrblDevice& device, std::span<const Joint> joints, std::uint32_t baud,
             const GrblTiming& timing = {});

  void open(Instant now) override;
  void close(Instant now) override;
  DriverState state() const override;
  std::optional<Error> fault() const override { return fault_; }
  std::span<const JointPosition> positions() const override { return positions_; }
  std::optional<Instant> goes_on_until() const override;
  std::optional<JointInterval> counted(std::size_t joint) const override {
    return known_.counted(joint);
  }
  DriverHealth health() const override { return health_; }
  DeviceFacts facts() const override { return DeviceFacts(facts_); }
  bool wants_move(Instant now) const override;
  /// @error the contract's, kUnsendable (number of joints, a speed that is no number), kJointLimit,
  ///        kSegmentTime, kPositionUnknown, kNotHomed (a board that finds its switches first)
  Expected<void> move(const JointMove& move, Instant now) override;
  /// @error kNudgeRange, kNotHomed, kBusy, kPortClosed, the fault
  Expected<void> nudge(std::size_t joint, double way, Duration duration, Instant now) override;
  Expected<void> probe(std::size_t joint, double way, Duration duration, Instant now) override;
  Expected<void> may_probe() const override;
  /// All axes, by the board's own cycle. @error kNoEndStops, kBusy, kPortClosed, the fault
  Expected<void> home(Instant now, std::uint8_t joints) override;
  void stop(Instant now) override;
  Expected<void> clear_fault(Instant now) override;
  bool clearing() const override { return clearing_; }
  void declare_positions(std::span<const JointPosition> positions) override;
  std::uint8_t counters_moved() const override { return known_.away_from_zero(); }
  void poll(Instant now) override;
  std::optional<Instant> next_deadline() const override;
  std::optional<DriverEvent> take_event() override { return commands_.take(); }
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override { return output_.take_front(out); }

  /// Z of the work coordinates' offset that it leaves behind, mm or deg. G43.1 makes it, which no
  /// board keeps without power, and machine coordinates do not know of it.
  static constexpr double kMark = -876.543;

 private:
  enum class Activity : std::uint8_t {
    kClosed,
    kOpening,
    kIdle,
    kMoving,
    kNudging,
    kHoming,
    kStopping,
    kAlarm,
  };
  /// Of an opening, and of a stop, which needs no settings.
  enum class Step : std::uint8_t {
    kLook,   ///< does it stand? Brakes it where not
    kReset,  ///< drops what waits; waits for its welcome
    kLines,  ///< modes, settings, what unlocks it, its mark
    kPlace,  ///< where it is, and whether it is locked
  };
  enum class Sent : std::uint8_t { kMove, kModes, kOther };
  /// A line without its ok.
  struct Line {
    Sent what = Sent::kOther;
    std::uint8_t size = 0;
  };

  Expected<void> may_begin() const;
  Expected<void> may_move() const;
  /// Opening or stopping, and there.
  Expected<grbl::Jog> jog_of(std::size_t joint, double way, Duration duration) const;
  void begin_nudge(const grbl::Jog& jog, double way, Instant now);
  bool is_at(Step step) const {
    return step_ == step && (activity_ == Activity::kOpening || activity_ == Activity::kStopping);
  }
  bool say(const grbl::Request& request, Sent what);
  void say_now(grbl::RealTime what);
  void say_moves(Instant now);
  void ask_status(Instant now);
  void begin_steps(Activity activity, Step step, Instant now);
  void reset_board(Instant now);
  void take(const grbl::Reply& reply, Instant now);
  void take_ok(Instant now);
  void take_refusal(const grbl::Refused& refused, Instant now);
  void take_alarm(std::uint16_t code, Instant now);
  void take_welcome(const grbl::Welcome& welcome, Instant now);
  void take_status(const grbl::Status& status, Instant now);
  void take_probed(const grbl::Probed& probed, Instant now);
  std::optional<grbl::Values> counts_of(const grbl::Status& status);
  bool fell_to_zero(const grbl::Values& counts, Instant asked) const;
  bool believable(const grbl::Values& counts, Instant asked);
  void take_lines(Instant now);
  void step_look(const grbl::Status& status, Instant now);
  bool looks_for_mark();
  bool mark(Instant now);
  void step_place(const grbl::Status& status, Instant now);
  void step_moving(const grbl::Status& status, Instant now);
  void step_nudging(const grbl::Status& status, Instant now);
  std::optional<std::size_t> off_its_way() const;
  void step_alarm(const grbl::Status& status);
  void end_alarm(std::int8_t joint);
  void wait_for_welcome(Instant now);
  void miss_reply(Instant now);
  void search_too_long(Instant now);
  void end_with(const Error& error);
  void come_to_rest();
  void watch_others(const grbl::Status& status, bool moved);
  bool has_mark() const;
  bool is_locked(std::uint16_t alarm) const;
  void end_steps(Instant now);
  void look_at_the_end(Instant now);
  void end_pieces(std::size_t count);
  void begin_stop(Instant now);
  void leave_to_itself();
  void begin_reach();
  void reach_to(std::size_t joint, double q);
  void fall_silent(Instant now);
  void note_restart(Instant now);
  void fail(const Error& error);
  void end_commands(DriverEvent::Kind kind, const Error& error = {});
  void end_stop();
  void update_positions(Instant now);

  GrblDevice device_;
  FixedVector<Joint, kMaxJoints> joints_;
  GrblTiming timing_;
  Duration line_time_;  ///< of the longest line
  Duration braking_{};  ///< from the highest speed
  std::size_t ahead_ = GrblMotion::kPiecesMax;

  Activity activity_ = Activity::kClosed;
  Step step_ = Step::kLook;
  std::optional<Error> fault_;
  GrblPositions known_;
  FixedVector<JointPosition, kMaxJoints> positions_;
  Instant now_{};
  DriverCommands commands_;
  bool clearing_ = false;
  bool told_silent_ = false;
  bool unlocked_ = false;  ///< tried, in this opening
  bool marked_ = false;    ///< likewise
  int looks_ = 0;          ///< at the offset of its work coordinates, before the reset
  std::uint16_t alarm_ = 0;
  std::optional<Instant> alarm_at_;
  GrblSettingsCheck settings_;
  bool listed_again_ = false;    ///< its settings, of which one was missing
  bool modes_ = false;           ///< it has taken them since its reset
  bool locked_ = false;          ///< it asks to be homed first, which is no fault
  bool foreign_ = false;         ///< another sender, or a pendant, moves or holds it
  bool blind_ = false;           ///< it was reset without an answer, in this opening
  bool left_searching_ = false;  ///< .. by a host that went away
  int short_ = 0;                ///< statuses in a row of fewer axes than joints
  std::optional<Instant> goes_on_until_;

  // Lines
  FixedVector<Line, 32> lines_;
  std::size_t unanswered_ = 0;  ///< characters
  std::size_t room_ = 127;      ///< of the board, characters
  Instant lines_since_{};       ///< that are waited for
  std::optional<Instant> reset_at_;
  std::optional<Instant> asked_at_;  ///< the oldest status that has not come
  Instant asked_last_{};             ///< .. and the last one
  Instant counted_at_{};             ///< when the last one that came was asked for
  int unheard_ = 0;
  Instant placing_since_{};
  Instant poll_due_{};
  grbl::Values offset_;  ///< of work coordinates; empty: not told

  // A motion
  GrblMotion motion_;
  Instant changed_{};  ///< the counts last did
  Instant last_piece_{};
  std::optional<Instant> ends_at_;  ///< of what moves, by its own time
  grbl::Values stood_;              ///< counts where it was seen to stand, before a reset
  /// Where the joints may come by what was said since they stood.
  FixedVector<JointInterval, kMaxJoints> reach_;
  grbl::Values nudge_from_, nudge_to_;
  std::uint8_t nudge_joint_ = 0;
  bool probes_ = false;  ///< kNudging: until its input closes

  struct Reading {
    grbl::Values counts;
    Instant asked{};
  };
  std::optional<Reading> suspect_;  ///< the last status, where it was not believed

  GrblFacts facts_;
  DriverHealth health_;
  grbl::LineDecoder decoder_;
  FixedVector<std::uint8_t, 1024> output_;
};

}  // namespace sinew
