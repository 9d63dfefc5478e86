#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/devices/axis_link/axis_link_driver_facts.h"
#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/driver/driver.h"
#include "sinew/driver/motion_segments.h"

namespace sinew::axis_link {

struct ChannelSettings {
  std::uint8_t axis = 0;
  Joint joint;
  Duration deadline = kDeadlineDefault;
  int failures_max = 8;  ///< frames in a row without a fresh answer
};

/// Host side of one axis: which frame is next, and what an answer is worth.
///
/// An answer counts where it names the frame before it as the last one executed: that proves at
/// once that the axis heard us and that the answer is not an old one. A board whose loop is slower
/// than our frames names an earlier one: that answer is late, and is as old as the frame it names.
/// One that names none of the last frames, or the same one for longer than kLateMax, and whatever
/// else comes (bad checksum, another axis, another session) counts as a failure and is not used.
///
///   step     | what is sent                 | next
///   ---------+------------------------------+-----------------------------------------------
///   kShut    | nothing                      | begin(): kHello
///   kHello   | a hello, again and again     | kRelease or kLook; out: other version or model
///   kRelease | release, once               | kClear
///   kClear   | clear faults, once           | kLook
///   kLook    | reads                        | kUp; out where it tells of a fault; kClear, once,
///            |                              | where it had stopped since its host fell silent
///   kUp      | command, setpoint or read    | out: fault, `failures_max` failures in a row
///   kOut     | command or read, seldom      | begin(): kHello
///
/// "Once": under one sequence number until it is executed, so that a repeat is never a second one.
/// All members are @rt.
class Channel {
 public:
  enum class Step : std::uint8_t { kShut, kHello, kRelease, kClear, kLook, kUp, kOut };

  Channel() : Channel(ChannelSettings{}) {}
  explicit Channel(const ChannelSettings& settings);

  /// Opens a session. @param clear  release the latch and clear faults first.
  void begin(bool clear, Instant now);
  void shut() { step_ = Step::kShut; }
  Step step() const { return step_; }
  bool is_up() const { return step_ == Step::kUp; }
  bool is_out() const { return step_ == Step::kOut; }
  /// Why it is out.
  std::optional<Error> error() const { return is_out() ? error_ : std::nullopt; }
  /// When this session opened it stood by a stop of its own: the host before was silent.
  bool had_stopped() const { return had_stopped_; }
  /// Since begin() something answered as another axis: kUnexpectedReply (its number).
  std::optional<Error> other_axis() const { return other_axis_; }
  void put_out(Error error);

  /// Carried out exactly once; goes before setpoints, and takes the place of the last one.
  void command(Mode mode);
  /// What the axis said against the last command that it executed.
  std::optional<Error> command_refusal() const { return command_refusal_; }
  /// What every frame says from now on; nothing: reads.
  void follow(const std::optional<segments::Setpoint>& setpoint) { setpoint_ = setpoint; }
  /// The next read asks for health.
  void ask_health() { health_due_ = true; }

  Request next_request(Instant now);
  /// True where the answer is fresh.
  bool replied(std::span<const std::uint8_t> miso, Instant now);

  /// The last fresh one. Without a value before the first.
  const std::optional<State>& state() const { return state_; }
  /// Nothing before the first in this session.
  std::optional<Health> health() const {
    return facts_.health ? std::optional(facts_.health->what) : std::nullopt;
  }
  AxisLinkFacts::Axis facts() const;
  /// Sequence of the last frame that is known to be executed.
  std::uint16_t executed() const { return executed_; }
  std::uint16_t sequence() const { return sequence_; }
  double q() const { return state_ ? from_units(state_->position) : 0; }
  double uncertainty() const { return uncertainty_; }
  /// Neither moving nor homing, by a fresh answer that came after its last command.
  bool at_rest() const;
  /// Since the frame of the last fresh answer began.
  Duration silence(Instant now) const { return now - fresh_at_; }
  /// From the last frame that an axis heard until it stands for sure: its deadline, then braking.
  Duration run_out() const { return run_out_; }
  /// At `now`; measured means: when the last frame began.
  JointPosition position(Instant now) const;
  /// Homed, by its last answer; a few frames may have failed since.
  bool is_referenced() const;
  std::uint64_t failed_frames() const { return failed_frames_; }
  /// By how much the last search named its zero other than the one before it in this session, rad;
  /// nothing where there was none before, or where answers were lost around that instant. -+ the
  /// encoder's counts and what the speed changes from one answer to the next.
  std::optional<double> zero_shift() const { return zero_shift_; }

 private:
  bool late(const Reply& reply, Instant now);
  void fail(ErrorCode why, double measured, Instant now);
  void take(const Reply& reply, Instant at);
  void take_state(const State& state, Instant at);
  void look_for_zero(const State& state, Instant at);
  std::optional<Error> identity_error(const Identity& identity) const;
  Error indexed(ErrorCode code, double measured = 0, double limit = 0) const;

  ChannelSettings settings_;
  std::uint32_t hash_;
  Duration run_out_;
  Step step_ = Step::kShut;
  bool clear_ = false;
  bool had_stopped_ = false;
  std::optional<Error> error_;
  std::optional<Error> other_axis_;

  struct Command {
    Mode mode = Mode::kRead;
    std::optional<std::uint16_t> sequence;  ///< once it was sent
  };
  std::optional<Command> command_;
  std::optional<Error> command_refusal_;
  std::optional<segments::Setpoint> setpoint_;
  bool health_due_ = false;

  std::uint8_t session_ = 0;
  std::uint16_t sequence_ = 0;                ///< of the last frame sent
  std::optional<std::uint16_t> awaited_;      ///< what a fresh answer to the last frame names
  std::optional<std::uint16_t> sent_before_;  ///< what the frame under way must be answered with
  std::uint16_t executed_ = 0;
  Instant began_;                             ///< the frame under way
  Instant fresh_at_;                          ///< when the frame of `state_` began
  static constexpr std::size_t kRecent = 32;  ///< frames that an answer may be behind
  /// By sequence, modulo the size. The frame under way has its place here too.
  std::array<Instant, 2 * kRecent> sent_at_{};
  std::uint64_t late_frames_ = 0;
  int failures_ = 0;
  std::uint64_t failed_frames_ = 0;

  std::optional<State> state_;
  AxisLinkFacts::Axis facts_;  ///< identity and health
  double uncertainty_ = 0;
  bool has_zero_ = false;  ///< in this session; it was homed, and positions count from there
  std::optional<double> zero_shift_;
};

/// What an axis says of itself, as an error; nothing where it is well.
std::optional<Error> trouble_of(const State& state);
/// The same of its verdict on the last frame.
std::optional<Error> refusal_of(const State& state);

}  // namespace sinew::axis_link
