#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/devices/ideal/ideal_wire.h"
#include "sinew/driver/axis_link_segments.h"
#include "sinew/driver/driver.h"

namespace sinew {

struct IdealTiming {
  Duration reply_timeout = std::chrono::milliseconds(50);  ///< then the same line again
  int tries = 3;                                           ///< of one line, then it is silent
  Duration moving_poll = std::chrono::milliseconds(10);
  Duration resting_poll = std::chrono::milliseconds(100);
  Duration silent_retry = std::chrono::milliseconds(500);  ///< between questions to one that is
  Duration jaws_timeout = std::chrono::seconds(2);         ///< then something is between them
};

/// Host side of the ideal wire: every segment of a motion is one line, which the device takes once
/// however often it is said. docs/wires/ideal.md.
///
///   activity  | what happens                             | next
///   ----------+------------------------------------------+----------------------------------
///   kClosed   | open                                     | kOpening
///   kOpening  | it said who it is, was stopped, stands   | kIdle, kReady
///   kOpening  | it is another device                     | kIdle with the fault, kFailed
///   kIdle     | move                                     | kMoving
///   kMoving   | a move is done, another one waits        | kMoving, kDone
///   kMoving   | the last one is done                     | kIdle, kDone
///   kMoving   | it holds: starved                        | kIdle, kFailed (kSegmentTime)
///   kMoving   | it holds: silent, blocked; it refuses    | kIdle with the fault, kFailed
///   kIdle     | tool(JawsTo)                             | kJaws
///   kJaws     | they are there, or stood for too long    | kIdle, kDone
///   any open  | stop                                     | kStopping
///   kStopping | it stands                                | kIdle, kStopped
///   any open  | three lines without an answer            | kOpening, kFailed; positions lost
///   any open  | it began anew                            | kOpening, kFailed or kNotice
///
/// positions(): kMeasured from the device's first answer on, -+ a micrometre (microradian) at rest
/// and in motion the way that a joint can have gone since it was asked. All @rt.
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
  std::optional<DriverEvent> take_event() override { return events_.take_front(); }
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override { return output_.take_front(out); }

 private:
  enum class Activity : std::uint8_t { kClosed, kOpening, kIdle, kMoving, kJaws, kStopping };
  struct Pending {
    ideal::Move move;
    bool sent = false;
    bool rest = false;  ///< ends at rest
    Duration duration{};
  };

  Expected<void> may_begin() const;
  Expected<ideal::Move> line_of(const JointMove& move) const;
  void say(const ideal::Request& request, Instant now);
  void send(Instant now);
  void say_again(Instant now);
  void say_what_is_due(Instant now);
  void take(const ideal::Reply& reply, Instant now);
  void take(const ideal::Identity& identity, Instant now);
  void take(const ideal::State& state, Instant now);
  void take(const ideal::Refusal& refusal, Instant now);
  void step_opening(Instant now);
  void step_moving(Instant now);
  void step_jaws(Instant now);
  void step_stopping(Instant now);
  void begin_stop(Instant now);
  void note_restart(Instant now);
  void begin_anew(const Error& why, Instant now);
  void fall_silent(Instant now);
  void fail(const Error& error);
  void come_to_rest(DriverEvent::Kind kind, const Error& error = {});
  void end_commands(DriverEvent::Kind kind, const Error& error = {});
  void lose_positions();
  void update_positions(Instant now);
  void tell(DriverEvent::Kind kind, const Error& error = {});

  FixedVector<Joint, kMaxJoints> joints_;
  std::optional<double> width_max_;
  std::uint32_t baud_;
  IdealTiming timing_;
  Duration brake_max_{};

  Activity activity_ = Activity::kClosed;
  std::optional<Error> fault_;
  FixedVector<JointPosition, kMaxJoints> positions_;
  Instant now_{};
  Instant since_{};           ///< when the activity began
  std::size_t commands_ = 0;  ///< accepted, and without their last event
  bool stop_due_ = false;
  bool clear_due_ = false;
  bool clearing_ = false;
  bool known_ = false;  ///< it has said who it is, since open() or its last silence
  bool told_silent_ = false;

  // The line that waits for its answer.
  std::optional<ideal::Request> said_;
  std::uint16_t line_ = 0;  ///< its number
  Instant said_at_{};       ///< first
  Instant answer_due_{};
  int tries_left_ = 0;
  Instant poll_due_{};

  std::uint16_t number_ = 0;  ///< of the last move that was made up
  FixedVector<Pending, 4> pending_;
  std::optional<ideal::State> state_;
  Instant state_asked_{};
  std::optional<std::int32_t> jaws_due_;
  std::int32_t jaws_to_ = 0;

  DriverHealth health_;
  ideal::LineDecoder decoder_;
  FixedVector<std::uint8_t, 2 * ideal::kLineMax> output_;
  FixedVector<DriverEvent, 16> events_;
};

}  // namespace sinew
