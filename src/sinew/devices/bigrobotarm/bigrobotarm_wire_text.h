#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <string_view>
#include <variant>

#include "sinew/core/fixed_vector.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire.h"

/// The text wire: host lines end with CR, device lines with CR LF, a reply ends with the line
/// `BigRobotArm::READY`. Everything here is @rt.
namespace sinew::bigrobotarm::text {

/// The device keeps this many characters of a line and drops the rest.
inline constexpr std::size_t kLineBuffer = 50;
inline constexpr char kLineEnd = '\r';

/// Opens a sequence: the commands up to END are kept, then run `repeats` times.
struct Begin {
  std::int8_t repeats = 1;  ///< the device keeps 8 bits: I200 is -56, and runs nothing
  friend bool operator==(const Begin&, const Begin&) = default;
};
struct End {
  friend bool operator==(const End&, const End&) = default;
};

// Since 2026: up to four motions wait behind the running one, and the device still listens.

struct QueueGoto {
  Words positions{};
  friend bool operator==(const QueueGoto&, const QueueGoto&) = default;
};
/// Answered when no motion is left.
struct QueueFlush {
  friend bool operator==(const QueueFlush&, const QueueFlush&) = default;
};
struct QueueClear {
  friend bool operator==(const QueueClear&, const QueueClear&) = default;
};

using Command = std::variant<Request, Begin, End, QueueGoto, QueueFlush, QueueClear>;

/// One host line. Words are told by their place alone, so a short line gives the first ones only.
struct Line {
  Command command;
  /// Of Goto, QueueGoto, SetSpeeds, SetAccelerations; the rest is 0.
  std::uint8_t words_given = kJoints;
  friend bool operator==(const Line&, const Line&) = default;
};

using Characters = FixedVector<char, 96>;

/// One line without its end; the caller's longest is 75 characters.
Characters encode_line(const Line& line);

/// True where the device's buffer holds the whole line.
bool sendable(const Line& line);

/// Reads a host line as the firmware does: by place, letters unseen (one before a word, two before
/// the fourth), a number ends at the first other character and is 0 without digits; more words
/// than needed are ignored. Numbers beyond 32 bits saturate.
/// @return nullopt for a command that the device does not know.
std::optional<Line> decode_line(std::string_view line);

inline std::string_view view(const Characters& characters) {
  return {characters.data(), characters.size()};
}

// What one device line says.

struct FreeMemory {
  std::int32_t bytes = 0;
  friend bool operator==(const FreeMemory&, const FreeMemory&) = default;
};
/// `Process command:` and the line that the device read; printed before a motion begins.
struct Echo {
  FixedVector<char, kLineBuffer> line;
  friend bool operator==(const Echo&, const Echo&) = default;
};
struct MovingTo {
  friend bool operator==(const MovingTo&, const MovingTo&) = default;
};
struct PositionLine {
  Words positions{};
  friend bool operator==(const PositionLine&, const PositionLine&) = default;
};
struct QueuedTo {
  friend bool operator==(const QueuedTo&, const QueuedTo&) = default;
};
struct Ready {
  friend bool operator==(const Ready&, const Ready&) = default;
};

using ReplyLine =
    std::variant<FreeMemory, Echo, MovingTo, PositionLine, Speeds, Accelerations, Gripper, Sync,
                 Invalid, Ready, QueuedTo, QueueFull, QueueDrained, QueueCleared>;

/// One line without its CR LF.
Characters encode_reply_line(const ReplyLine& line);

/// Strict: exactly what encode_reply_line writes, or nullopt.
std::optional<ReplyLine> decode_reply_line(std::string_view line);

/// Device side: characters to lines. Holds the first 50 of a line.
class LineReader {
 public:
  /// True where this character ends a line; then line() is the line until the next push.
  bool push(char character);
  std::string_view line() const { return {characters_.data(), characters_.size()}; }

 private:
  FixedVector<char, kLineBuffer> characters_;
  bool complete_ = false;
};

/// Host side: characters to replies. A Goto or Home shows itself when it is echoed
/// (MotionStarted); everything else comes with READY, told apart by the lines before it. A Home
/// and a Goto end alike: both as GotoDone. After garbage the lines up to READY are skipped.
class ReplyDecoder {
 public:
  std::optional<std::expected<Reply, Garbage>> push(char character);
  void reset();
  bool at_boundary() const { return characters_.empty() && seen_ == 0 && !hunting_; }

 private:
  std::optional<std::expected<Reply, Garbage>> take(const ReplyLine& line);
  std::optional<std::expected<Reply, Garbage>> finish();
  std::optional<std::expected<Reply, Garbage>> lose();

  Characters characters_;
  Status status_;
  std::uint16_t seen_ = 0;  ///< one bit for each kind of line of this reply, by its place
  bool hunting_ = false;
};

}  // namespace sinew::bigrobotarm::text
