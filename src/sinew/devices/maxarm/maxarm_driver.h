#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/devices/maxarm/maxarm_driver_facts.h"
#include "sinew/devices/maxarm/maxarm_driver_pulses.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/devices/maxarm/maxarm_wire.h"
#include "sinew/driver/driver.h"
#include "sinew/model/device.h"

namespace sinew {

struct MaxArmTiming {
  /// Behind the question's last bit. The slowest answer measured took 0.54 s.
  Duration reply_timeout = std::chrono::milliseconds(700);
  Duration frame_gap = std::chrono::milliseconds(20);
  Duration byte_time = std::chrono::microseconds(1042);   ///< 10 bits at 9600 baud
  Duration read_period = std::chrono::milliseconds(130);  ///< from question to question, at least
  /// From a command's end until the resting arm is looked at: then and MaxArmPace::idle later, no
  /// question is out at the whole halves of a second at which most programs end a wait.
  Duration idle_first = std::chrono::milliseconds(520);
  Duration quiet = std::chrono::milliseconds(60);  ///< silence on the line that ends a doubt
  Duration wake = std::chrono::milliseconds(150);  ///< behind the burst of zeros
  /// Until a silent device is given up: a restarted one sleeps and homes 13.5 s.
  Duration patience = std::chrono::seconds(25);
  Duration settle = std::chrono::milliseconds(2500);  ///< beyond a move's own time
  std::uint16_t stop_ms = 100;
  std::int32_t reached = 6;  ///< pulses beside the target that a servo under load may rest
};

/// Host side of the MaxArm's wire: point to point with reading back, since no SET is answered.
///
/// | state | goes on when |
/// |---|---|
/// | opening: quiet, (burst of zeros,) READ_XYZ, READ_ANGLE | two equal readings: ready |
/// | ready | idle readings; a command |
/// | moving: SET_ANGLE, readings | rests at the target (done), rests elsewhere (failed) |
/// | stopping: READ_ANGLE, SET_ANGLE to it | rests |
/// | fault: silent for `patience`, dead servo | clear_fault() |
///
/// Any time-out or damaged answer leads back to quiet, from every state; the command under way
/// waits. READ_XYZ marks the line: answers keep their order, so whatever READ_ANGLE answers behind
/// it was measured behind it. A SET is sent again only when readings show the arm at rest where
/// the move began; its target is absolute, so a copy that was only late changes nothing.
///
/// Answers take their time as they like; an undisturbed move or tool action does not. It is told as
/// done at the instant by which its last reading is there in 99 of 100 cases (MaxArmPace), so that
/// what follows begins when it was planned to. A MicroPython board takes a SET up to 100 ms later,
/// when it looks at its port; its answers tell when that is. A SET goes out clear of its looks, and
/// its ramp ends as if it had begun at the latest of them.
///
/// An arm at rest that is found elsewhere is told (notice kMovedUnasked), each new place once.
///
/// Positions: measured to half a pulse and one more for creeping while two readings agree;
/// uncertain over the way while it moves; uncertain over the whole range in doubt; lost for a dead
/// servo. @rt
class MaxArmDriver : public ByteDriver {
 public:
  /// @param joints  base, shoulder, forearm; their limits hold, inclusive
  MaxArmDriver(const MaxArmDevice& device, std::span<const Joint> joints,
               const MaxArmTiming& timing = {});

  void open(Instant now) override;
  void close(Instant now) override;
  DriverState state() const override;
  std::optional<Error> fault() const override { return fault_; }
  std::span<const JointPosition> positions() const override { return positions_; }
  /// While a stop has not been heard, or is not carried out yet.
  std::optional<Instant> goes_on_until() const override;
  DriverHealth health() const override { return health_; }
  DeviceFacts facts() const override;
  bool wants_move(Instant now) const override;

  /// @error kBusy, kPositionUnknown, kMovedUnasked, kJointLimit, kPulseRange (1..1000: a servo at 0
  /// kills the
  ///        MicroPython program), kSegmentTime (20 ms..30 s, and no faster than the joints may),
  ///        or the fault's code
  Expected<void> move(const JointMove& move, Instant now) override;
  /// The wire has no stop: reads where the arm is and sends it there. Ends a nozzle's turn late.
  void stop(Instant now) override;
  Expected<void> clear_fault(Instant now) override;
  /// Suction is sent twice, 20 ms apart; neither it nor the nozzle can be read back.
  /// @error kToolNotFitted, kGripperRange (us), kSegmentTime, kBusy
  Expected<void> tool(const ToolAction& action, Instant now) override;

  void poll(Instant now) override;
  std::optional<Instant> next_deadline() const override;
  std::optional<DriverEvent> take_event() override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override;

  /// The sum that this device's answers have, once two of them agree.
  std::optional<maxarm::Checksum> checksum() const;

 private:
  using Pulses = MaxArmPulses;
  enum class Phase : std::uint8_t {
    kClosed,
    kQuiet,    ///< listening to nothing, `due_` after the last byte
    kWaking,   ///< the zeros do their work
    kMarking,  ///< READ_XYZ asked
    kPausing,  ///< until the next READ_ANGLE
    kReading,  ///< READ_ANGLE asked
    kTooling,  ///< tool frames go out, or the nozzle turns
    kFault,
  };
  enum class Job : std::uint8_t { kNone, kMove, kTool, kStop };

  void doubt(Instant now);
  void give_up(const Error& error);
  void finish(DriverEvent::Kind kind, const Error& error = {});
  void tell(DriverEvent::Kind kind, const Error& error = {});
  void send(const maxarm::Request& request, Instant now);
  void ask(const maxarm::Request& question, Phase phase, Instant now);
  void pause(Duration duration, Instant now);
  bool trusted(const maxarm::ReplyFrame& frame);
  void take_reading(const maxarm::Angles& angles, Instant now);
  void go_on(Instant now);
  void go_on_with_move(Instant now);
  void begin_move(Instant now);
  bool arrived() const;
  Instant next_reading(Instant earliest) const;
  bool knows_looks() const;
  Instant look_behind(Instant at) const;
  void go_on_with_stop(Instant now);
  void go_on_with_tool(Instant now);
  void rest_idle(Instant now);
  void tell_if_moved();
  std::optional<Error> moved_from(const JointVector& q) const;
  maxarm::SetAngle sturdy_set(const Pulses& target, std::int32_t time_ms) const;
  void send_set(const Pulses& target, std::int32_t time_ms, Instant begins, Instant now);
  bool rests() const { return alike_ >= 2; }
  std::size_t farthest(const Pulses& from) const;
  bool near(const Pulses& a, const Pulses& b, std::int32_t tolerance) const;
  void show_measured();
  void show_way();
  void show_doubt();
  void show(std::size_t joint, PositionQuality quality, double low, double high);
  double angle_of(std::size_t joint, double pulse) const;

  MaxArmDevice device_;
  FixedVector<Joint, kMaxJoints> joints_;
  MaxArmTiming timing_;
  MaxArmPace pace_;

  Phase phase_ = Phase::kClosed;
  Job job_ = Job::kNone;
  bool ready_ = false;     ///< opened, and in no doubt
  bool in_doubt_ = false;  ///< since doubt_since_
  Instant due_{};
  Instant free_at_{};  ///< when the next frame may begin
  Instant asked_at_{};
  Instant doubt_since_{};
  int silent_ = 0;  ///< questions in a row without an answer
  std::optional<Error> fault_;

  maxarm::ReplyDecoder decoder_;
  std::uint64_t skipped_ = 0;
  maxarm::Checksum checksum_ = maxarm::Checksum::kSpec;
  int checksum_votes_ = 0;
  int strangers_ = 0;  ///< answers in a row with the other sum

  Pulses reading_{};
  Pulses previous_{};
  int alike_ = 0;  ///< readings in a row that say the same
  Pulses way_low_{};
  Pulses way_high_{};

  Pulses start_{};
  Pulses target_{};
  std::int32_t time_ms_ = 0;
  int sets_ = 0;                     ///< SETs sent for this command
  std::optional<Instant> begun_at_;  ///< of a move that waits to go out clear of the board's looks
  Instant moves_until_{};            ///< the ramps are over, and the servos settled
  Instant told_at_{};                ///< not before, so that it is when it was said to be
  std::optional<Instant> answered_at_;  ///< when the board's last answer began to leave it

  maxarm::Request tool_request_;
  int tool_frames_ = 0;  ///< still to send
  Duration tool_time_{};

  std::optional<Pulses> left_at_;  ///< where the last command left it, or was told that it is

  std::array<JointPosition, maxarm::kServos> positions_{};
  DriverHealth health_;
  MaxArmFacts facts_;
  FixedVector<std::uint8_t, 64> output_;
  FixedVector<DriverEvent, 16> events_;
};

}  // namespace sinew
