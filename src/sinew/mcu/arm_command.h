#pragma once

#include <stdint.h>

#include "sinew/mcu/step_pulses.h"

/// What the BigRobotArm's two old wires say to its board, and how a board reads them.
/// docs/wires/bigrobotarm.md has the tables. @rt
namespace sinew {
namespace mcu {

enum class CommandKind : uint8_t {
  kNone,
  kInvalid,
  kGoto,
  kHome,
  kReset,
  kSpeeds,
  kAccelerations,
  kGripper,
  kSync,
  kStatus,
  kStop,
  kBegin,
  kEnd,
  kQueueGoto,
  kQueueFlush,
  kQueueClear,
};

struct ArmCommand {
  CommandKind kind;
  uint8_t given;  ///< words of kGoto, kQueueGoto, kSpeeds, kAccelerations
  int32_t words[kArmAxes];
  bool on;           ///< kGripper, kSync
  uint8_t position;  ///< kGripper, deg
  int8_t repeats;    ///< kBegin
};

/// Requests of the byte wire, taken by their length. Each is complete with the 0D behind it; with
/// another byte there it is none.
class ByteReader {
 public:
  static constexpr uint8_t kLongest = 21;
  static constexpr uint8_t kStopId = 11;

  /// @return kNone: more is needed
  CommandKind push(uint8_t byte);
  /// What push() has just completed.
  const ArmCommand& command() const { return command_; }
  bool begun() const { return size_ > 0 || unknown_; }
  void reset() { size_ = 0, unknown_ = false; }

 private:
  uint8_t bytes_[kLongest] = {};
  CommandKind read();
  CommandKind read_unknown(uint8_t byte);

  uint8_t size_ = 0;
  bool unknown_ = false;  ///< up to the next 0D
  ArmCommand command_ = {};
};

/// Lines of the text wire, as the firmware of 2026 reads them.
class LineReader {
 public:
  static constexpr uint8_t kLongest = 50;

  /// @return kNone: the line is not over
  CommandKind push(char character);
  const ArmCommand& command() const { return command_; }
  bool begun() const { return size_ > 0 && !over_; }
  void reset() { size_ = 0, over_ = false; }
  /// The line that push() has just ended, until the next push().
  const char* line() const { return line_; }
  uint8_t size() const { return size_; }

 private:
  char line_[kLongest] = {};
  uint8_t size_ = 0;
  bool over_ = false;
  ArmCommand command_ = {};
};

}  // namespace mcu
}  // namespace sinew
