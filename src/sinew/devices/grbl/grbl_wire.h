#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

#include "sinew/core/fixed_vector.h"

/// The wire of GRBL 1.1 and of its successors grblHAL and FluidNC: lines of G-code, each answered
/// by one reply; single real-time characters between them, without a reply; and status reports
/// in pointed brackets. No checksum. docs/wires/grbl.md has the tables.
/// Lengths are mm and angles deg, as the board's own settings have them, to three decimals. @rt
namespace sinew::grbl {

inline constexpr std::size_t kAxesMax = 6;
inline constexpr std::array<char, kAxesMax> kAxisLetters{'X', 'Y', 'Z', 'A', 'B', 'C'};
/// Characters of a line that every board takes, without its end (GRBL 1.1; grblHAL takes 256).
inline constexpr std::size_t kLineMax = 79;
/// The longest line of a board: a status report of six axes with all of its fields, and a welcome.
inline constexpr std::size_t kReplyMax = 256;
/// The largest value that a line of six axes has room for.
inline constexpr double kValueMax = 9999;
/// Of a motion: GRBL's F word in G93 is one over minutes.
inline constexpr double kDurationMin = 1e-3;  // s
inline constexpr double kDurationMax = 6e4;   // s: below it F would be 0.000

using Line = FixedVector<char, kReplyMax>;
using Values = FixedVector<double, kAxesMax>;
/// Axes as a bit each, X first.
using AxisMask = std::uint8_t;

/// Single characters, in effect at once, wherever they stand between others.
enum class RealTime : std::uint8_t {
  kReset = 0x18,  ///< ends everything; a motion is cut off where it is
  kStatus = '?',
  kHold = '!',  ///< brakes on the path
  kResume = '~',
  kJogCancel = 0x85,
};

// Requests.

/// One straight motion of all axes to machine coordinates, in this time.
struct Move {
  Values to;
  double duration = 1;  ///< s
  friend bool operator==(const Move&, const Move&) = default;
};
/// A motion that kJogCancel ends. Only while the board is idle.
struct Jog {
  std::size_t axis = 0;
  double by = 0;    ///< mm or deg
  double rate = 0;  ///< per min
  friend bool operator==(const Jog&, const Jog&) = default;
};
/// One axis until the probe input closes, or by so much. Answered at standstill. Moves are relative
/// afterwards, until the modes are set again. An input that is already closed is an alarm.
struct Probe {
  std::size_t axis = 0;
  double by = 0;    ///< mm or deg
  double rate = 0;  ///< per min
  friend bool operator==(const Probe&, const Probe&) = default;
};
struct Home {
  AxisMask axes = 0;  ///< one axis (grblHAL, FluidNC); 0: the board's own cycle
  friend bool operator==(const Home&, const Home&) = default;
};
/// Leaves an alarm; its position is not known then.
struct Unlock {
  friend bool operator==(const Unlock&, const Unlock&) = default;
};
struct AskSettings {
  friend bool operator==(const AskSettings&, const AskSettings&) = default;
};
struct AskBuild {
  friend bool operator==(const AskBuild&, const AskBuild&) = default;
};
/// Metric, absolute, rates per minute: a board keeps these until its next reset.
struct Modes {
  friend bool operator==(const Modes&, const Modes&) = default;
};
/// Of work coordinates along Z: a board forgets it with its power, and no machine coordinate knows
/// it.
struct ToolOffset {
  double z = 0;  ///< mm or deg
  friend bool operator==(const ToolOffset&, const ToolOffset&) = default;
};
using Request =
    std::variant<Move, Jog, Probe, Home, Unlock, AskSettings, AskBuild, Modes, ToolOffset>;

// Replies.

struct Ok {
  friend bool operator==(const Ok&, const Ok&) = default;
};
/// The line was not carried out.
struct Refused {
  std::uint16_t code = 0;
  friend bool operator==(const Refused&, const Refused&) = default;
};
/// Everything has ended, and no motion is taken before it is unlocked or homed.
struct Alarm {
  std::uint16_t code = 0;
  friend bool operator==(const Alarm&, const Alarm&) = default;
};

enum class Firmware : std::uint8_t { kGrbl, kGrblHal, kFluidNc };
/// It has just begun: behind power-up, a reset, or an opened port.
struct Welcome {
  Firmware firmware = Firmware::kGrbl;
  std::uint16_t major = 1;
  std::uint16_t minor = 1;
  friend bool operator==(const Welcome&, const Welcome&) = default;
};

enum class State : std::uint8_t {
  kIdle,
  kRun,
  kHold,
  kJog,
  kAlarm,
  kDoor,
  kCheck,
  kHome,
  kSleep,
  kTool,
};

/// What a pin report shows as active.
struct Pins {
  AxisMask limits = 0;
  bool probe = false;
  bool door = false;
  bool hold = false;
  bool reset = false;
  bool start = false;
  bool emergency_stop = false;  ///< grblHAL
  friend bool operator==(const Pins&, const Pins&) = default;
};

struct Status {
  /// What a board has room for.
  struct Room {
    std::uint16_t blocks = 0;  ///< motions
    std::uint16_t bytes = 0;   ///< of its receive buffer
    friend bool operator==(const Room&, const Room&) = default;
  };

  State state = State::kIdle;
  /// kHold: 0 at rest, 1 braking. kDoor: likewise, and more. kAlarm: its code (grblHAL). 0 without.
  std::uint16_t detail = 0;
  bool work = false;  ///< `position` is in work coordinates: machine - offset
  Values position;
  std::optional<Values> offset = {};  ///< work coordinates' own; in some reports only
  std::optional<Room> room = {};
  std::optional<Pins> pins = {};  ///< nothing: none is active, or the board reports none
  friend bool operator==(const Status&, const Status&) = default;
};

/// "$110=500.000"
struct Setting {
  std::uint16_t number = 0;
  double value = 0;
  friend bool operator==(const Setting&, const Setting&) = default;
};
/// "[OPT:V,15,128]", also with the number of axes behind it (grblHAL).
struct Build {
  std::uint16_t blocks = 0;
  std::uint16_t bytes = 0;
  std::uint8_t axes = 0;  ///< 0: not reported
  friend bool operator==(const Build&, const Build&) = default;
};
/// "[PRB:1.000,2.000,3.000:1]": machine coordinates where the probe closed; 0: where it did not,
/// they are where the way ended.
struct Probed {
  Values at;
  bool touched = false;
  friend bool operator==(const Probed&, const Probed&) = default;
};
/// Any other line.
struct Note {
  friend bool operator==(const Note&, const Note&) = default;
};
using Reply = std::variant<Ok, Refused, Alarm, Welcome, Status, Setting, Build, Probed, Note>;

std::string_view word_of(State state);

/// Motors stay on at rest where it is 255; else they go off after so many ms.
inline constexpr std::uint16_t kIdleSetting = 1;
/// 1: positions are reported in inches, of axes that turn too.
inline constexpr std::uint16_t kInchSetting = 13;
/// Settings of the first axis, the others follow: steps per unit, its maximum rate (per min), its
/// acceleration (per s^2), its travel.
inline constexpr std::uint16_t kStepsSetting = 100;
inline constexpr std::uint16_t kRateSetting = 110;
inline constexpr std::uint16_t kAccelerationSetting = 120;
inline constexpr std::uint16_t kTravelSetting = 130;

/// With its end.
/// @pre every value within kValueMax, the duration within its bounds, 1 to kAxesMax values
Line encode(const Request& request);
/// Nothing where it is no such line. @param line  without its end
std::optional<Request> decode_request(std::string_view line);

/// With its end.
Line encode(const Reply& reply);
/// Nothing where a line begins like a reply and is damaged; a Note where it begins like none.
/// @param line  without its end
std::optional<Reply> decode_reply(std::string_view line);

/// Characters of a stream to lines.
class LineDecoder {
 public:
  enum class Result : std::uint8_t {
    kMore,
    kLine,     ///< line() is valid until the next push(); never empty
    kDamaged,  ///< a line has ended that was too long, or had characters that no line has
  };

  Result push(std::uint8_t byte);
  std::string_view line() const { return {text_.data(), text_.size()}; }
  /// No line has begun.
  bool at_boundary() const { return complete_ || (text_.empty() && !damaged_); }
  void reset() { *this = {}; }

 private:
  FixedVector<char, kReplyMax> text_;
  bool damaged_ = false;
  bool complete_ = false;
};

}  // namespace sinew::grbl
