#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/devices/icp/icp_driver_facts.h"
#include "sinew/devices/icp/icp_driver_leg.h"
#include "sinew/devices/icp/icp_driver_step_merge.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/icp/icp_wire.h"
#include "sinew/driver/driver.h"
#include "sinew/driver/send_range.h"

namespace sinew {

struct IcpTiming {
  Duration byte_time{1'041'667};  ///< on the wire: 10 bits at 9600 baud
  /// A reply that comes sooner than two bytes take is none. False where the bytes travel through
  /// something that is quicker than the wire.
  bool refuse_early = true;
  Duration quiet = std::chrono::milliseconds(100);  ///< twice the longest answer: ends a doubt
  Duration quiet_limit = std::chrono::seconds(4);   ///< a line that talks on for so long is told
  Duration idle_limit = std::chrono::minutes(10);   ///< after it, silence means: shut itself down
  /// After a silence of so long the modules are looked at before the next step: a power cut leaves
  /// their target position 0.
  Duration trust = std::chrono::milliseconds(500);
  /// A status that may not be asked for is given up behind so long.
  Duration look_limit = std::chrono::seconds(2);
  /// A leg whose interval is wider, in position units, is not moved any more.
  std::int64_t uncertain_units_max = 8;
};

/// Host side of the hexapod's wire: leg lengths to single microsteps, one exchange each, six legs
/// merged so that the platform stays on its line. Every exchange begins with FF; what follows its
/// ACK is decided when the ACK is there.
///
///   phase    | what happens                        | next
///   ---------+-------------------------------------+--------------------------------------------
///   kIdle    | a command                           | kInit
///   kInit    | 00                                  | kStep, kRequest, kWake or kKill
///   kInit    | 11 (it was inside an exchange)      | kInit, once more
///   kStep    | 00                                  | kInit, kPause or kIdle: the step is made
///   kStep    | 11, 22                              | kInit: it is not made, the same step again
///   kStep    | anything else, nothing in time      | kQuiet: the leg is uncertain by this step
///   kRequest | 00                                  | kSelect
///   kSelect  | 00 and 12 bytes                     | kInit or kIdle: the leg is judged
///   kWake    | 00, or 11 of a firmware without it  | kInit: the status of all six
///   kKill    | nothing                             | kIdle, fault kDeviceKilled
///   kPause   | the next step is due                | kInit
///   kHeld    | a status may be asked for           | kInit
///   kQuiet   | silence for `quiet`                 | kInit, then a status before anything else
///   kQuiet   | a byte                              | kQuiet, the silence starts again
///   any      | a byte too soon, a byte unasked,    | kQuiet; after `tries` in a row kFault
///            | a wrong one, nothing in time        |
///
/// After a doubt no step leaves before a status has come in full: its fixed bits show whether the
/// answers are still those to the questions. No sync byte is sent where a flipped bit could make a
/// step of it, nor to open with: FF gets the device out of there as well.
///
/// A motion, also one that was stopped, ends with a status of every leg; what that
/// shows to be undone makes the leg uncertain (IcpLegClaim) and ends in kFault. Where a status
/// tells of the supply, or the device stays silent, that goes for all legs: until six good statuses
/// show that the modules have forgotten nothing. A leg may be uncertain by uncertain_units_max and
/// still move. Leg limits are told as kLegLength. All members are @rt.
class IcpDriver final : public ByteDriver {
 public:
  static constexpr std::size_t kQueue = 4;  ///< moves
  static constexpr double kJogMax = 1e-3;   ///< m

  /// @param legs  six, with the limits that no move leaves.
  IcpDriver(const IcpDevice& device, std::span<const Joint> legs, const IcpTiming& timing = {});

  void open(Instant now) override;
  void close(Instant now) override;
  DriverState state() const override;
  std::optional<Error> fault() const override { return fault_; }
  std::span<const JointPosition> positions() const override { return positions_; }
  /// The microstep that was on its way when the stop came.
  std::optional<Instant> goes_on_until() const override;
  DriverHealth health() const override { return health_; }
  DeviceFacts facts() const override { return DeviceFacts(facts_); }
  bool wants_move(Instant now) const override;
  /// Steps are spread over move.duration where the wire is quicker than that.
  /// @error kLegLength, kPositionUnknown (index), kSegmentTime, kBusy, kPortClosed, fault's own
  Expected<void> move(const JointMove& move, Instant now) override;
  /// A jog in m; @error kNudgeRange, and those of jog()
  Expected<void> nudge(std::size_t leg, double way, Duration duration, Instant now) override;
  /// Steps end with the one in flight; kStopped comes when the legs have been read, or
  /// do not answer. What the statuses show then is a kNotice.
  void stop(Instant now) override;
  Expected<void> clear_fault(Instant now) override;
  /// Only while nothing moves; else it is not heard.
  void declare_positions(std::span<const JointPosition> positions) override;
  void remember(const DriverMemory& memory) override;
  std::uint8_t counters_moved() const override { return tagged_legs(); }
  bool looks() const override;
  void allow_looks(bool allowed) override { looks_allowed_ = allowed; }
  Expected<void> service(DeviceService what, Instant now) override;
  void poll(Instant now) override;
  std::optional<Instant> next_deadline() const override { return deadline_; }
  std::optional<DriverEvent> take_event() override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override;

  /// Steps of one leg, also while nobody knows where it is; + is longer.
  /// @error kStepRange (beyond kJogMax), and those of move()
  Expected<void> jog(std::size_t leg, std::int64_t steps, Instant now);
  /// At rest: reads all motor modules, wakes them, and reads them again; kDone follows.
  /// @error kBusy, fault's own
  Expected<void> wake(Instant now);
  /// Shuts the controller down until its power is cut: kDone, then fault kDeviceKilled.
  /// @error kBusy, fault's own
  Expected<void> kill(Instant now);

  /// The last status of a leg.
  std::optional<icp::Status> status(std::size_t leg) const {
    const auto& heard = facts_.legs[leg].status;
    return heard ? std::optional(heard->what) : std::nullopt;
  }
  std::int64_t steps_left() const;
  /// Of one step, moving mean.
  Duration cycle_time() const { return cycle_time_; }
  /// For all moves accepted, as things go.
  Duration time_left() const { return steps_left() * cycle_time_; }

 private:
  enum class Phase : std::uint8_t {
    kClosed,
    kIdle,
    kPause,
    kHeld,
    kQuiet,
    kInit,
    kStep,
    kRequest,
    kSelect,
    kWake,
    kKill,
  };
  enum class Command : std::uint8_t { kNone, kStatus, kWake, kKill };
  struct Move {
    JointVector q;
    Duration duration{};
    StepMerge::Counts jog{};  ///< instead of q, where q is empty
  };

  Expected<void> ready() const;
  /// The device has to say something next.
  bool awaits_answer() const;
  Expected<void> accept(const Move& move, Instant now);
  Expected<void> begin_command(Command command, std::uint8_t polls, Instant now);
  void begin_opening(Instant now);
  void listen(Instant now);
  void begin_exchange(Instant now);
  void hold(Instant now);
  void begin_move(Instant start);
  void send(const icp::Request& request, Phase phase, Instant now);
  void send_command(Instant now);

  void on_byte(std::uint8_t byte, Instant now);
  void on_reply(const icp::Reply& reply, Instant now);
  void on_refusal(Instant now);
  void on_status(const icp::Status& status, Instant now);
  void on_deadline(Instant now);

  void next(Instant now);
  void next_of_move(Instant now);
  void finish(Instant now);
  void step_made(Instant now);
  void doubt(const Error& error, Instant now);
  void give_up(const Error& error);
  void fail_all(const Error& error);
  void end_stopped(Instant now);
  void tell_stopped();
  void count_failure();
  void suspect_supply();
  void suspect_silence();
  Error silence(Instant now) const;
  std::uint8_t legs_to_read() const;
  std::uint8_t tagged_legs() const;
  std::optional<Error> too_uncertain() const;
  std::optional<Error> too_far(std::size_t leg, double length) const;
  bool running() const { return !queue_.empty() && !finishing_; }
  void refresh(std::size_t leg) { positions_[leg] = legs_[leg].position(); }
  void tell(DriverEvent::Kind kind, const Error& error = {});

  IcpDevice device_;
  IcpTiming timing_;
  std::array<SendRange, kLegs> ranges_{};
  std::array<IcpLegClaim, kLegs> legs_;
  std::array<JointPosition, kLegs> positions_;
  IcpFacts facts_;

  Phase phase_ = Phase::kClosed;
  std::optional<Instant> deadline_;
  Instant asked_{};     ///< when the byte under way was put out
  Instant earliest_{};  ///< before it no reply is one
  Instant began_{};     ///< the exchange under way
  Instant heard_{};     ///< the last byte
  Instant quiet_since_{};
  icp::ReplyDecoder decoder_;
  std::optional<std::uint8_t> output_;

  bool opening_ = false;      ///< kReady or kFailed is owed
  bool read_ = false;         ///< a status was asked for since then, which clears its flags
  bool recovering_ = false;   ///< no step before a status has come
  bool leading_out_ = false;  ///< the next FF may be refused: the device may be inside an exchange
  bool kill_suspected_ = false;
  bool selector_is_step_ = false;  ///< this firmware checks selectors
  int failures_ = 0;               ///< exchanges in a row that led to nothing
  int rereads_ = 0;
  std::uint8_t polls_ = 0;  ///< legs whose status is due, a bit each
  std::size_t polled_ = 0;
  bool looks_allowed_ = true;
  std::optional<Instant> held_since_;  ///< a status is due that may not be asked for
  std::optional<Error> poll_error_;
  bool supply_lost_ = false;  ///< a status of this round tells so
  Instant failing_since_{};   ///< the first question of those failures

  FixedVector<Move, kQueue> queue_;  ///< the first is under way
  StepMerge merge_;
  Instant move_start_{};
  bool finishing_ = false;  ///< its steps are made, the statuses are due
  bool stop_asked_ = false;
  bool stopping_ = false;       ///< nothing moves any more, the statuses are due
  std::size_t stops_owed_ = 0;  ///< kStopped events that are told then
  Command command_ = Command::kNone;
  std::optional<Error> fault_;

  Duration cycle_time_{};
  DriverHealth health_;
  FixedVector<DriverEvent, 16> events_;
};

}  // namespace sinew
