#pragma once

#include <array>
#include <optional>
#include <span>

#include "sinew/core/cubic.h"
#include "sinew/core/units.h"
#include "sinew/devices/arm_link/arm_link_driver_channel.h"
#include "sinew/devices/arm_link/arm_link_driver_facts.h"
#include "sinew/devices/arm_link/arm_link_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_positions.h"
#include "sinew/driver/driver_commands.h"
#include "sinew/driver/motion_segments.h"

namespace sinew {

struct ArmLinkTiming {
  arm_link::Channel::Timing wire;
  /// Between questions at rest, and in motion where there is nothing to send.
  Duration resting_poll = std::chrono::milliseconds(50);
  Duration moving_poll = std::chrono::milliseconds(10);
  Duration ahead = std::chrono::milliseconds(120);   ///< of a stream, that the board shall have
  Duration opening_limit = std::chrono::seconds(8);  ///< boot loaders listen for some 2 s
  Duration said = std::chrono::seconds(1);           ///< at rest, until it is said; say_due_
  Duration statistics = std::chrono::seconds(1);     ///< between questions for them, at rest
};

/// Host side of the arm link (docs/wires/arm_link.md): a motion goes ahead of time, in segments,
/// and the board's own clock says when each is over.
///
///   activity  | what happens                                  | next
///   ----------+-----------------------------------------------+-----------------------------------
///   kClosed   | open                                          | kOpening
///   kOpening  | hello is replied to, the arm stands           | kIdle, kReady
///   kOpening  | its stop line is low                          | kIdle with the fault, kFailed
///   kIdle     | move, nudge                                   | kMoving
///   kMoving   | a segment is over                             | kMoving, kDone
///   kMoving   | the last one is, and the arm stands           | kIdle, kDone
///   kMoving   | the board has stopped it                      | kStopping, kFailed
///   kIdle     | tool, zero_counters                           | kAsking, then kIdle, kDone
///   any open  | stop                                          | kStopping, then kIdle, kStopped
///   any open  | no reply, another session                     | kOpening, kFailed
///   any       | close                                         | kClosed, kFailed
///
/// positions(): BigRobotArmPositions, and in motion where the board's planned pulses end. All @rt.
class ArmLinkDriver : public ByteDriver {
 public:
  /// @param joints  five: limits that no segment exceeds, and what the arm brakes with
  ArmLinkDriver(const ArmLinkDevice& device, std::span<const Joint> joints,
                const ArmLinkTiming& timing = {});

  void open(Instant now) override;
  void close(Instant now) override;
  DriverState state() const override;
  std::optional<Error> fault() const override { return fault_; }
  std::span<const JointPosition> positions() const override { return shown_; }
  std::optional<Instant> goes_on_until() const override;
  std::optional<JointInterval> counted(std::size_t joint) const override {
    return belief_.counted(joint);
  }
  DriverHealth health() const override;
  DeviceFacts facts() const override;
  bool wants_move(Instant now) const override;
  /// @error the contract's, kUnsendable (number of joints, a speed that is no number), kJointLimit,
  ///        kSegmentTime, kAccelerationLimit
  Expected<void> move(const JointMove& move, Instant now) override;
  /// Counted from where the board counts it.
  Expected<void> nudge(std::size_t joint, double way, Duration duration, Instant now) override;
  void stop(Instant now) override;
  Expected<void> clear_fault(Instant now) override;
  bool clearing() const override { return clearing_; }
  /// GripperTo. @error kToolNotFitted, kGripperRange, kBusy, kPortClosed, the fault
  Expected<void> tool(const ToolAction& action, Instant now) override;
  void declare_positions(std::span<const JointPosition> positions) override;
  Expected<void> zero_counters(Instant now) override;
  void poll(Instant now) override;
  std::optional<Instant> next_deadline() const override;
  std::optional<DriverEvent> take_event() override { return commands_.take(); }
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override {
    return channel_.take_output(out);
  }
  bool wants_declaration() const { return belief_.unknown().has_value(); }

 private:
  enum class Activity : std::uint8_t { kClosed, kOpening, kIdle, kMoving, kAsking, kStopping };
  /// What an opening waits for.
  enum class Step : std::uint8_t { kHello, kRest, kRelease };
  /// Of a segment that was asked for: its end, and where it goes, rad, and how fast, rad/s.
  struct End {
    Duration at{};  ///< since the stream began
    std::array<JointInterval, kBigRobotArmJoints> way{};
    std::array<double, kBigRobotArmJoints> peak{};
  };
  /// One joint, wherever it is.
  struct Nudge {
    std::size_t joint = 0;
    Cubic way;  ///< 2^-8 step
  };
  using Request = arm_link::Request;
  using Reply = arm_link::Reply;
  using Words = bigrobotarm::Words;
  static constexpr std::size_t kPieces = 2;
  static constexpr int kPieceMs = 20;
  static constexpr int kAsksMax = 5;  ///< of one thing that the board does not carry out

  Expected<void> may_begin() const;
  void say_hello(Instant now);
  void ask_next(Instant now);
  void take(const arm_link::Channel::Answered& answered, Instant now);
  void take_opening(const arm_link::Channel::Answered& answered);
  void judge(const Reply& reply);
  void become_ready();
  void take_motion(const arm_link::Channel::Answered& answered);
  void take_facts(const arm_link::Reply& reply);
  void take_asking(const arm_link::Channel::Answered& answered);
  void take_stopping(const arm_link::Channel::Answered& answered);
  std::optional<Error> too_harsh(const JointMove& move) const;
  void add_end(Duration at, const std::array<Cubic, kBigRobotArmJoints>& pieces);
  void begin_motion();
  void begin_stop();
  void ask(arm_link::Kind kind);
  Expected<void> begin_asking(Instant now);
  void begin_anew(const Error& why, Instant now);
  std::array<JointInterval, kBigRobotArmJoints> reach() const;
  void leave_motion();
  bool asked_again(const arm_link::Channel::Answered& answered);
  Duration braking() const;
  void come_to_rest(const Reply& reply);
  void make_pieces();
  double units_of(std::size_t joint, double q) const;
  double angle_of(std::size_t joint, std::int32_t units) const;
  mcu::ArmSegment piece_to(int ms, bool last) const;
  void show();

  ArmLinkDevice device_;
  FixedVector<Joint, kMaxJoints> joints_;
  ArmLinkTiming timing_;
  arm_link::Channel channel_;
  BigRobotArmPositions belief_;
  std::array<JointPosition, kBigRobotArmJoints> shown_;

  Activity activity_ = Activity::kClosed;
  std::optional<Error> fault_;
  DriverCommands commands_;
  bool clearing_ = false;
  bool told_silent_ = false;
  Instant now_{};
  Instant opened_at_{};
  Instant poll_due_{};
  ArmLinkFacts facts_{};
  Instant statistics_due_{};

  Step step_ = Step::kHello;  ///< of an opening
  std::optional<Instant> goes_on_until_;
  std::optional<Request> due_;  ///< goes before anything else but a stop
  bool stop_due_ = false;
  int asks_left_ = 0;
  /// The board keeps that a host has seen its counters: behind a loss of power it has not. Said
  /// once what they mean is recorded: before the first motion, which waits for that, or at rest
  /// later.
  std::optional<Instant> say_due_;

  // Motion. Times of the stream are since it began.
  segments::SegmentQueue queue_;  ///< what is not made into pieces yet
  std::optional<Nudge> nudge_;
  FixedVector<mcu::ArmSegment, kPieces> pieces_;  ///< not carried out yet
  FixedVector<End, 16> ends_;                     ///< of the segments that were asked for
  Duration stream_{};                             ///< where the last segment ends
  int made_ms_ = 0;                               ///< where the last piece ends
  int sent_ms_ = 0;                               ///< where the last one carried out ends
  bool rests_ = true;                             ///< the last segment ends at rest
  std::array<segments::Setpoint, kBigRobotArmJoints> target_{};
  std::array<JointPosition, kBigRobotArmJoints> rest_;          ///< as shown before the motion
  std::array<JointInterval, kBigRobotArmJoints> stop_reach_{};  ///< of the stop under way
  /// Where the arm may be behind a motion that was lost sight of, until the board counts again.
  std::optional<std::array<JointPosition, kBigRobotArmJoints>> left_;
};

}  // namespace sinew
