#include "sinew/mcu/arm_commands.h"

namespace sinew {
namespace mcu {
namespace {

const int32_t kMultiplierMax = 500;
const uint8_t kTextHomeGripper = 40;
const uint8_t kGripperDegrees = 180;
const uint8_t kAtOnce = 4;  ///< commands of a sequence in one round of the main loop

bool is_queue(CommandKind kind) {
  return kind == CommandKind::kQueueGoto || kind == CommandKind::kQueueFlush ||
         kind == CommandKind::kQueueClear;
}

bool moves(CommandKind kind) {
  return kind == CommandKind::kGoto || kind == CommandKind::kHome;
}

void copy_words(int32_t* out, const int32_t* in, uint8_t count = kArmAxes) {
  for (uint8_t i = 0; i < count; ++i) out[i] = in[i];
}

}  // namespace

ArmCommands::ArmCommands(ArmMotion& motion, ReplyBuffer& out, const ArmAxisFacts* axes)
    : motion_(motion), out_(out), axes_(axes) {
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    speeds_[i] = accelerations_[i] = axes[i].multiplier_boot;
  }
}

/// Until the motion under way is over.
bool ArmCommands::waits(const ArmCommand& command) const {
  if (command.kind == CommandKind::kStop || command.kind == CommandKind::kInvalid) return false;
  if (stop_replies_due_ > 0) return true;
  if (run_ == Run::kNone || command.kind == CommandKind::kStatus) return false;
  const bool of_queue =
      command.kind == CommandKind::kQueueGoto || command.kind == CommandKind::kQueueClear;
  return !(run_ == Run::kQueue && of_queue);
}

void ArmCommands::take(const ArmCommand& command, const char* line, uint8_t size) {
  Waiting one = {};
  one.command = command;
  one.size = size;
  for (uint8_t i = 0; i < size; ++i) one.line[i] = line[i];
  // What came before goes first; a status and a stop pass it.
  const bool passes = command.kind == CommandKind::kStop || command.kind == CommandKind::kStatus;
  if (!waits(command) && (waiting_ == 0 || passes)) return carry_out(one);
  if (waiting_ == kWaiting) return reply_invalid();
  held_[waiting_++] = one;
}

void ArmCommands::poll() {
  if (!out_.has_room()) return;
  if (run_ != Run::kNone || stop_replies_due_ > 0) {
    if (motion_.moving()) return;
    finish_motion();
    if (run_ != Run::kNone) return;
  }
  while (waiting_ > 0 && out_.has_room() && !waits(held_[0].command)) {
    const Waiting next = held_[0];
    held_[0] = held_[1];
    --waiting_;
    carry_out(next);
  }
}

void ArmCommands::finish_motion() {
  if (stop_replies_due_ > 0) {
    const Run was = run_;
    run_ = Run::kNone;
    sync_targets();
    if (was == Run::kGoto || was == Run::kSequence) reply(under_way_);
    for (; stop_replies_due_ > 0; --stop_replies_due_) reply(CommandKind::kStop);
  } else if (run_ == Run::kQueue && queued_ > 0) {
    run_queue();
  } else if (run_ == Run::kSequence) {
    run_sequence();
  } else {
    const bool was_goto = run_ == Run::kGoto;
    run_ = Run::kNone;
    if (was_goto) reply(under_way_);
  }
}

void ArmCommands::carry_out(const Waiting& one) {
  const ArmCommand& command = one.command;
  if (text_ && command.kind != CommandKind::kInvalid) echo(one);
  if (command.kind == CommandKind::kInvalid) return reply_invalid();
  if (command.kind == CommandKind::kStop) return stop();
  if (record(command)) return;
  if (is_queue(command.kind)) return run_queue_command(command);
  if (moves(command.kind)) {
    reply_begun(command);
    under_way_ = command.kind;
    run_ = Run::kGoto;
    run(command);
    return;
  }
  run(command);
  reply(command.kind);
}

/// What belongs to BEGIN .. END; false where it is an ordinary command.
bool ArmCommands::record(const ArmCommand& command) {
  if (command.kind == CommandKind::kBegin && !recording_) {
    recording_ = true;
    recorded_ = 0;
    rounds_ = command.repeats;
  } else if (command.kind == CommandKind::kEnd && recording_) {
    recording_ = false;
    under_way_ = CommandKind::kStatus;
    run_ = Run::kSequence;
    if (recorded_ == 0) rounds_ = 0;
    place_ = 0;
    run_sequence();
    return true;
  } else if (recording_ && !is_queue(command.kind) && command.kind != CommandKind::kBegin &&
             recorded_ < kSequence) {
    sequence_[recorded_++] = command;
  } else if (recording_ || command.kind == CommandKind::kBegin ||
             command.kind == CommandKind::kEnd) {
    reply_invalid();
    return true;
  } else {
    return false;
  }
  reply_line(nullptr);
  return true;
}

void ArmCommands::run(const ArmCommand& command) {
  int32_t targets[kArmAxes];
  copy_words(targets, targets_);
  switch (command.kind) {
    case CommandKind::kGoto:
      copy_words(targets, command.words, command.given);
      move_to(targets);
      break;
    case CommandKind::kHome:
      for (uint8_t i = 0; i < kArmAxes; ++i) targets[i] = 0;
      if (text_) {
        gripper_ = kTextHomeGripper;
        motion_.gripper_to(static_cast<uint16_t>(gripper_) * kServoUnitsPerDegree, 0);
      }
      move_to(targets);
      break;
    case CommandKind::kReset:
      for (uint8_t i = 0; i < kArmAxes; ++i) targets_[i] = 0;
      motion_.set_positions(targets_);
      sync_targets();
      was_reset_ = true;
      break;
    case CommandKind::kSpeeds:
      set_multipliers(speeds_, command);
      break;
    case CommandKind::kAccelerations:
      set_multipliers(accelerations_, command);
      break;
    case CommandKind::kGripper:
      set_gripper(command);
      break;
    case CommandKind::kSync:
      together_ = command.on;
      break;
    default:
      break;
  }
}

/// False: no such position, or the stop line is low; the axes stay where they are.
bool ArmCommands::move_to(const int32_t* targets) {
  ArmRamp ramps[kArmAxes];
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    if (targets[i] > kSteps || targets[i] < -kSteps) return false;
    ramps[i] = {axes_[i].steps_per_rev, static_cast<uint16_t>(speeds_[i]),
                static_cast<uint16_t>(accelerations_[i])};
  }
  if (blocked_) return false;
  copy_words(targets_, targets);
  motion_.go_to(targets, ramps, together_);
  return true;
}

void ArmCommands::set_multipliers(int32_t* words, const ArmCommand& command) {
  for (uint8_t i = 0; i < command.given; ++i) {
    const int32_t word = command.words[i];
    words[i] = word < 1 ? 1 : word > kMultiplierMax ? kMultiplierMax : word;
  }
}

void ArmCommands::set_gripper(const ArmCommand& command) {
  gripper_on_ = command.on;
  if (!command.on) return;
  gripper_ = command.position < kGripperDegrees ? command.position : kGripperDegrees;
  motion_.gripper_to(static_cast<uint16_t>(gripper_) * kServoUnitsPerDegree, 0);
}

void ArmCommands::run_queue_command(const ArmCommand& command) {
  if (command.kind == CommandKind::kQueueClear) {
    queued_ = 0;
    return reply_line("QUEUE-CLEARED");
  }
  // It waits while the queue runs.
  if (command.kind == CommandKind::kQueueFlush) return reply_line("QUEUE-DRAINED");
  if (queued_ == kQueue) return reply_line("QUEUE-FULL");
  int32_t* const next = queue_[queued_];
  copy_words(next, queued_ == 0 ? targets_ : queue_[queued_ - 1]);
  copy_words(next, command.words, command.given);
  ++queued_;
  out_.put_line("QUEUED-TO");
  out_.put_words_line("POSITION:", next);
  reply_line(nullptr);
  if (run_ == Run::kNone) run_queue();
}

void ArmCommands::run_queue() {
  run_ = Run::kQueue;
  while (queued_ > 0 && !motion_.moving()) {
    int32_t next[kArmAxes];
    copy_words(next, queue_[0]);
    --queued_;
    for (uint8_t i = 0; i < queued_; ++i) copy_words(queue_[i], queue_[i + 1]);
    move_to(next);
  }
}

void ArmCommands::run_sequence() {
  // Commands that do not move do not keep the main loop from its other work.
  for (uint8_t left = kAtOnce; left > 0 && !motion_.moving() && rounds_ > 0; --left) {
    if (place_ == recorded_) {
      place_ = 0;
      --rounds_;
      continue;
    }
    run(sequence_[place_++]);
  }
  if (motion_.moving() || rounds_ > 0) return;
  run_ = Run::kNone;
  reply(CommandKind::kStatus);
}

void ArmCommands::get_brakings(uint32_t* out) const {
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    // Hundredths of a revolution per s^2, in grains per ms^2.
    const uint64_t nominal = static_cast<uint64_t>(static_cast<uint32_t>(accelerations_[i])) *
                             axes_[i].steps_per_rev * kGrain;
    out[i] = static_cast<uint32_t>(nominal / 100000000) + 1;
  }
}

/// The axes brake; what waits is dropped, each with its reply.
void ArmCommands::stop() {
  uint32_t brakings[kArmAxes];
  get_brakings(brakings);
  motion_.stop(brakings);
  drop_rest();
  recording_ = false;
  for (; waiting_ > 0; --waiting_) reply_invalid();
  if (stop_replies_due_ < kWaiting) ++stop_replies_due_;
}

void ArmCommands::forget() {
  run_ = Run::kNone;
  waiting_ = stop_replies_due_ = 0;
  drop_rest();
  sync_targets();
}

bool ArmCommands::take_reset() {
  const bool was = was_reset_;
  was_reset_ = false;
  return was;
}

void ArmCommands::live_positions(int32_t* out) const {
  for (uint8_t i = 0; i < kArmAxes; ++i) out[i] = (motion_.position(i) + 128) >> 8;
}

void ArmCommands::sync_targets() {
  live_positions(targets_);
}

void ArmCommands::echo(const Waiting& one) {
  out_.put_text("Free mem: ");
  out_.put_number(free_memory_);
  out_.put_text("\r\nProcess command: ");
  for (uint8_t i = 0; i < one.size; ++i) out_.put(static_cast<uint8_t>(one.line[i]));
  out_.put_text("\r\n");
}

void ArmCommands::reply_begun(const ArmCommand& command) {
  if (!text_) out_.put_head(command.kind == CommandKind::kGoto ? 1 : 2);
}

void ArmCommands::reply(CommandKind kind) {
  if (text_) return reply_text(kind);
  reply_bytes(kind);
}

void ArmCommands::reply_bytes(CommandKind kind) {
  int32_t positions[kArmAxes];
  live_positions(positions);
  switch (kind) {
    case CommandKind::kGoto:
    case CommandKind::kHome:
      out_.put_words(positions);
      break;
    case CommandKind::kReset:
    case CommandKind::kStop:
      out_.put_head(kind == CommandKind::kReset ? 3 : ByteReader::kStopId);
      out_.put_words(positions);
      break;
    case CommandKind::kSpeeds:
      out_.put_head(4);
      out_.put_words(speeds_);
      break;
    case CommandKind::kAccelerations:
      out_.put_head(5);
      out_.put_words(accelerations_);
      break;
    case CommandKind::kGripper:
      out_.put_head(6);
      out_.put(gripper_on_ ? 1 : 0);
      out_.put(gripper_);
      break;
    case CommandKind::kSync:
      out_.put_head(7);
      out_.put(together_ ? 1 : 0);
      break;
    default:
      out_.put_head(0xCA);
      out_.put_words(positions);
      out_.put_words(accelerations_);
      out_.put_words(speeds_);
      out_.put(gripper_on_ ? 1 : 0);
      out_.put(gripper_);
      out_.put(together_ ? 1 : 0);
      break;
  }
  out_.put_ready();
}

void ArmCommands::reply_text(CommandKind kind) {
  const bool all = kind == CommandKind::kStatus;
  int32_t positions[kArmAxes];
  live_positions(positions);
  if (all || moves(kind)) out_.put_line("MOVING-TO");
  if (all || moves(kind) || kind == CommandKind::kReset || kind == CommandKind::kStop) {
    out_.put_words_line("POSITION:", positions);
  }
  if (all || kind == CommandKind::kAccelerations) {
    out_.put_words_line("ACCELERATION:", accelerations_);
  }
  if (all || kind == CommandKind::kSpeeds) out_.put_words_line("SPEED:", speeds_);
  if (kind == CommandKind::kGripper) {
    out_.put_text(gripper_on_ ? "BigRobotArm::GRIPPER: E1 P" : "BigRobotArm::GRIPPER: E0 P");
    out_.put_number(gripper_);
    out_.put_text("\r\n");
  }
  if (all || kind == CommandKind::kSync) {
    out_.put_line(together_ ? "SYNC-MOTORS: 1" : "SYNC-MOTORS: 0");
  }
  reply_line(nullptr);
}

void ArmCommands::reply_invalid() {
  if (text_) return reply_line("INVALID-COMMAND");
  out_.put_head(0xC9);
  out_.put_ready(false);
}

/// A line, if there is one, and READY. Text only.
void ArmCommands::reply_line(const char* name) {
  if (name != nullptr) out_.put_line(name);
  out_.put_line("READY");
}

}  // namespace mcu
}  // namespace sinew
