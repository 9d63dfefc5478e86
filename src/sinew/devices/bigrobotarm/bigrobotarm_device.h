#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_device_board.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_device_stepping.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_text.h"
#include "sinew/model/device.h"
#include "sinew/motion/trapezoid.h"

namespace sinew {

/// Which BigRobotArm answers.
enum class BigRobotArmProfile : std::uint8_t {
  kDocument,  ///< as its document says, where the document is right
  kAsBuilt,   ///< as the firmware was seen to behave, with all its defects
  kOwn,       ///< our firmware: ArmLinkBoard
};

/// The BigRobotArm's firmware behind its wire (docs/wires/bigrobotarm.md): point to point, one
/// command at a time, deaf while it moves.
///
/// kDocument: the five joints run a trapezoid each, speed m/100 motor rev/s, acceleration m/100
/// rev/s^2, both from the moment when the command is taken up; it is done when the last one is.
/// With sync on, the quicker ones are stretched to the slowest.
///
/// kAsBuilt: a byte request ends at the first 0D, wherever it stands; the processor limits the step
/// rates (BigRobotArmStepping); echoed multipliers are cut by float rounding, reported words have
/// only a sign in their top byte; sync mode counts in a frame of its own that no report shows
/// (byte and text of 2021); an END without BEGIN kills the device (2021); a ramped motion behind a
/// level one first runs on at the old speed (2026).
///
///   state          | what happens                          | next
///   ---------------+---------------------------------------+------------------------------
///   listening      | a motion                              | moving, deaf
///   listening      | BEGIN (text)                          | recording
///   listening      | Q0 (2026)                             | queue running, not deaf
///   moving         | all joints arrive                     | listening, the motion's answer
///   recording      | a command                             | recording, it is kept
///   recording      | END                                   | moving through the kept ones
///   queue running  | Q0, QCLEAR, M503                      | queue running, answered
///   queue running  | anything else                         | deaf until the queue is empty
///   any            | END without BEGIN (as built, 2021)    | dead
///   any            | reset()                               | listening, all counters 0
///
/// A joint with a speed below 1 that has to move never arrives. Time comes from outside and must
/// not run back; nothing allocates. @rt
class BigRobotArmFirmware final : public BigRobotArmBoard {
 public:
  static constexpr std::size_t kInputBuffer = 63;       ///< the rest is lost
  static constexpr std::size_t kSequenceCapacity = 20;  ///< commands from BEGIN to END
  static constexpr std::size_t kQueueCapacity = 4;      ///< motions behind the running one

  /// Just powered up at `boot`; all steps 0, gripper enabled at 90.
  BigRobotArmFirmware(const BigRobotArmDevice& settings, Instant boot,
                      BigRobotArmProfile profile = BigRobotArmProfile::kDocument);

  /// The board starts again: power came back, or a port that opened pulled its reset line. A motion
  /// ends where it is. It hears nothing for `deaf`, while its boot loader waits.
  void reset(Instant now, Duration deaf = Duration::zero());

  /// Bytes that arrive at `now`.
  void restart(Instant now, Duration deaf, bool /*power*/) override { reset(now, deaf); }
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;

  /// Lets time pass up to `now`.
  void advance(Instant now) override;

  /// Moves replies out; returns how many bytes. Where replies were not taken in time, the device
  /// holds the next command back until an advance() finds room, as a full serial port would.
  std::size_t take_output(std::span<std::uint8_t> out) override;

  /// When something happens by itself next: the end of a motion. Nothing: it waits for bytes.
  std::optional<Instant> next_event() const override;

  bool moving() const override { return moving_; }
  bool deaf() const override { return moving_; }
  /// Steps that the device believes to stand at, or to be on the way to, in the frame it reports.
  const bigrobotarm::Words& targets() const { return targets_; }

  /// The truth, which the device never tells: motor microsteps since power-up, not touched by
  /// Reset. `now` is not before the last call's.
  std::array<double, bigrobotarm::kJoints> rotor_steps(Instant now) const override;
  /// Where its counters say that it is at `now`, in the frame it reports.
  std::array<double, bigrobotarm::kJoints> counted_steps(Instant now) const override;
  bigrobotarm::Gripper gripper() const override { return gripper_; }
  /// us of the pulse that its gripper's servo gets: 544..2400 for 0..180 deg in whole numbers, as
  /// the Arduino's Servo library counts, and the one more that was measured. Beyond 180 that stays.
  int gripper_pulse_us() const {
    return 545 + (gripper_.position < 180 ? gripper_.position : 180) * (2400 - 544) / 180;
  }
  std::uint64_t bytes_lost() const override { return bytes_lost_; }

 private:
  using Words = bigrobotarm::Words;
  /// Room that must be free before a command is taken up: more than any one reply.
  static constexpr std::size_t kReplyRoom = 512;

  bool as_built() const { return profile_ == BigRobotArmProfile::kAsBuilt; }
  bool text_of(BigRobotArmDialect dialect) const {
    return settings_.wire == BigRobotArmWire::kText && settings_.dialect == dialect;
  }
  bool holds_input() const { return dead_ || held_ || (moving_ && !queue_running_); }
  void boot();
  void process();
  bool next_byte(std::uint8_t& byte);
  void take_byte_request(std::uint8_t byte);
  void take_character(char character);
  void take_line(const bigrobotarm::text::Line& line);
  void take_sequence_line(const bigrobotarm::text::Line& line);
  bool take_queue_line(const bigrobotarm::text::Line& line);
  void execute(const bigrobotarm::Request& request, std::uint8_t words_given);
  void put_multipliers(Words& words, const Words& given, std::uint8_t count) const;
  void begin_motion(const Words& targets);
  std::optional<double> begin_profiles();
  std::optional<double> begin_stepping(bool split);
  void finish_motion();
  void run_queue();
  void run_sequence();
  void reply_done(const bigrobotarm::Request& request);
  void reply_text(const bigrobotarm::Request& request);
  void reply_line(const bigrobotarm::text::ReplyLine& line);
  bigrobotarm::Status status() const;
  Words reported_multipliers(Words words) const;
  Words reported_words(Words words) const;
  void send(const bigrobotarm::Reply& reply);
  void send(const bigrobotarm::text::ReplyLine& line);

  BigRobotArmDevice settings_;
  BigRobotArmProfile profile_;
  Instant now_;
  Instant deaf_until_{};
  bool dead_ = false;

  FixedVector<std::uint8_t, kInputBuffer> input_;
  FixedVector<std::uint8_t, 4096> output_;
  std::uint64_t bytes_lost_ = 0;
  bigrobotarm::byte::RequestDecoder byte_decoder_;
  bigrobotarm::byte::CutRequestDecoder cut_decoder_;
  bigrobotarm::text::LineReader line_reader_;

  Words targets_{};
  Words sync_targets_{};  ///< as built: the frame of the sync mode
  Words speeds_{};
  Words accelerations_{};           ///< as echoed
  Words accelerations_in_force_{};  ///< values below 1 are echoed and not used
  bigrobotarm::Gripper gripper_{true, 90};
  bool sync_ = false;
  std::array<std::int64_t, bigrobotarm::kJoints> rotor_at_zero_{};  ///< steps since power-up

  bool moving_ = false;
  Instant motion_start_{};
  std::optional<Instant> motion_end_;
  std::array<motion::Trapezoid, bigrobotarm::kJoints> profiles_;  ///< kDocument
  BigRobotArmStepping stepping_;                                  ///< kAsBuilt
  std::array<double, bigrobotarm::kJoints> distances_{};          ///< of the motion under way
  std::array<double, bigrobotarm::kJoints> level_speeds_{};       ///< steps/s, still believed
  bigrobotarm::Request under_way_;

  FixedVector<Words, kQueueCapacity> queue_;
  bool queue_running_ = false;
  std::optional<bigrobotarm::text::Line> held_;  ///< waits for the queue to run empty

  FixedVector<bigrobotarm::text::Line, kSequenceCapacity> sequence_;
  bool recording_ = false;
  std::int8_t repeats_ = 0;
  bool running_ = false;  ///< between END and the last of its commands
  std::int8_t rounds_left_ = 0;
  std::size_t sequence_place_ = 0;
};

}  // namespace sinew
