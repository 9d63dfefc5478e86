#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/model/device.h"
#include "sinew/motion/trapezoid.h"
#include "sinew/wire/bigrobotarm_byte.h"
#include "sinew/wire/bigrobotarm_text.h"

namespace sinew {

/// The BigRobotArm's firmware behind its wire, as its document says, where the document is right
/// (docs/wires/bigrobotarm.md): point to point, one command at a time, deaf while it moves.
///
/// The five joints run a trapezoid each: speed m/100 motor rev/s, acceleration m/100 rev/s^2, both
/// from the moment when the command is taken up; it is done when the last one is. With sync on,
/// the quicker ones are stretched to the slowest. A joint with a speed below 1 that has to move
/// never arrives. Time comes from outside and must not run back; nothing allocates. @rt
class BigRobotArmFirmware {
 public:
  static constexpr std::size_t kInputBuffer = 63;       ///< the rest is lost
  static constexpr std::size_t kSequenceCapacity = 20;  ///< commands from BEGIN to END

  /// Just powered up at `boot`; all steps 0, gripper enabled at 90.
  BigRobotArmFirmware(const BigRobotArmDevice& settings, Instant boot);

  /// Bytes that arrive at `now`.
  void receive(std::span<const std::uint8_t> bytes, Instant now);

  /// Lets time pass up to `now`.
  void advance(Instant now);

  /// Moves replies out; returns how many bytes. Where replies were not taken in time, the device
  /// holds the next command back until an advance() finds room, as a full serial port would.
  std::size_t take_output(std::span<std::uint8_t> out);

  /// When something happens by itself next: the end of a motion. Nothing: it waits for bytes.
  std::optional<Instant> next_event() const;

  bool moving() const { return moving_; }

  /// The truth, which the device never tells: motor microsteps since power-up, not touched by
  /// Reset. `now` is not before the last call's.
  std::array<double, bigrobotarm::kJoints> rotor_steps(Instant now) const;
  bigrobotarm::Gripper gripper() const { return gripper_; }
  std::uint64_t bytes_lost() const { return bytes_lost_; }

 private:
  using Words = bigrobotarm::Words;
  /// Room that must be free before a command is taken up: more than any one reply.
  static constexpr std::size_t kReplyRoom = 512;

  void process();
  bool next_byte(std::uint8_t& byte);
  void take_byte_request(std::uint8_t byte);
  void take_character(char character);
  void take_line(const bigrobotarm::text::Line& line);
  void execute(const bigrobotarm::Request& request, std::uint8_t words_given);
  void begin_motion(const Words& targets);
  void finish_motion();
  void run_sequence();
  void reply_done(const bigrobotarm::Request& request);
  void reply_text(const bigrobotarm::Request& request);
  bigrobotarm::Status status() const;
  void send(const bigrobotarm::Reply& reply);
  void send(const bigrobotarm::text::ReplyLine& line);

  BigRobotArmDevice settings_;
  Instant now_;

  FixedVector<std::uint8_t, kInputBuffer> input_;
  FixedVector<std::uint8_t, 4096> output_;
  std::uint64_t bytes_lost_ = 0;
  bigrobotarm::byte::RequestDecoder byte_decoder_;
  bigrobotarm::text::LineReader line_reader_;

  Words targets_{};
  Words speeds_{};
  Words accelerations_{};           ///< as echoed
  Words accelerations_in_force_{};  ///< values below 1 are echoed and not used
  bigrobotarm::Gripper gripper_{true, 90};
  bool sync_ = false;
  std::array<std::int64_t, bigrobotarm::kJoints> rotor_at_zero_{};  ///< steps since power-up

  bool moving_ = false;
  Instant motion_start_{};
  std::optional<Instant> motion_end_;
  std::array<motion::Trapezoid, bigrobotarm::kJoints> profiles_;
  bigrobotarm::Request under_way_;

  FixedVector<bigrobotarm::text::Line, kSequenceCapacity> sequence_;
  bool recording_ = false;
  std::int8_t repeats_ = 0;
  bool running_ = false;  ///< between END and the last of its commands
  std::int8_t rounds_left_ = 0;
  std::size_t sequence_place_ = 0;
};

}  // namespace sinew
