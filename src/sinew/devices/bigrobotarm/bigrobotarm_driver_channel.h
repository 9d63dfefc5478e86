#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_multipliers.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_text.h"
#include "sinew/model/device.h"

namespace sinew {

using BigRobotArmAngles = std::array<double, bigrobotarm::kJoints>;  // rad, model's sign

struct BigRobotArmChannelTiming {
  Duration reply_timeout = std::chrono::milliseconds(500);  ///< also until a motion is taken up
  Duration quiet = std::chrono::milliseconds(100);          ///< silence that ends a doubt
  Duration quiet_limit = std::chrono::seconds(5);  ///< a line that talks on for so long is told
  double move_factor = 1.5;                        ///< of the expected duration, and
  Duration move_margin = std::chrono::seconds(2);  ///< this on top: the device is slower than
                                                   ///< its own profile where many joints step
};

/// The dialogue below BigRobotArmDriver, for both wires: rad to microsteps and back, one command at
/// a time, every answer checked against what was asked. It has no clock and no port: bytes and
/// Instants come in, bytes and events go out.
///
///   state    | what happens                           | next
///   ---------+----------------------------------------+----------------------------------
///   kClosed  | open                                   | kQuiet
///   kQuiet   | a byte comes                           | kQuiet, the pause starts again
///   kQuiet   | `quiet` without a byte                 | kVerify, a status is asked for
///   kVerify  | the status comes                       | kIdle, StatusRead
///   kVerify  | it comes after unanswered questions    | kQuiet: others may follow
///   kVerify  | anything else, or nothing              | kQuiet
///   kIdle    | a command                              | kAsked
///   kIdle    | a byte nobody asked for                | kQuiet, Failed
///   kAsked   | the right answer                       | kIdle, Done or StatusRead
///   kAsked   | a motion is taken up                   | kMoving, Started
///   kMoving  | the motion's answer                    | kIdle, Done
///   kAsked,  | garbage, a wrong answer, a wrong value,| kQuiet, Failed
///   kMoving  | or nothing in time                     |
///   any      | close                                  | kClosed, Failed
///
/// A doubt is told once (Failed) and ends with StatusRead; until then every command is kBusy. The
/// device has no stop: a motion that it took up ends where it was sent. All members are @rt.
class BigRobotArmChannel {
 public:
  enum class State : std::uint8_t { kClosed, kQuiet, kVerify, kIdle, kAsked, kMoving };

  struct Started {};
  struct Done {
    bigrobotarm::RequestId request{};
    BigRobotArmAngles q{};  ///< rad, the last positions that the device reported: its targets
  };
  struct StatusRead {
    BigRobotArmAngles q{};
    bigrobotarm::Status status;
    bool after_doubt = false;  ///< not asked for: the driver opened or recovered
    /// All values are those of power-up: the board may have been reset, and its zero moved.
    /// It was silent for kDeafAsks questions and more, after bytes that nobody asked for: it may
    /// have made a motion that noise had ordered.
    bool was_deaf = false;
  };
  struct Failed {
    Error error;
  };
  using Event = std::variant<Started, Done, StatusRead, Failed>;

  static constexpr int kDeafAsks = 3;  ///< 2.2 s with the usual timing

  explicit BigRobotArmChannel(const BigRobotArmDevice& device,
                              const BigRobotArmChannelTiming& timing = {});

  /// The port is open: waits for quiet, then reads the status.
  void open(Instant now);
  /// The port went away.
  void close();

  /// Model position of the device's zero, rad: after a reset of the board the host knows better
  /// than its counters.
  void set_offset(const BigRobotArmAngles& offset) { offset_ = offset; }
  const BigRobotArmAngles& offset() const { return offset_; }

  /// The commands. Done (StatusRead for read_status) or Failed follows.
  /// @error kBusy: a command is under way, or a doubt, or the port is closed. Nothing is sent.
  Expected<void> read_status(Instant now);

  /// @param q         target, rad; goes to the nearest step, or on the byte wire, where that step
  ///                  would be cut, to the nearer of its neighbours (Done tells where).
  /// @param expected  how long the caller predicts the motion to take.
  /// @error kStepRange (index, steps, the largest that the device reports rightly),
  ///        kUnsendable (index, steps: neither it nor a neighbour), kBusy
  Expected<void> move_to(const BigRobotArmAngles& q, Duration expected, Instant now);

  /// @error kMultiplierRange, kUnsendable (index), kBusy
  Expected<void> set_speeds(const bigrobotarm::Words& multipliers, Instant now);
  Expected<void> set_accelerations(const bigrobotarm::Words& multipliers, Instant now);

  /// @param position  degrees of the gripper's servo; it jumps there, and only when enabled.
  /// @error kGripperRange (position, gripper_max), kUnsendable (13 on the byte wire), kBusy
  Expected<void> set_gripper(bool enabled, std::int32_t position, Instant now);

  /// The device's zero moves to where it stands; the offset moves along, so that q stays.
  Expected<void> reset_positions(Instant now);

  /// The device's own sync mode off; nothing switches it on. @error kBusy
  Expected<void> leave_sync(Instant now);

  /// Where move_to() would send the motors. @error kStepRange, kUnsendable, as move_to()
  Expected<bigrobotarm::Words> steps_of(const BigRobotArmAngles& q) const;
  /// Where the model is when the device reports `steps`.
  BigRobotArmAngles angles_of(const bigrobotarm::Words& steps) const;
  /// Whether the device is set up as at power-up: it may have been reset, and its zero moved.
  BigRobotArmStart start_in(const bigrobotarm::Status& status) const;

  /// Takes a command back that has not begun to leave. @return whether there was one
  bool withdraw();

  /// Bytes from the port; takes events out after each call (there is room for 16).
  void receive(std::span<const std::uint8_t> bytes, Instant now);
  /// Time passes.
  void poll(Instant now);
  /// When poll has something to do next.
  std::optional<Instant> next_deadline() const { return deadline_; }

  std::size_t take_output(std::span<std::uint8_t> out);
  std::optional<Event> take_event();

  State state() const { return state_; }
  /// Bytes that nobody asked for, and answers that fit nothing.
  std::uint64_t unexpected() const { return unexpected_; }

 private:
  using Words = bigrobotarm::Words;

  Expected<void> ask(const bigrobotarm::Request& request, Instant now);
  void send(const bigrobotarm::Request& request);
  std::optional<std::expected<bigrobotarm::Reply, bigrobotarm::Garbage>> decode(std::uint8_t byte);
  void take_unexpected();
  void take_reply(const bigrobotarm::Reply& reply, Instant now);
  void take_status(const bigrobotarm::Status& status, Instant now);
  std::optional<Error> check(const bigrobotarm::Reply& reply) const;
  void doubt(const Error& error, Instant now);
  void tell(const Event& event);

  BigRobotArmDevice device_;
  BigRobotArmChannelTiming timing_;
  BigRobotArmAngles offset_{};

  State state_ = State::kClosed;
  bigrobotarm::Request asked_;
  Instant asked_at_{};
  Duration expected_{};  ///< of the motion under way
  std::optional<Instant> deadline_;
  Instant quiet_since_{};  ///< when the doubt began
  bool doubt_told_ = false;
  std::uint64_t unexpected_ = 0;
  int silent_asks_ = 0;  ///< statuses asked for in a row without an answer
  bool noise_ = false;   ///< unasked bytes since the last good status
  bool deaf_ = false;    ///< and then a long silence
  Words positions_{};    ///< as last reported

  bigrobotarm::byte::ReplyDecoder byte_decoder_;
  bigrobotarm::text::ReplyDecoder text_decoder_;
  FixedVector<std::uint8_t, 128> output_;
  bool output_begun_ = false;  ///< some of the request has left
  FixedVector<Event, 16> events_;
};

}  // namespace sinew
