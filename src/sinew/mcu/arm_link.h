#pragma once

#include <stdint.h>

#include "sinew/mcu/arm_motion.h"
#include "sinew/mcu/frame_stream.h"

/// The arm link: Sinew's wire to a controller that moves all joints of an arm. One request, one
/// reply, each a frame (frame_stream.h) that ends with its CRC-32C; numbers are little endian. The
/// page is docs/wires/arm_link.md. @rt
namespace sinew {
namespace mcu {
namespace arm_link {

constexpr uint8_t kVersion = 1;         ///< 1..7
constexpr uint8_t kRequestMax = 44;     ///< bytes
constexpr uint8_t kReplyMax = 60;       ///< bytes
constexpr uint8_t kIdentitySize = 48;   ///< board, version, size, checksum: wire/board_image.h
constexpr uint16_t kDeadlineMin = 20;   ///< ms
constexpr uint16_t kDeadlineMax = 500;  ///< ms

enum class Kind : uint8_t {
  kRead = 0,        ///< the state; keeps the deadline away
  kHello = 1,       ///< opens a session, which ends any other
  kSegment = 2,     ///< one more of a stream
  kStop = 3,        ///< brakes, forgets the stream, latches; with any session number
  kRelease = 4,     ///< the latch; moves nothing
  kGripper = 5,     ///< to an angle
  kPositions = 6,   ///< says where the axes are; at rest only
  kIdentity = 7,    ///< which image runs; with any session number
  kStatistics = 8,  ///< with any session number
};
constexpr uint8_t kKinds = 9;

/// What stopped the arm. It latches, and kRelease ends it once its cause is gone.
enum class Fault : uint8_t {
  kNone = 0,
  kStopAsked = 1,
  kHostSilent = 2,  ///< no good frame of the session for its deadline, in motion
  kUnderrun = 3,    ///< the stream's queue ran empty in motion
  kStopLine = 4,    ///< the stop line was low
  kRefused = 5,     ///< a segment out of range
  kRestart = 6,     ///< the board started again while the arm moved
};
constexpr uint8_t kFaults = 7;

/// What the positions rest on.
enum class Reference : uint8_t {
  kPowerUp = 0,     ///< the counters began at 0 where the arm was
  kKept = 1,        ///< they were kept over a restart, at rest
  kKeptMoving = 2,  ///< they were kept over a restart in motion: off by what the arm ran on
  kSaid = 3,        ///< a host said them since
};

struct Request {
  Kind kind;
  uint8_t session;
  /// Of what is carried out once (all but kRead, kIdentity, kStatistics): one more than the last.
  uint16_t sequence;
  uint8_t tag;           ///< another one each time that a frame is sent; its reply has the same
  ArmSegment segment;    ///< kSegment
  uint16_t deadline_ms;  ///< kHello
  uint16_t brakings[kArmAxes];  ///< kHello: steps per s^2
  int32_t positions[kArmAxes];  ///< kPositions: 2^-8 step
  bool gripper_on;              ///< kGripper
  uint16_t gripper;             ///< kGripper: 1/128 deg of its servo
  uint16_t gripper_ms;          ///< kGripper: how long it takes
};

struct Reply {
  Kind kind;          ///< of the request: kIdentity, kStatistics; the state for all others
  uint8_t session;    ///< 0: none is open
  uint16_t sequence;  ///< carried out last
  uint8_t tag;        ///< of the request
  // The state.
  bool moving;
  bool stopping;
  bool stop_line;  ///< is low
  bool gripper_on;
  bool gripper_moves;
  Reference reference;
  Fault fault;
  uint16_t queued_ms;
  uint8_t queue_room;           ///< segments
  int32_t positions[kArmAxes];  ///< 2^-8 step, of the planned pulses
  uint16_t gripper;             ///< 1/128 deg
  // kIdentity
  uint8_t identity[kIdentitySize];
  // kStatistics
  uint16_t starts;       ///< since power came on, this one included
  uint8_t reset_cause;   ///< the chip's own bits
  uint16_t stack_free;   ///< bytes that the stack has never used
  uint16_t late_slices;  ///< milliseconds of motion that were planned too late
  uint16_t loop_us_max;  ///< longest round of the main loop
  uint32_t bytes_lost;   ///< of the port
  uint32_t frames_bad;
};

/// @return bytes written
uint8_t encode(const Request& request, uint8_t* out);
uint8_t encode(const Reply& reply, uint8_t* out);
/// False: no good frame of this version, and `out` has no meaning.
bool decode(const uint8_t* frame, uint8_t size, Request& out);
bool decode(const uint8_t* frame, uint8_t size, Reply& out);

/// kRead, kIdentity and kStatistics change nothing and carry no number.
inline bool is_numbered(Kind kind) {
  return kind != Kind::kRead && kind != Kind::kIdentity && kind != Kind::kStatistics;
}

}  // namespace arm_link
}  // namespace mcu
}  // namespace sinew
