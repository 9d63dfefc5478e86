#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/devices/ideal/ideal_wire.h"
#include "sinew/driver/driver_commands.h"
#include "sinew/driver/motion_segments.h"

namespace sinew {

struct IdealTiming {
  Duration reply_timeout = std::chrono::milliseconds(50);  ///< then the same request again
  int tries = 3;                                           ///< without an answer it is silent then
  /// A move that was not taken so long after its line is said again: well inside the time that the
  /// moves before it last.
  Duration move_timeout = std::chrono::milliseconds(25);
  Duration moving_poll = std::chrono::milliseconds(10);
  Duration resting_poll = std::chrono::milliseconds(100);
  Duration silent_retry = std::chrono::milliseconds(500);  ///< between questions to one that is
  Duration jaws_stand = std::chrono::milliseconds(400);    ///< then something is between them
};

/// Host side of the ideal wire: each segment of a motion is one line, said again until it is taken,
/// which happens once however often it is said. Up to six are on their way or wait in the device.
/// docs/wires/ideal.md.
///
///   activity  | what happens                             | next
///   ----------+------------------------------------------+----------------------------------
///   kClosed   | open                                     | kOpening
///   kOpening  | it said who it is, was stopped, stands   | kIdle, kReady
///   kOpening  | it is another device                     | kIdle with the fault, kFailed
///   kIdle     | move                                     | kMoving
///   kMoving   | a move is done, another one waits        | kMoving, kDone
///   kMoving   | the last one is done                     | kIdle, kDone
///   kMoving   | it holds: starved                        | kStopping, kFailed (kStreamEnded)
///   kMoving   | it holds: silent, blocked                | kIdle with the fault, kFailed
///   kMoving   | it refuses a move                        | kStopping with the fault, kFailed
///   kIdle     | tool(JawsTo)                             | kJaws
///   kJaws     | they are there, or stood for too long    | kIdle, kDone
///   any open  | stop                                     | kStopping
///   kStopping | it answered to the stop, and stands      | kIdle, kStopped where one was asked for
///   any open  | nothing is answered, three times over    | kOpening, kFailed; positions lost
///   any open  | it began anew                            | kOpening, kFailed or kNotice
///
/// positions(): kMeasured from the device's first answer on, -+ a micrometre (microradian) at rest
/// and in motion the way that a joint can have gone since that answer was asked for. All @rt.
class IdealDriver : public ByteDriver {
 public:
  /// @param joints  1 to 8
  IdealDriver(std::span<const Joint> joints, const std::optional<JawGripper>& gripper,
              std::uint32_t baud, const IdealTiming& timing = {});

  void open(Instant now) override;
  void close(Instant now) override;
  DriverState state() const override;
  std::optional<Error> fault() const override { return fault_; }
  std::span<const JointPosition> positions() const override { return positions_; }
  /// Where it fell silent in a motion: until its own deadline has stopped it.
  std::optional<Instant> goes_on_until() const override;
  DriverHealth health() const override { return health_; }
  bool wants_move(Instant now) const override;
  /// @error the contract's, kUnsendable (number of joints, a speed that is no number), kJointLimit,
  ///        kSegmentTime
  Expected<void> move(const JointMove& move, Instant now) override;
  void stop(Instant now) override;
  /// JawsTo only. @error kToolNotFitted, kJawWidth, kBusy, kPortClosed, the fault
  Expected<void> tool(const ToolAction& action, Instant now) override;
  Expected<void> clear_fault(Instant now) override;
  bool clearing() const override { return clearing_; }
  void poll(Instant now) override;
  std::optional<Instant> next_deadline() const override;
  std::optional<DriverEvent> take_event() override { return commands_.take(); }
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override { return output_.take_front(out); }

 private:
  enum class Activity : std::uint8_t { kClosed, kOpening, kIdle, kMoving, kJaws, kStopping };
  struct Pending {
    ideal::Move move;
    FixedVector<Cubic::State, kMaxJoints> end;  ///< as it was asked for, before rounding
    bool rest = false;                          ///< ends at rest
    bool taken = false;
    std::optional<Instant> said_at;  ///< last
  };
  /// A line that is out.
  struct Line {
    Instant at{};
    ideal::Request request;
  };
  /// What waits for its answer, beside moves.
  struct Asked {
    ideal::Request request;
    std::uint16_t first = 0;  ///< its lines' numbers
    Instant due{};
  };

  Expected<void> may_begin() const;
  Expected<Pending> pending_of(const JointMove& move) const;
  Duration on_the_wire() const;
  bool say(const ideal::Request& request, Instant now);
  void ask(const ideal::Request& request, Instant now);
  void say_what_is_due(Instant now);
  void say_moves(Instant now);
  void take(const ideal::Numbered<ideal::Reply>& reply, Instant now);
  void take_identity(const ideal::Identity& identity, Instant now);
  void take_state(const ideal::State& state, Instant now);
  void take_refusal(const ideal::Refusal& refusal, const ideal::Request& of, Instant now);
  void step_opening();
  void step_moving(Instant now);
  void step_jaws(Instant now);
  void step_stopping();
  void begin_stop(Instant now);
  void begin_anew(const Error& why, Instant now);
  void note_restart(Instant now);
  void fall_silent(Instant now);
  void fail(const Error& error);
  void come_to_rest(DriverEvent::Kind kind, const Error& error = {});
  void end_commands(DriverEvent::Kind kind, const Error& error = {});
  void update_positions(Instant now);

  FixedVector<Joint, kMaxJoints> joints_;
  std::optional<double> width_max_;
  std::uint32_t baud_;
  IdealTiming timing_;
  Duration brake_max_{};

  Activity activity_ = Activity::kClosed;
  std::optional<Error> fault_;
  FixedVector<JointPosition, kMaxJoints> positions_;
  Instant now_{};
  DriverCommands commands_;
  bool known_ = false;     ///< it has said who it is, since open() or its last silence
  bool foreign_ = false;   ///< .. and that it is another device: it is left alone
  bool stop_due_ = false;  ///< it has not answered to it
  bool clear_due_ = false;
  bool clearing_ = false;
  bool told_silent_ = false;
  std::optional<Instant> goes_on_until_;

  // Lines. Their numbers count on, so that an answer says what it answers.
  static constexpr std::uint16_t kLinesKept = 64;  // a power of two
  std::array<Line, kLinesKept> lines_;
  std::uint16_t line_ = 0;      ///< the last one that was said
  std::uint16_t answered_ = 0;  ///< the last one that was answered
  std::optional<Asked> asked_;
  Instant heard_at_{};
  Instant poll_due_{};

  std::uint16_t number_ = 0;  ///< of the last move that was made up
  FixedVector<Pending, 6> pending_;
  Instant last_move_{};
  std::optional<ideal::State> state_;
  Instant state_asked_{};
  std::optional<std::int32_t> jaws_due_;
  std::int32_t jaws_to_ = 0;
  std::int32_t jaws_at_ = 0;  ///< um, as told last
  Instant jaws_since_{};      ///< they stand there

  DriverHealth health_;
  ideal::LineDecoder decoder_;
  FixedVector<std::uint8_t, 8 * ideal::kLineMax> output_;
};

}  // namespace sinew
