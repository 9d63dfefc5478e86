#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/lsc/lsc_driver_facts.h"
#include "sinew/devices/lsc/lsc_driver_units.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/lsc/lsc_wire.h"
#include "sinew/driver/driver.h"

namespace sinew {

struct LscTiming {
  std::uint32_t baud = 9600;  ///< bits per s, ten to a byte
  /// Shortest segment; never shorter than its own frame takes on the wire.
  Duration segment_min = std::chrono::milliseconds(20);
  Duration segment_max = std::chrono::milliseconds(100);
  /// A move from a position that nobody knows takes between these two.
  Duration first_move_min = std::chrono::seconds(2);
  Duration first_move_max = std::chrono::seconds(30);
  Duration lead = std::chrono::milliseconds(15);  ///< wants_move() before the frame must leave
  Duration jaws_stroke = std::chrono::milliseconds(800);  ///< from open to closed
  Duration quiet = std::chrono::milliseconds(60);         ///< silence that ends a doubt
  Duration quiet_limit = std::chrono::seconds(2);         ///< noise that is asked into all the same
  Duration reply_timeout = std::chrono::milliseconds(150);   ///< beyond the question's own time
  Duration output_timeout = std::chrono::milliseconds(500);  ///< a port that takes no bytes
  Duration health_period = std::chrono::seconds(1);
  Duration settle = std::chrono::milliseconds(300);  ///< bus: from the end of a motion to reading
  int tries = 3;
  double measured_tolerance = 0.09;  ///< rad, bus: further from its target, a joint missed it
  double supply_notice_volts = 6.4;  ///< two lithium cells that are as good as empty
  double supply_fault_volts = 5.0;   ///< the board beeps, servos give way
};

/// The LeArm's servo board seen from the host: streamed segments, each one frame with the absolute
/// targets of all servos, so that the next one mends what a bad one did. docs/wires/lsc.md.
///
///   phase      | what ends it                        | then
///   kQuiet     | 60 ms without a byte                | stop groups, ask: kAsking
///   kAsking    | a sign of life; esp32, bus: two     | kIdle; kFault where the supply is too low,
///              | positions in a row that agree;      | or where an lsc6 tells positions: then it
///              | lsc6: two silences where it is      | is a bus board, which would move mirrored
///              | asked for one, once per open()      |
///   kIdle      | move(), tool()                      | kRunning
///   kRunning   | the segment's end with a next one   | kRunning, kDone for the one that ended
///              | without                             | kConfirming
///   kConfirming| targets sent twice more             | kIdle; esp32: kReading; bus: kSettling
///   kSettling  | 300 ms                              | kReading
///   kReading   | two positions in a row that agree   | kIdle
///   any open   | silence thrice, a foreign motion    | kQuiet, positions lost
///   any open   | supply < 5 V twice                  | kFault until clear_fault()
///
/// A position that is lost or uncertain allows one kind of move: 2 s to 30 s long, so that the arm
/// goes slowly. It is sent again every 100 ms with the time that is left. A joint that was measured
/// beyond a limit (a limp arm has sunk, a hand has pushed it) goes inward at the speed of any other
/// move.
///
/// At rest an lsc6 hears its targets again behind each sign of life: nothing tells the host that
/// the last frame of a motion was damaged, so that must not count for longer than a second.
///
/// A servo on the bus holds against the arm's weight only beside where it was told to be. While it
/// stays where it was measured, as when the jaws move, it hears again what it was told, not where
/// it stands: else it would sink once more.
///
/// positions(): what was commanded is claimed with the servo's dead band and sag to either side,
/// 0.06 rad; what was measured with the wire's resolution.
///
/// stop() drops what has not begun to leave and sends the place where the servos will be as their
/// target, to be reached in 20 ms: they stand 72 ms later at most. Where they stand before that
/// frame could arrive it says the segment's end once more. During the first move of an arm on a
/// board that tells nothing, that place is not known; there the move is slowed to the longest time
/// the wire can say, 65 s (some 3 deg/s), and the position stays lost; goes_on_until() says so.
/// Every command that was under way at a stop ends with its own kStopped. @rt
class LscDriver : public ByteDriver {
 public:
  /// @param joints  one per servo of the device, asserted.
  LscDriver(const LscDevice& device, std::span<const Joint> joints,
            const std::optional<JawGripper>& gripper, const LscTiming& timing = {});

  void open(Instant now) override;
  void close(Instant now) override;
  DriverState state() const override;
  std::optional<Error> fault() const override { return fault_; }
  std::span<const JointPosition> positions() const override;
  DriverHealth health() const override { return health_; }
  DeviceFacts facts() const override { return DeviceFacts(facts_); }
  std::optional<Instant> goes_on_until() const override { return goes_on_until_; }
  bool wants_move(Instant now) const override;
  /// @error beside the contract's: kMovedUnasked on the bus only, kPositionUnknown (measured,
  /// limit: s) where the position is lost
  ///        and the move is not a slow one; kSegmentTime with a joint where it would be too fast.
  Expected<void> move(const JointMove& move, Instant now) override;
  void stop(Instant now) override;
  /// @error the fault itself, while its cause is there; kBusy
  Expected<void> clear_fault(Instant now) override;
  bool free() const override { return free_; }
  /// kFree and kHold, on the bus only: the arm is led by hand, and read twenty times a second at
  /// most.
  /// @error kNoSuchService, kBusy, kPortClosed, the fault
  Expected<void> service(DeviceService what, Instant now) override;
  /// JawsTo only. @error kToolNotFitted, kGripperRange, kBusy, kPortClosed, the fault
  Expected<void> tool(const ToolAction& action, Instant now) override;
  /// Taken on the lsc6 board only, which cannot be asked, while nothing moves. kCommanded promises
  /// that the board has kept its power since.
  void declare_positions(std::span<const JointPosition> positions) override;
  void poll(Instant now) override;
  std::optional<Instant> next_deadline() const override;
  std::optional<DriverEvent> take_event() override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override;

 private:
  enum class Phase : std::uint8_t {
    kClosed,
    kQuiet,
    kAsking,
    kIdle,
    kRunning,
    kConfirming,
    kSettling,
    kReading,
    kFault,
  };
  enum class Question : std::uint8_t { kNone, kBattery, kVersion, kPositions, kKind };
  using Units = std::array<std::uint16_t, kMaxJoints>;

  /// What the board was told about one servo; units.
  struct Slot {
    bool held = false;   ///< it is named in every frame
    bool known = false;  ///< `from` is where the board began
    double from = 0;
    double to = 0;
    double lower = 0;  ///< all that it was sent through since it last stood
    double upper = 0;
    std::uint16_t told = 0;  ///< in the last frame
    double rest = 0;         ///< where it was measured to stand
    double sag = 0;          ///< .. and that beside what it was told
  };
  struct Segment {
    Units to{};
    std::uint8_t mask = 0;  ///< slots that it moves
    Duration duration{};
    Instant start{};  ///< when its frame has arrived
    Instant end{};
    bool rest = true;    ///< the end of a motion
    bool sent = false;   ///< for the one that waits
    bool first = false;  ///< for the one that waits: no command ends where it takes over
  };

  bool lost() const;
  bool outside() const;
  SendRange range_of(std::size_t joint) const;
  Expected<void> may_begin() const;
  Expected<void> check_start(const JointMove& move) const;
  Expected<void> check_time(const Segment& segment, const JointMove& move) const;
  void begin(const Segment& segment, Instant now);
  void promote();
  double at(const Slot& slot, Instant time) const;
  std::uint16_t told(std::size_t slot, std::uint16_t to) const;
  void measure_sag(std::size_t joint, double there);
  Duration byte_time() const;
  Duration frame_time(std::uint8_t also = 0) const;

  void send(const lsc::Request& request, Instant now);
  void send_targets(const Segment& segment, Instant now, Duration time);
  bool drop_targets();
  void say_rest(Instant now);
  void send_segment(Segment& segment, Instant now, Instant end);
  void poll_opening(Instant now);
  void poll_running(Instant now);
  void poll_confirming(Instant now);
  void poll_health(Instant now);
  void poll_free(Instant now);
  void follow_hand(const Units& units, Instant now);
  void poll_question(Instant now);
  void send_stop(Instant now);
  void after_confirming(Instant now);
  void finish(Instant now);
  void end_all(DriverEvent::Kind kind, const Error& error = {});

  void ask(Question question, Instant now);
  void note(const lsc::Reply& reply, Instant now);
  void handle(const lsc::Reply& reply, Instant now);
  void take_battery(double volts, Instant now);
  void take_life(Instant now);
  void take_kind(const lsc::Positions& positions);
  void admit_motion();
  void take_positions(std::span<const lsc::ServoValue> servos, Instant now);
  void positions_agreed(const Units& units, Instant now);
  void check_arrival(const Units& units, Instant now);
  bool text_says_boot(std::uint8_t byte);
  void doubt(const Error& error, Instant now);
  void enter_fault(const Error& error);
  void lose_positions();
  void become_ready(Instant now);
  void refresh(Instant now);
  void tell(DriverEvent::Kind kind, const Error& error = {});

  LscProfile profile_;
  LscUnits units_;
  LscTiming timing_;

  Phase phase_ = Phase::kClosed;
  std::optional<Error> fault_;
  bool told_silent_ = false;  ///< of this doubt, or of this open()
  bool declared_ = false;
  Instant now_{};  ///< of the last call

  std::array<Slot, kMaxJoints> slots_;
  FixedVector<JointPosition, kMaxJoints> positions_;
  Segment current_;
  std::optional<Segment> next_;
  Instant repair_at_{};
  int pending_ = 0;  ///< commands without their last event
  bool stopping_ = false;
  bool stop_due_ = false;  ///< its frame has not been sent
  bool creeping_ = false;  ///< a stop of a move from nobody knows where
  std::optional<Instant> goes_on_until_;
  int confirms_left_ = 0;
  int rewrites_left_ = 0;
  Instant phase_due_{};  ///< of kQuiet, kConfirming, kSettling
  Instant quiet_since_{};

  Question question_ = Question::kNone;
  Instant question_due_{};
  int tries_left_ = 0;
  Instant health_due_{};
  std::optional<Units> reading_;  ///< the first of two that must agree
  int readings_left_ = 0;
  int low_readings_ = 0;
  int empty_readings_ = 0;
  Instant volts_at_{};
  std::size_t boot_matched_ = 0;
  int kind_silences_ = 0;  ///< lsc6: of the question that only a bus board answers

  bool free_ = false;  ///< its joints were let go of
  int unloads_left_ = 0;
  Instant hand_due_{};
  Instant hand_at_{};                            ///< of the last reading meanwhile
  std::array<double, kMaxJoints> hand_speed_{};  ///< rad/s, between the last two

  DriverHealth health_;
  LscFacts facts_;
  lsc::FrameDecoder decoder_;
  lsc::Bytes output_;
  bool output_begun_ = false;
  bool output_moves_ = false;  ///< it is a frame of targets
  Instant output_since_{};
  Instant wire_free_{};  ///< when all bytes are through
  FixedVector<DriverEvent, 16> events_;
};

}  // namespace sinew
