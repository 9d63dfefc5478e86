#pragma once

#include <array>
#include <optional>
#include <span>

#include "sinew/core/units.h"
#include "sinew/devices/axis_link/axis_link_driver_channel.h"
#include "sinew/devices/axis_link/axis_link_driver_facts.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/driver/driver.h"
#include "sinew/driver/motion_segments.h"
#include "sinew/model/device.h"

namespace sinew {

struct AxisLinkTiming {
  /// From one frame of an axis to its next; where the wire needs longer, it takes longer.
  Duration cycle = std::chrono::milliseconds(1);
  /// From the chip select to the first clock: the axis loads its answer.
  Duration select_setup = std::chrono::microseconds(10);
  int failures_max = 8;                             ///< frames in a row, then the axis is out
  Duration retry = std::chrono::milliseconds(20);   ///< between frames to an axis that is out
  Duration open_timeout = std::chrono::seconds(1);  ///< until an axis must have answered
  /// After the end of a motion. An axis that fell behind comes back inside its limits, and the
  /// documented ones of robot-arm-2 are slow: half a degree takes it 2.4 s.
  Duration settle_timeout = std::chrono::seconds(5);
  double settle_tolerance = from_deg(0.5);                  ///< rad, of the measured position then
  Duration homing_timeout = std::chrono::minutes(10);       ///< one axis; it has its own besides
  Duration test_timeout = std::chrono::seconds(5);          ///< one axis
  Duration stop_margin = std::chrono::seconds(1);           ///< beyond the time that braking needs
  Duration health_period = std::chrono::milliseconds(500);  ///< at rest only
};

/// Host side of the axis link: one frame per axis and cycle, round robin, and the whole motion as
/// setpoints. docs/wires/axis_link.md has the wire and what it can lose.
///
///   activity  | what happens                           | next
///   ----------+----------------------------------------+--------------------------------------
///   kClosed   | open                                   | kOpening
///   kOpening  | every axis is up or out, one is up     | kIdle, kReady (clear_fault: kDone)
///   kOpening  | every axis is out                      | kIdle with the fault, kFailed
///   kIdle     | move                                   | kMoving
///   kIdle     | every axis is out                      | kIdle with the fault, kFailed
///   kMoving   | a segment is over, the next is there   | kMoving, kDone
///   kMoving   | the last one ended at rest, all settled| kIdle, kDone
///   kMoving   | the last one did not end at rest       | kStopping, kFailed (kSegmentTime)
///   kMoving,  | an axis is out, refuses, or does not   | kStopping with the fault, kFailed
///   kHoming,  | arrive                                 |
///   kTesting  |                                        |
///   kIdle     | home                                   | kHoming
///   kHoming   | each axis in turn is homed             | kIdle, kDone
///   kIdle     | service(kSelfTest)                     | kTesting
///   kTesting  | each axis in turn stands behind its own| kIdle, kDone
///   any       | stop                                   | kStopping
///   kStopping | every axis that answers stands, others | kIdle, kStopped
///             | had their deadline and time to brake   |
///   any       | close                                  | kClosed, kFailed
///
/// stop() is a frame to all axes in the next transfer, then one to each until it says that it has
/// executed it. Setpoints are absolute, commands go out under one number until they are executed:
/// nothing that is sent twice moves twice.
///
/// An axis that gives no fresh answer to `failures_max` frames in a row, or tells of a fault, is
/// out: axis_fault() says why, kNotice tells it at rest. The others go on; move() takes targets
/// that leave an axis that is out where positions() shows it. clear_fault() brings it back; so does
/// open() with one that had stopped by itself when a host before fell silent, and kNotice tells.
///
/// An axis that is left out by choice (model/left_out.h) is never selected: its joint stays kLost,
/// and what a move says of it counts for nothing.
///
/// positions(): kMeasured once an axis is homed, as it was when its last frame began: the motor's
/// encoder, -+ all that the axis says may lie between that and the joint, and the way that it goes
/// while a reading ages; kUncertain while its answers fail, over all that it can have gone since;
/// kLost before homing, after a restart, and when it was silent for its deadline and the time that
/// braking takes. All @rt.
class AxisLinkDriver : public SpiDriver {
 public:
  /// @param joints  one per board, within +-32 rad.
  AxisLinkDriver(const AxisLinkDevice& device, std::span<const Joint> joints,
                 const AxisLinkTiming& timing = {});

  void open(Instant now) override;
  void close(Instant now) override;
  DriverState state() const override;
  std::optional<Error> fault() const override { return fault_; }
  std::span<const JointPosition> positions() const override { return positions_; }
  /// Until its boards have braked, or their deadline has stopped them.
  std::optional<Instant> goes_on_until() const override;
  DriverHealth health() const override;
  DeviceFacts facts() const override;
  bool wants_move(Instant now) const override;

  /// @error kPortClosed, the fault, kBusy, kPositionUnknown, kUnsendable (number of joints, a speed
  ///        that is no number), kJointLimit, kSegmentTime, or the fault of an axis that is out
  Expected<void> move(const JointMove& move, Instant now) override;
  void stop(Instant now) override;
  /// As stop(), but the axes freeze at once and stay latched. Never sent by itself.
  void emergency_stop(Instant now);
  /// In the order of the joints, one after the other; nothing moves where an axis is out.
  /// @error kPortClosed, the fault, kBusy, or the fault of an axis that is out
  Expected<void> home(Instant now, std::uint8_t joints = kAllJoints) override;
  std::optional<std::size_t> homing_joint() const override {
    const bool searching = activity_ == Activity::kHoming && homing_place_ < joints_.size();
    return searching ? std::optional<std::size_t>(homing_order_[homing_place_]) : std::nullopt;
  }
  /// kSelfTest: the axes one after the other, in the order of homing; nothing moves where one is
  /// out. @error kNoSuchService, kPortClosed, the fault, kBusy, or the fault of an axis that is out
  Expected<void> service(DeviceService what, Instant now) override;
  /// Every axis that is out gets a new session, its latch released and its faults cleared; kDone
  /// follows where one axis is fit to move. @error kPortClosed, kBusy
  Expected<void> clear_fault(Instant now) override;
  bool clearing() const override { return clearing_; }

  void poll(Instant now) override;
  std::optional<Instant> next_deadline() const override;
  std::optional<DriverEvent> take_event() override;

  std::optional<spi::Transfer> take_transfer(Instant now) override;
  void exchanged(std::span<const std::uint8_t> miso, Instant now) override;

  /// Why an axis is out. @pre joint < joints
  std::optional<Error> axis_fault(std::size_t joint) const { return channels_[joint].error(); }
  /// By how much the joint's last search for its zero differs from the one before it, rad; nothing
  /// where there was none before it in this session. @pre joint < joints
  std::optional<double> zero_shift(std::size_t joint) const {
    return channels_[joint].zero_shift();
  }
  /// As the axis last reported it; nothing where it did not yet.
  std::optional<axis_link::Health> axis_health(std::size_t joint) const {
    return channels_[joint].health();
  }
  /// From one frame of an axis to its next, as it was last.
  Duration round_time() const { return round_; }

 private:
  enum class Activity : std::uint8_t {
    kClosed,
    kOpening,
    kIdle,
    kMoving,
    kHoming,
    kTesting,
    kStopping
  };
  enum class Flight : std::uint8_t { kNone, kToAll, kToOne };

  bool is_out_by_choice(std::size_t i) const { return (left_out_ >> i & 1U) != 0; }
  Expected<void> may_begin() const;
  Expected<void> check_axes(const JointMove& move) const;
  bool next_axis(Instant now);
  spi::Transfer transfer_to(std::uint8_t select, const axis_link::Frame& frame) const;
  void begin_stop(axis_link::Mode mode, Instant now);
  void end_commands(DriverEvent::Kind kind, const Error& error = {});
  void fail(const Error& error, Instant now);
  void step(Instant now);
  void step_opening(Instant now);
  void step_idle(Instant now);
  void step_moving(Instant now);
  void step_settling(Instant now);
  void begin_turns(Activity activity, std::uint8_t joints, Instant now);
  void take_turn(std::size_t place);
  void step_turns(Instant now);
  void step_stopping(Instant now);
  void note_outs();
  std::optional<Error> first_new_out();
  bool any_up() const;
  Error why_all_are_out() const;
  void update_positions(Instant now);
  void tell(DriverEvent::Kind kind, const Error& error = {});

  FixedVector<axis_link::Channel, kMaxJoints> channels_;
  FixedVector<Joint, kMaxJoints> joints_;
  std::uint8_t left_out_ = 0;  ///< axes, a bit each
  std::uint32_t clock_hz_;
  Duration deadline_;
  AxisLinkTiming timing_;

  Activity activity_ = Activity::kClosed;
  std::optional<Error> fault_;
  FixedVector<JointPosition, kMaxJoints> positions_;
  std::array<bool, kMaxJoints> known_out_{};  ///< told of already
  Instant now_;
  Instant since_;            ///< when the activity, or its present part, began
  std::size_t pending_ = 0;  ///< commands that were accepted and have no event yet
  bool clearing_ = false;    ///< kOpening is a clear_fault()

  // Frames.
  Flight flight_ = Flight::kNone;
  std::optional<axis_link::Mode> to_all_due_;
  std::size_t axis_ = 0;  ///< whose frame is next, or under way
  Instant round_began_;
  Instant round_due_;
  Instant outs_due_;
  bool serve_outs_ = false;
  Duration round_{};
  Duration ahead_{};  ///< from now to a setpoint: the rounds, evened out
  Instant health_due_;
  std::size_t healths_asked_ = 0;  ///< up to one each axis: those are asked for at once
  std::size_t health_axis_ = 0;
  std::uint64_t requests_ = 0;

  // Motion.
  segments::SegmentQueue queue_;
  std::array<std::optional<double>, kMaxJoints> told_;  ///< where an axis was sent last, at rest
  bool settling_ = false;
  std::array<std::uint16_t, kMaxJoints> settle_from_{};  ///< frames beyond say the final setpoint
  // Homing and self-tests: one axis after the other.
  FixedVector<std::uint8_t, kMaxJoints> homing_order_;
  std::size_t homing_place_ = 0;  ///< in the order
  std::uint8_t takes_turn_ = kAllJoints;
  // Stopping.
  bool stop_asked_ = false;
  bool stop_in_opening_ = false;
  Duration run_out_{};  ///< of the slowest axis

  FixedVector<DriverEvent, 32> events_;
};

}  // namespace sinew
