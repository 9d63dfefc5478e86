#include "sinew/mcu/arm_board.h"

#include "sinew/mcu/bytes.h"
#include "sinew/mcu/interrupts.h"

namespace sinew {
namespace mcu {

using arm_link::Fault;
using arm_link::Kind;
using arm_link::Reference;

namespace {

constexpr uint8_t kSettling = 3;  ///< slices

}  // namespace

ArmBoard::ArmBoard(const ArmBoardFacts& facts, KeptPositions& kept)
    : facts_(facts), kept_(kept), commands_(motion_, out_, facts.axes) {
  const KeptPositions::Slot* const found = kept.find();
  if (found != nullptr) {
    memory_ = *found;
    reference_ = Reference::kKept;
    if (memory_.moving != 0 || memory_.uncertain != 0) {
      reference_ = Reference::kKeptMoving;
      fault_ = Fault::kRestart;
    }
    int32_t positions[kArmAxes];
    for (uint8_t i = 0; i < kArmAxes; ++i) positions[i] = memory_.steps[i] * kUnitsPerStep;
    motion_.set_positions(positions);
    commands_.sync_targets();
  }
  memory_.moving = 0;
  memory_.uncertain = reference_ == Reference::kKeptMoving ? 1 : 0;
  ++memory_.starts;
  kept_.keep(memory_);
  // No session of a life before is taken for one of this.
  last_session_ = static_cast<uint8_t>(memory_.starts * 61);
}

bool ArmBoard::takes() const {
  return out_.has_room();
}

void ArmBoard::receive(uint8_t byte, uint32_t now_ms) {
  now_ms_ = now_ms;
  const uint32_t quiet = now_ms - heard_ms_;
  heard_ms_ = now_ms;
  if (quiet > kHalfFrameMs) {
    frames_.reset();
    in_frame_ = false;
  }
  // Half a request of a host that died does not swallow the next one's. Text may be typed by hand.
  if (quiet > kHalfRequestMs) bytes_.reset();
  const uint8_t size = frames_.push(byte);
  arm_link::Request request;
  if (size > 0 && arm_link::decode(frames_.frame(), size, request)) {
    in_frame_ = false;
    wire_ = Wire::kFrames;
    receive_frame(request);
    return;
  }
  if (wire_ == Wire::kFrames) return;
  // No request of the old wires begins with 00.
  const bool idle = !bytes_.begun() && !lines_.begun();
  if (byte == 0 && (in_frame_ || idle)) {
    in_frame_ = size == 0;
    return;
  }
  if (!in_frame_) receive_old(byte);
}

/// A letter begins a line, everything else is of the byte wire; the first good request decides.
void ArmBoard::receive_old(uint8_t byte) {
  bool text = wire_ == Wire::kText;
  if (wire_ == Wire::kOpen) {
    const bool letter = (byte >= 'A' && byte <= 'Z') || (byte >= 'a' && byte <= 'z');
    text = lines_.begun() || (letter && !bytes_.begun());
    commands_.set_text(text);
  }
  const CommandKind kind = text ? lines_.push(static_cast<char>(byte)) : bytes_.push(byte);
  if (kind == CommandKind::kNone) return;
  if (wire_ == Wire::kOpen && kind != CommandKind::kInvalid) choose_old(text);
  if (text) {
    commands_.take(lines_.command(), lines_.line(), lines_.size());
  } else {
    commands_.take(bytes_.command(), nullptr, 0);
  }
  if (commands_.take_reset()) say_positions();
}

/// The old wires cannot say that positions are uncertain: counters that were kept in a motion begin
/// at 0, as with the maker's firmware.
void ArmBoard::choose_old(bool text) {
  wire_ = text ? Wire::kText : Wire::kBytes;
  if (reference_ != Reference::kKeptMoving) return;
  const int32_t zeros[kArmAxes] = {};
  motion_.set_positions(zeros);
  commands_.sync_targets();
  reference_ = Reference::kPowerUp;
  memory_.uncertain = 0;
  keep_due_ = true;
}

/// A host has set the positions.
void ArmBoard::say_positions() {
  reference_ = Reference::kSaid;
  memory_.uncertain = 0;
  keep_due_ = true;
}

void ArmBoard::receive_frame(const arm_link::Request& request) {
  const bool mine = session_ != 0 && request.session == session_;
  if (mine) host_heard_ms_ = now_ms_;
  if (request.kind == Kind::kHello) {
    open_session(request);
  } else if (request.kind == Kind::kStop) {
    if (is_due(request)) sequence_ = request.sequence;
    brake(Fault::kStopAsked);
  } else if (is_due(request)) {
    carry_out(request);
  }
  reply(request);
}

/// It is the next one of the session: what comes twice, or behind a gap, is not carried out.
bool ArmBoard::is_due(const arm_link::Request& request) const {
  return session_ != 0 && request.session == session_ && arm_link::is_numbered(request.kind) &&
         request.sequence == static_cast<uint16_t>(sequence_ + 1);
}

void ArmBoard::open_session(const arm_link::Request& request) {
  // Whoever moved the arm before has lost it.
  end_stream(Fault::kStopAsked);
  last_session_ = static_cast<uint8_t>(last_session_ == 255 ? 1 : last_session_ + 1);
  session_ = last_session_;
  sequence_ = request.sequence;
  deadline_ms_ = request.deadline_ms;
  host_heard_ms_ = now_ms_;
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    // Steps per s^2, in grains per ms^2: 1.048576 times as many.
    const uint32_t steps = request.brakings[i];
    brakings_[i] = steps + (steps * 3184 >> 16) + 1;
  }
}

void ArmBoard::carry_out(const arm_link::Request& request) {
  if (request.kind == Kind::kSegment) return take_segment(request.segment);
  sequence_ = request.sequence;
  if (request.kind == Kind::kRelease) release();
  if (request.kind == Kind::kGripper) {
    gripper_on_ = request.gripper_on;
    if (gripper_on_ && !stop_line_) motion_.gripper_to(request.gripper, request.gripper_ms);
  }
  if (request.kind == Kind::kPositions) set_positions(request.positions);
}

/// With an empty queue no slice can begin meanwhile.
void ArmBoard::set_positions(const int32_t* positions) {
  if (motion_.moving() || motion_.queued_ms() > 0) return;
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    const int32_t most = kSteps * kUnitsPerStep;
    if (positions[i] > most || positions[i] < -most) return brake(Fault::kRefused);
  }
  motion_.set_positions(positions);
  say_positions();
}

/// Where the queue is full it is not carried out, and the host sends it again.
void ArmBoard::take_segment(const ArmSegment& segment) {
  const uint16_t next = static_cast<uint16_t>(sequence_ + 1);
  if (fault_ != Fault::kNone || stop_line_ || motion_.stopping()) {
    sequence_ = next;
    return;
  }
  // Its host is too late: the queue is empty, and the axes run on.
  if (motion_.coasting()) {
    sequence_ = next;
    return brake(Fault::kUnderrun);
  }
  const SegmentRefusal refusal = motion_.push(segment);
  if (refusal == SegmentRefusal::kFull) return;
  sequence_ = next;
  if (refusal == SegmentRefusal::kRange) return brake(Fault::kRefused);
  // Between the question above and the queue it has run empty, or the stop line has come.
  if (refusal == SegmentRefusal::kStopping && motion_.coasting()) brake(Fault::kUnderrun);
}

/// The first cause stays. A motion of the old wires brakes as it accelerates.
void ArmBoard::brake(Fault fault) {
  uint32_t of_commands[kArmAxes];
  const bool runs = commands_.runs();
  if (runs) {
    commands_.get_brakings(of_commands);
    commands_.drop_rest();
  }
  motion_.stop(runs ? of_commands : brakings_);
  if (fault_ == Fault::kNone) fault_ = fault;
}

/// A motion brakes; what only waits in the queue is not begun any more.
void ArmBoard::end_stream(Fault fault) {
  if (motion_.moving()) return brake(fault);
  const InterruptsOff off;
  motion_.clear_queue();
}

void ArmBoard::release() {
  if (motion_.moving() || stop_line_) return;
  fault_ = Fault::kNone;
}

void ArmBoard::poll(uint32_t now_ms) {
  now_ms_ = now_ms;
  bool line_was_low = false;
  {
    const InterruptsOff off;
    line_was_low = line_was_low_;
    line_was_low_ = stop_line_;
  }
  if (frozen_) {
    frozen_ = false;
    commands_.sync_targets();
  }
  commands_.set_blocked(stop_line_);
  if (stop_line_) commands_.drop_rest();
  // Also behind a change of the wire: a motion of the old ones ends with its bookkeeping.
  commands_.set_free_memory(health_.stack_free);
  if (wire_ != Wire::kFrames) {
    commands_.poll();
    if (commands_.take_reset()) say_positions();
    return;
  }
  if (commands_.runs() && !motion_.moving()) commands_.forget();
  if (line_was_low && fault_ == Fault::kNone) fault_ = Fault::kStopLine;
  if (motion_.coasting()) brake(Fault::kUnderrun);
  if (session_ == 0 || now_ms - host_heard_ms_ <= deadline_ms_) return;
  // At rest a host may go; in motion nothing does without one.
  session_ = 0;
  end_stream(Fault::kHostSilent);
}

void ArmBoard::slice(bool stop_line) {
  stop_line_ = stop_line;
  if (stop_line) line_was_low_ = true;
  if (!stop_line) {
    motion_.slice();
  } else if (motion_.moving()) {
    motion_.freeze();
    frozen_ = true;
  } else {
    motion_.clear_queue();
  }
  keep();
}

/// The motors' steps, where they have changed. In motion some slices are left out: a restart then
/// leaves them uncertain in any case. What a slice plans is made in the next two.
void ArmBoard::keep() {
  if (motion_.moving()) {
    settling_ = kSettling;
  } else if (settling_ > 0) {
    --settling_;
  }
  const uint8_t moving = settling_ > 0 ? 1 : 0;
  left_out_ = static_cast<uint8_t>((left_out_ + 1) & 3);
  if (moving == memory_.moving && moving != 0 && left_out_ != 0) return;
  bool changed = keep_due_ || moving != memory_.moving;
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    const int32_t steps = motion_.pulses().steps(i);
    changed = changed || steps != memory_.steps[i];
    memory_.steps[i] = steps;
  }
  if (!changed) return;
  keep_due_ = false;
  memory_.moving = moving;
  kept_.keep(memory_);
}

void ArmBoard::reply(const arm_link::Request& request) {
  const Kind kind = request.kind;
  arm_link::Reply reply = {};
  reply.kind = kind;
  reply.session = session_;
  reply.sequence = sequence_;
  reply.tag = request.tag;
  if (kind == Kind::kIdentity) {
    copy_bytes(reply.identity, facts_.identity, arm_link::kIdentitySize);
  } else if (kind == Kind::kStatistics) {
    reply.starts = memory_.starts;
    reply.reset_cause = health_.reset_cause;
    reply.stack_free = health_.stack_free;
    reply.late_slices = motion_.pulses().late();
    reply.loop_us_max = health_.loop_us_max;
    reply.bytes_lost = health_.bytes_lost;
    reply.frames_bad = frames_.dropped();
  } else {
    put_state(reply);
  }
  uint8_t frame[arm_link::kReplyMax];
  uint8_t stuffed[kStuffedMax];
  const uint8_t size = stuff(frame, arm_link::encode(reply, frame), stuffed);
  for (uint8_t i = 0; i < size; ++i) out_.put(stuffed[i]);
}

void ArmBoard::put_state(arm_link::Reply& reply) const {
  reply.moving = motion_.moving();
  reply.stopping = motion_.stopping();
  reply.stop_line = stop_line_;
  reply.fault = fault_;
  reply.reference = reference_;
  reply.queued_ms = motion_.queued_ms();
  reply.queue_room = motion_.queue_room();
  for (uint8_t i = 0; i < kArmAxes; ++i) reply.positions[i] = motion_.position(i);
  reply.gripper_on = gripper_on_;
  reply.gripper_moves = motion_.gripper().moving();
  reply.gripper = motion_.gripper().angle();
}

uint16_t ArmBoard::gripper_us() const {
  const uint32_t angle = motion_.gripper().angle();
  return static_cast<uint16_t>(545 + angle * (2400 - 544) / kGripperMax);
}

}  // namespace mcu
}  // namespace sinew
