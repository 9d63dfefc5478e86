#pragma once

#include <stdint.h>

#include "sinew/mcu/arm_command.h"
#include "sinew/mcu/arm_motion.h"
#include "sinew/mcu/arm_replies.h"

namespace sinew {
namespace mcu {

/// What is built in, of one axis.
struct ArmAxisFacts {
  uint16_t steps_per_rev;    ///< of the motor
  uint16_t multiplier_boot;  ///< speed and acceleration at power-up, hundredths of a revolution
};

/// Carries out the commands of the old wires, for clients of the maker's firmware: one after the
/// other, each with the reply that they wait for. Other than there, a status and a stop act at
/// once, also in a motion. docs/firmware/bigrobotarm.md lists every difference. @rt
///
///   state      | what happens              | next
///   -----------+---------------------------+--------------------------------------------
///   ready      | goto, home                | moving, with the begin of the reply
///   ready      | BEGIN                     | recording
///   ready      | Q0                        | queue running
///   moving     | the axes arrive           | ready, the reply; the next one that waits
///   recording  | END                       | moving through what was recorded
///   any moving | status, stop              | replied at once; a stop drops what waits
///   any moving | two more commands         | they wait; a third one is answered as invalid
class ArmCommands {
 public:
  static constexpr uint8_t kWaiting = 2;
  static constexpr uint8_t kQueue = 4;
  static constexpr uint8_t kSequence = 20;

  ArmCommands(ArmMotion& motion, ReplyBuffer& out, const ArmAxisFacts* axes);

  void set_text(bool text) { text_ = text; }
  /// @pre there is room for a reply  @param line  as it came (text), nullptr (bytes)
  void take(const ArmCommand& command, const char* line, uint8_t size);
  /// Time has passed: a motion may be over.
  void poll();
  /// For "Free mem".
  void set_free_memory(uint16_t bytes) { free_memory_ = bytes; }
  /// The stop line is low: no motion begins.
  void set_blocked(bool blocked) { blocked_ = blocked; }
  bool gripper_on() const { return gripper_on_; }
  /// Of a motion of these wires: grains per ms^2.
  void get_brakings(uint32_t* out) const;
  /// One of their motions is under way.
  bool runs() const { return run_ != Run::kNone; }
  /// Sequence and queue end with the motion under way.
  void drop_rest() { rounds_ = 0, queued_ = 0; }
  /// What was under way is over, without a reply.
  void forget();
  /// Positions were reset since this was asked last.
  bool take_reset();
  /// Counts have changed otherwise: targets are where the arm is.
  void sync_targets();

 private:
  struct Waiting {
    ArmCommand command;
    char line[LineReader::kLongest];
    uint8_t size;
  };
  enum class Run : uint8_t { kNone, kGoto, kQueue, kSequence };

  bool waits(const ArmCommand& command) const;
  void carry_out(const Waiting& one);
  void finish_motion();
  bool record(const ArmCommand& command);
  void run(const ArmCommand& command);
  void run_queue_command(const ArmCommand& command);
  void stop();
  bool move_to(const int32_t* targets);
  void set_multipliers(int32_t* words, const ArmCommand& command);
  void set_gripper(const ArmCommand& command);
  void run_queue();
  void run_sequence();
  void live_positions(int32_t* out) const;

  void echo(const Waiting& one);
  void reply_begun(const ArmCommand& command);
  void reply(CommandKind kind);
  void reply_bytes(CommandKind kind);
  void reply_text(CommandKind kind);
  void reply_invalid();
  void reply_line(const char* name);

  ArmMotion& motion_;
  ReplyBuffer& out_;
  const ArmAxisFacts* axes_;
  bool text_ = false;
  bool blocked_ = false;
  uint16_t free_memory_ = 0;

  int32_t targets_[kArmAxes] = {};
  int32_t speeds_[kArmAxes];
  int32_t accelerations_[kArmAxes];
  bool together_ = false;
  bool gripper_on_ = true;
  uint8_t gripper_ = 90;

  Waiting held_[kWaiting] = {};
  uint8_t waiting_ = 0;
  Run run_ = Run::kNone;
  CommandKind under_way_ = CommandKind::kNone;
  uint8_t stop_replies_due_ = 0;
  bool was_reset_ = false;

  int32_t queue_[kQueue][kArmAxes] = {};
  uint8_t queued_ = 0;

  ArmCommand sequence_[kSequence] = {};
  uint8_t recorded_ = 0;
  bool recording_ = false;
  int8_t rounds_ = 0;
  uint8_t place_ = 0;
};

}  // namespace mcu
}  // namespace sinew
