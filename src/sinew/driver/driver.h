#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/driver/device_facts.h"
#include "sinew/model/robot_model.h"
#include "sinew/model/tool_action.h"
#include "sinew/wire/spi.h"

namespace sinew {

/// How well a joint's position is known; the same four words wherever it is shown.
enum class PositionQuality : std::uint8_t {
  kLost,       ///< nobody knows
  kUncertain,  ///< somewhere in [lower, upper]
  kCommanded,  ///< the device was told, and nothing says that it did not go there
  kMeasured,   ///< a sensor says so
};

/// Joint position as the host knows it, in the model's frame; rad, or m for a leg.
struct JointPosition {
  PositionQuality quality = PositionQuality::kLost;
  double q = 0;  ///< best guess; without meaning while lost
  /// The truth is in [lower, upper]: kUncertain as far as is known, else q -+ what wire and device
  /// leave open (resolution, dead band, sag). Without meaning while lost.
  double lower = 0;
  double upper = 0;
  /// What ties the device's own count to the joint: the joint's position where the device counts 0.
  /// Nothing where the device keeps no count, or the tie is not known for sure. Known also for lost
  /// joints; the journal keeps it for the next process.
  std::optional<double> count_zero = std::nullopt;
  /// It moves, and the interval is of its place along what was sent. Else the interval is open
  /// about all of it: what is sent next begins and ends off by as much.
  bool under_way = false;
};

/// Where the truth may be, ends included; rad, or m of a leg.
struct JointInterval {
  double lower = 0;
  double upper = 0;
  friend bool operator==(const JointInterval&, const JointInterval&) = default;
};

/// @rt
inline bool covers(const JointInterval& outer, const JointInterval& inner) {
  return outer.lower <= inner.lower && inner.upper <= outer.upper;
}

/// What only one kind of device can be asked for, by a person.
enum class DeviceService : std::uint8_t {
  kWake,      ///< its motor modules, from a shutdown of their own
  kShutDown,  ///< the whole controller, until its power is cut
  kSelfTest,  ///< each board of itself; where it is homed its motor turns a full step and back
  kFree,      ///< the joints' motors off, so that the arm can be guided by hand
  kHold,      ///< the joints' motors on, where each joint is
};

/// Joints as a bit each.
inline constexpr std::uint8_t kAllJoints = 0xFF;

/// One piece of motion. For a point-to-point device it is a whole move; for a streaming one it is
/// the way from the last segment's end to `q`, in `duration`.
struct JointMove {
  JointVector q;        ///< where it ends; rad or m, model's frame, every joint
  JointVector qd;       ///< speed there, per s; all zero at the end of a motion
  Duration duration{};  ///< how long it shall (stream) or is predicted to take (point to point)
  /// Where the machine was taken to stand when this was planned; empty where nobody planned, and
  /// behind a segment that is still under way. Who measures refuses it elsewhere (kMovedUnasked).
  JointVector q_start{};
};

/// Where a driver is in its life.
enum class DriverState : std::uint8_t {
  kClosed,   ///< no port
  kOpening,  ///< finding the device, or finding it again after a doubt
  kReady,    ///< answers, at rest, takes commands
  kMoving,
  kStopping,
  kFault,  ///< will not move before clear_fault(); fault() says why
};

/// What happened. Each command that was accepted ends with exactly one kDone, kFailed or kStopped.
struct DriverEvent {
  enum class Kind : std::uint8_t {
    kReady,    ///< opened, or recovered after a doubt: positions() are fresh
    kDone,     ///< the command is carried out
    kFailed,   ///< it is not, or nobody knows; positions() say what is left of the position
    kStopped,  ///< stop() has taken effect, as far as this wire can
    kNotice,   ///< nothing is under way that it could have broken; for the record
  } kind = Kind::kNotice;
  Error error;  ///< kFailed and kNotice
};

/// What can be told of a device's well-being.
struct DriverHealth {
  std::optional<double> supply_volts = {};
  std::optional<double> temperature_c = {};
  /// m between the jaws, as measured since they last moved: wider than they were sent, and they
  /// hold something.
  std::optional<double> jaws_width = {};
  std::uint64_t requests = 0;    ///< exchanges begun
  std::uint64_t retries = 0;     ///< exchanges begun again, where that cannot move anything twice
  std::uint64_t repeats = 0;     ///< frames said again as planned, where a wire has no checksum
  std::uint64_t timeouts = 0;    ///< answers that never came
  std::uint64_t unexpected = 0;  ///< bytes or answers that fit nothing
};

/// What the run before left on record beside the positions that are declared before open().
struct DriverMemory {
  /// The host died in a motion: a device that finishes motions by itself may stand at its end.
  bool ended_in_motion = false;
  /// The host's own stop is latched in the device, unless somebody released it since.
  bool held_by_stop = false;
  /// Joints, a bit each, whose counter in the device was away from where a power-up puts it.
  std::uint8_t counted = 0;
  /// Since the last record of that run, as far as the clock of this computer tells.
  Duration since{};
};

/// Host side of one wire: joint units to device units and back, time-outs, bounded retries that
/// can never carry out a move twice, resynchronisation. No clock and no port: bytes and Instants
/// come in, bytes and events go out. Instants never run back. All members are @rt.
class Driver {
 public:
  virtual ~Driver() = default;

  /// The port is open. kReady (or kFailed) follows.
  virtual void open(Instant now) = 0;
  /// The port went away. A command under way ends with kFailed (kPortClosed).
  virtual void close(Instant now) = 0;

  virtual DriverState state() const = 0;
  /// Why the state is kFault.
  virtual std::optional<Error> fault() const { return std::nullopt; }
  /// One per joint.
  virtual std::span<const JointPosition> positions() const = 0;
  /// Until when the machine may go on moving although nobody wants it to: a motion that the wire
  /// cannot end (kStopping), that was under way when the port opened (kOpening), or that nobody was
  /// left to end. Waits for the device count from there. Nothing where it stands.
  virtual std::optional<Instant> goes_on_until() const { return std::nullopt; }
  /// Where the device's own counters or registers place a joint, also while it is lost: evidence
  /// against which a declaration is held. Nothing where they say nothing.
  virtual std::optional<JointInterval> counted(std::size_t joint) const {
    static_cast<void>(joint);
    return std::nullopt;
  }
  virtual DriverHealth health() const = 0;
  /// What the device has told of itself last, and when, for whoever looks on.
  virtual DeviceFacts facts() const { return {}; }

  /// True where move() would take a piece of motion now. A streaming driver takes the next segment
  /// while the last one is still under way, early enough that there is no gap.
  virtual bool wants_move(Instant now) const = 0;

  /// @error kBusy, kPositionUnknown, kMovedUnasked (index, rad), kFault's own code, kJointLimit, or
  ///        what this wire cannot say (kPulseRange, kStepRange, kUnsendable, kSegmentTime). Nothing
  ///        is sent then.
  virtual Expected<void> move(const JointMove& move, Instant now) = 0;

  /// Moves one joint by a little from wherever it is, also while nobody knows where that is; what
  /// was known of it moves along. kDone follows.
  /// @param way  rad or m; goes to the nearest whole unit of the device
  /// @error kTaskNotSupported (this wire moves to places only), kBusy, fault's own, kNudgeRange
  ///        (less than a unit, or more than the driver's bound), kLegLength
  virtual Expected<void> nudge(std::size_t joint, double way, Duration duration, Instant now);

  /// nudge() that ends where the device's probe input closes, if it does on the way; kDone follows
  /// in both cases, and facts() say which it was.
  /// @error nudge()'s, and those of may_probe()
  virtual Expected<void> probe(std::size_t joint, double way, Duration duration, Instant now);

  /// @error kNoProbe (it has no such input), kProbeClosed (it is closed already)
  virtual Expected<void> may_probe() const;

  /// No further motion, as soon as the wire and the device can; kStopped follows. Always accepted.
  virtual void stop(Instant now) = 0;

  /// It is about to ask its device, or asks it, what that forgets by telling: whether its supply
  /// has held. Who dies between the answer and a record of it leaves nobody who knows.
  virtual bool looks() const { return false; }
  /// Such a question waits while it may not be asked, in vain for a bounded time (kNotRecorded);
  /// from the beginning it may.
  virtual void allow_looks(bool allowed) { static_cast<void>(allowed); }

  /// Finds the zeros of these joints, a bit each, where the machine can.
  /// @error kTaskNotSupported, kBusy
  virtual Expected<void> home(Instant now, std::uint8_t joints = kAllJoints);
  /// The joint whose zero is being searched for; nothing where none is.
  virtual std::optional<std::size_t> homing_joint() const { return std::nullopt; }
  /// Leaves kFault once its cause is gone; never resumes a motion. @error kBusy, or the cause
  virtual Expected<void> clear_fault(Instant now) {
    static_cast<void>(now);
    return {};
  }
  /// @error kToolNotFitted, kGripperRange, kBusy
  virtual Expected<void> tool(const ToolAction& action, Instant now);
  /// clear_fault() is still under way in the device; kDone or kFailed follows.
  virtual bool clearing() const { return false; }
  /// What the host knows from elsewhere (a journal, the user's declaration): one per joint.
  virtual void declare_positions(std::span<const JointPosition> positions) {
    static_cast<void>(positions);
  }
  /// What the positions that are declared before open() are worth.
  virtual void remember(const DriverMemory& memory) { static_cast<void>(memory); }
  /// A stop that this host set, in this run or an earlier one, is latched in the device.
  virtual bool held_by_stop() const { return false; }
  /// Joints, a bit each, whose counter in the device is away from where a power-up puts it: the
  /// next run sees by them whether the power was away.
  virtual std::uint8_t counters_moved() const { return 0; }
  /// The device counts 0 where it stands from now on; the positions stay. kDone follows.
  /// @error kNoSuchService, kBusy, fault's own
  virtual Expected<void> zero_counters(Instant now);

  /// The joints' motors are off: they turn by hand, and fall by their weight. Positions are
  /// measured all the same.
  virtual bool free() const { return false; }
  /// kDone follows, or kFailed with what a self-test found.
  /// @error kNoSuchService, kBusy, fault's own
  virtual Expected<void> service(DeviceService what, Instant now);

  /// Time passes.
  virtual void poll(Instant now) = 0;
  /// When poll() has something to do next.
  virtual std::optional<Instant> next_deadline() const = 0;
  virtual std::optional<DriverEvent> take_event() = 0;
};

/// A driver over a stream of bytes.
class ByteDriver : public Driver {
 public:
  virtual void receive(std::span<const std::uint8_t> bytes, Instant now) = 0;
  /// Moves bytes for the device out; how many. What is taken counts as sent.
  virtual std::size_t take_output(std::span<std::uint8_t> out) = 0;
};

/// A driver over framed exchanges.
class SpiDriver : public Driver {
 public:
  /// The exchange that is due at `now`, if any; exchanged() follows before the next one.
  virtual std::optional<spi::Transfer> take_transfer(Instant now) = 0;
  /// @param miso  as many bytes as the transfer had. @param now  when its last bit was through.
  virtual void exchanged(std::span<const std::uint8_t> miso, Instant now) = 0;
};

}  // namespace sinew
