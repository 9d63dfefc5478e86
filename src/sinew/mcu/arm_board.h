#pragma once

#include <stdint.h>

#include "sinew/mcu/arm_commands.h"
#include "sinew/mcu/arm_link.h"
#include "sinew/mcu/arm_motion.h"
#include "sinew/mcu/arm_replies.h"
#include "sinew/mcu/frame_stream.h"
#include "sinew/mcu/kept_positions.h"

namespace sinew {
namespace mcu {

/// What a board is built for.
struct ArmBoardFacts {
  ArmAxisFacts axes[kArmAxes];
  uint8_t identity[arm_link::kIdentitySize];  ///< of its image: wire/board_image.h
};

/// What only the chip knows; the statistics report it.
struct ArmBoardHealth {
  uint8_t reset_cause;
  uint16_t stack_free;  ///< bytes
  uint16_t loop_us_max;
  uint32_t bytes_lost;
};

/// The controller of an arm with five steppers and a gripper's servo: bytes in, bytes and step
/// pulses out. The same code is the firmware (firmware/atmega2560) and the simulated board.
///
/// Three wires on one port. The first good request decides: a frame of the arm link, a request of
/// the byte wire, a line of the text wire. A good frame decides again at any time, for its
/// checksum leaves no doubt; back from the arm link only a restart leads.
///
/// slice() and pulses().tick() belong to interrupts, all else to the main loop. @rt
class ArmBoard {
 public:
  enum class Wire : uint8_t { kOpen, kBytes, kText, kFrames };
  static constexpr uint8_t kHalfRequestMs = 100;
  static constexpr uint8_t kHalfFrameMs = 20;

  /// @param kept  memory that outlives a restart
  ArmBoard(const ArmBoardFacts& facts, KeptPositions& kept);

  /// Room for what a byte may ask for. A byte that comes sooner has to wait in the port.
  bool takes() const;
  /// @param now_ms  any clock that begins at any time and does not run back
  void receive(uint8_t byte, uint32_t now_ms);
  void poll(uint32_t now_ms);
  ReplyBuffer& replies() { return out_; }
  void set_health(const ArmBoardHealth& health) { health_ = health; }

  /// Once a millisecond.
  /// @param stop_line  it is low: no pulse is made
  void slice(bool stop_line);
  StepPulses& pulses() { return motion_.pulses(); }
  const ArmMotion& motion() const { return motion_; }
  /// us of the servo's pulse: 545..2401 for 0..180 deg.
  uint16_t gripper_us() const;
  /// As its host has set it.
  bool gripper_on() const { return wire_ == Wire::kFrames ? gripper_on_ : commands_.gripper_on(); }
  Wire wire() const { return wire_; }
  /// Also of the old wires, where none latches.
  arm_link::Fault fault() const { return stop_line_ ? arm_link::Fault::kStopLine : fault_; }

 private:
  void receive_frame(const arm_link::Request& request);
  void receive_old(uint8_t byte);
  void choose_old(bool text);
  bool is_due(const arm_link::Request& request) const;
  void carry_out(const arm_link::Request& request);
  void set_positions(const int32_t* positions);
  void say_positions();
  void end_stream(arm_link::Fault fault);
  void open_session(const arm_link::Request& request);
  void take_segment(const ArmSegment& segment);
  void brake(arm_link::Fault fault);
  void release();
  void reply(const arm_link::Request& request);
  void put_state(arm_link::Reply& reply) const;
  void keep();

  const ArmBoardFacts& facts_;
  KeptPositions& kept_;
  KeptPositions::Slot memory_ = {};  ///< what was kept last
  uint8_t left_out_ = 0;             ///< slices since
  uint8_t settling_ = 0;             ///< slices until pulses that were planned are made
  volatile bool keep_due_ = false;
  ArmMotion motion_;
  ReplyBuffer out_;
  ArmCommands commands_;
  ArmBoardHealth health_ = {};

  Wire wire_ = Wire::kOpen;
  FrameReceiver frames_;
  ByteReader bytes_;
  LineReader lines_;
  bool in_frame_ = false;  ///< a 00 has begun what may be a frame
  uint32_t heard_ms_ = 0;  ///< the last byte
  uint32_t now_ms_ = 0;

  uint8_t session_ = 0;
  uint8_t last_session_ = 0;
  uint16_t sequence_ = 0;
  uint16_t deadline_ms_ = 0;
  uint32_t host_heard_ms_ = 0;  ///< the last good frame of the session
  uint32_t brakings_[kArmAxes] = {1, 1, 1, 1, 1};
  arm_link::Fault fault_ = arm_link::Fault::kNone;
  arm_link::Reference reference_ = arm_link::Reference::kPowerUp;
  volatile bool stop_line_ = false;
  volatile bool line_was_low_ = false;  ///< since the last poll()
  volatile bool frozen_ = false;  ///< the stop line ended a motion, and poll() has not seen it yet
  bool gripper_on_ = true;
};

}  // namespace mcu
}  // namespace sinew
