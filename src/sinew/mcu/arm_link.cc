#include "sinew/mcu/arm_link.h"

#include "sinew/mcu/bytes.h"

namespace sinew {
namespace mcu {
namespace arm_link {
namespace {

constexpr uint8_t kHeadSize = 5;
constexpr uint8_t kChecksumSize = 4;
constexpr uint8_t kReplyBit = 0x10;
constexpr uint8_t kKindBits = 0x0F;
// Flags of a state.
constexpr uint8_t kMoving = 1;
constexpr uint8_t kStopping = 2;
constexpr uint8_t kStopLine = 4;
constexpr uint8_t kGripperOn = 8;
constexpr uint8_t kGripperMoves = 16;
const uint8_t kRequestSizes[kKinds] = {0, 12, 34, 0, 0, 5, 20, 0, 0};
constexpr uint8_t kStateSize = 28;
constexpr uint8_t kStatisticsSize = 17;

uint8_t reply_size(Kind kind) {
  if (kind == Kind::kIdentity) return kIdentitySize;
  return kind == Kind::kStatistics ? kStatisticsSize : kStateSize;
}

template <class Message>
uint8_t finish(const Message& message, uint8_t kind, uint8_t size, uint8_t* out) {
  out[0] = static_cast<uint8_t>(kVersion << 5 | kind);
  out[1] = message.session;
  put_u16(out + 2, message.sequence);
  out[4] = message.tag;
  put_u32(out + size, crc32c(out, size));
  return static_cast<uint8_t>(size + kChecksumSize);
}

bool is_good(const uint8_t* frame, uint8_t size) {
  if (size < kHeadSize + kChecksumSize || frame[0] >> 5 != kVersion) return false;
  const uint8_t body = static_cast<uint8_t>(size - kChecksumSize);
  return get_u32(frame + body) == crc32c(frame, body);
}

void put_words(uint8_t* out, const int32_t* words) {
  for (uint8_t i = 0; i < kArmAxes; ++i) put_u32(out + 4 * i, static_cast<uint32_t>(words[i]));
}
void get_words(const uint8_t* in, int32_t* words) {
  for (uint8_t i = 0; i < kArmAxes; ++i) words[i] = static_cast<int32_t>(get_u32(in + 4 * i));
}

void put_state(const Reply& reply, uint8_t* out) {
  out[0] =
      static_cast<uint8_t>((reply.moving ? kMoving : 0) | (reply.stopping ? kStopping : 0) |
                           (reply.stop_line ? kStopLine : 0) | (reply.gripper_on ? kGripperOn : 0) |
                           (reply.gripper_moves ? kGripperMoves : 0));
  out[1] = static_cast<uint8_t>(static_cast<uint8_t>(reply.fault) |
                                static_cast<uint8_t>(reply.reference) << 4);
  put_u16(out + 2, reply.queued_ms);
  out[4] = reply.queue_room;
  out[5] = 0;
  put_words(out + 6, reply.positions);
  put_u16(out + 26, reply.gripper);
}

bool get_state(const uint8_t* in, Reply& out) {
  const uint8_t fault = in[1] & 15;
  const uint8_t reference = static_cast<uint8_t>(in[1] >> 4);
  if (in[0] > 31 || fault >= kFaults || reference > 3 || in[5] != 0) return false;
  out.moving = (in[0] & kMoving) != 0;
  out.stopping = (in[0] & kStopping) != 0;
  out.stop_line = (in[0] & kStopLine) != 0;
  out.gripper_on = (in[0] & kGripperOn) != 0;
  out.gripper_moves = (in[0] & kGripperMoves) != 0;
  out.fault = static_cast<Fault>(fault);
  out.reference = static_cast<Reference>(reference);
  out.queued_ms = get_u16(in + 2);
  out.queue_room = in[4];
  get_words(in + 6, out.positions);
  out.gripper = get_u16(in + 26);
  return true;
}

}  // namespace

uint8_t encode(const Request& request, uint8_t* out) {
  uint8_t* const body = out + kHeadSize;
  switch (request.kind) {
    case Kind::kHello:
      put_u16(body, request.deadline_ms);
      for (uint8_t i = 0; i < kArmAxes; ++i) put_u16(body + 2 + 2 * i, request.brakings[i]);
      break;
    case Kind::kSegment: {
      const ArmSegment& segment = request.segment;
      body[0] = segment.ms;
      body[1] = segment.begin ? 1 : 0;
      put_u16(body + 2, segment.gripper);
      put_words(body + 4, segment.targets);
      for (uint8_t i = 0; i < kArmAxes; ++i) {
        put_u16(body + 24 + 2 * i, static_cast<uint16_t>(segment.velocities[i]));
      }
      break;
    }
    case Kind::kGripper:
      body[0] = request.gripper_on ? 1 : 0;
      put_u16(body + 1, request.gripper);
      put_u16(body + 3, request.gripper_ms);
      break;
    case Kind::kPositions:
      put_words(body, request.positions);
      break;
    case Kind::kRead:
    case Kind::kStop:
    case Kind::kRelease:
    case Kind::kIdentity:
    case Kind::kStatistics:
      break;
  }
  const uint8_t kind = static_cast<uint8_t>(request.kind);
  return finish(request, kind, static_cast<uint8_t>(kHeadSize + kRequestSizes[kind]), out);
}

bool decode(const uint8_t* frame, uint8_t size, Request& out) {
  if (!is_good(frame, size) || (frame[0] & kReplyBit) != 0) return false;
  const uint8_t kind = frame[0] & kKindBits;
  if (kind >= kKinds || size != kHeadSize + kRequestSizes[kind] + kChecksumSize) return false;
  const uint8_t* const body = frame + kHeadSize;
  out = {};
  out.kind = static_cast<Kind>(kind);
  out.session = frame[1];
  out.sequence = get_u16(frame + 2);
  out.tag = frame[4];
  if (out.kind == Kind::kHello) {
    out.deadline_ms = get_u16(body);
    for (uint8_t i = 0; i < kArmAxes; ++i) out.brakings[i] = get_u16(body + 2 + 2 * i);
    return out.deadline_ms >= kDeadlineMin && out.deadline_ms <= kDeadlineMax;
  }
  if (out.kind == Kind::kSegment) {
    out.segment.ms = body[0];
    out.segment.begin = body[1] == 1;
    out.segment.gripper = get_u16(body + 2);
    get_words(body + 4, out.segment.targets);
    for (uint8_t i = 0; i < kArmAxes; ++i) {
      out.segment.velocities[i] = static_cast<int16_t>(get_u16(body + 24 + 2 * i));
    }
    return body[1] <= 1;
  }
  if (out.kind == Kind::kGripper) {
    out.gripper_on = body[0] == 1;
    out.gripper = get_u16(body + 1);
    out.gripper_ms = get_u16(body + 3);
    return body[0] <= 1;
  }
  if (out.kind == Kind::kPositions) get_words(body, out.positions);
  return true;
}

uint8_t encode(const Reply& reply, uint8_t* out) {
  uint8_t* const body = out + kHeadSize;
  if (reply.kind == Kind::kIdentity) {
    copy_bytes(body, reply.identity, kIdentitySize);
  } else if (reply.kind == Kind::kStatistics) {
    put_u16(body, reply.starts);
    body[2] = reply.reset_cause;
    put_u16(body + 3, reply.stack_free);
    put_u16(body + 5, reply.late_slices);
    put_u16(body + 7, reply.loop_us_max);
    put_u32(body + 9, reply.bytes_lost);
    put_u32(body + 13, reply.frames_bad);
  } else {
    put_state(reply, body);
  }
  const uint8_t kind = static_cast<uint8_t>(kReplyBit | static_cast<uint8_t>(reply.kind));
  return finish(reply, kind, static_cast<uint8_t>(kHeadSize + reply_size(reply.kind)), out);
}

bool decode(const uint8_t* frame, uint8_t size, Reply& out) {
  if (!is_good(frame, size) || (frame[0] & kReplyBit) == 0) return false;
  const uint8_t kind = frame[0] & kKindBits;
  if (kind >= kKinds) return false;
  out = {};
  out.kind = static_cast<Kind>(kind);
  if (size != kHeadSize + reply_size(out.kind) + kChecksumSize) return false;
  const uint8_t* const body = frame + kHeadSize;
  out.session = frame[1];
  out.sequence = get_u16(frame + 2);
  out.tag = frame[4];
  if (out.kind == Kind::kIdentity) {
    copy_bytes(out.identity, body, kIdentitySize);
    return true;
  }
  if (out.kind == Kind::kStatistics) {
    out.starts = get_u16(body);
    out.reset_cause = body[2];
    out.stack_free = get_u16(body + 3);
    out.late_slices = get_u16(body + 5);
    out.loop_us_max = get_u16(body + 7);
    out.bytes_lost = get_u32(body + 9);
    out.frames_bad = get_u32(body + 13);
    return true;
  }
  return get_state(body, out);
}

}  // namespace arm_link
}  // namespace mcu
}  // namespace sinew
