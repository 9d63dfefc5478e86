#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"

/// The ideal device's wire: lines of text, each with a CRC-32C of what stands before it. One
/// request, one answer, which begins with the request's number. docs/wires/ideal.md has the table.
/// Lengths are whole micrometres, angles whole microradians, times whole microseconds, so that a
/// sketch needs no floating point. @rt
namespace sinew::ideal {

inline constexpr std::size_t kJointsMax = 8;
inline constexpr std::uint8_t kVersion = 1;
/// Silence of the host in a motion after which the device brakes by itself, and holds.
inline constexpr Duration kDeadline = std::chrono::milliseconds(100);
/// A move of eight joints with the longest numbers has 224 characters.
inline constexpr std::size_t kLineMax = 264;
using Line = FixedVector<std::uint8_t, kLineMax>;

/// One unit of the wire, rad, m or s.
inline constexpr double kMicro = 1e-6;
/// @pre |value| < 2147
std::int32_t micro(double value);

using Numbers = FixedVector<std::int32_t, kJointsMax>;

// What a host says.

struct Hello {
  friend bool operator==(const Hello&, const Hello&) = default;
};
struct Ask {
  friend bool operator==(const Ask&, const Ask&) = default;
};
/// One segment: from where the one before ends, along the cubic that ends at `q` with the speed
/// `qd`.
struct Move {
  std::uint16_t number = 0;  ///< one more than the move before it; the same again is no second move
  std::uint32_t duration_us = 0;
  Numbers q;   ///< urad or um
  Numbers qd;  ///< urad/s or um/s, as many
  friend bool operator==(const Move&, const Move&) = default;
};
struct Stop {
  friend bool operator==(const Stop&, const Stop&) = default;
};
/// Leaves Phase::kHeld.
struct Clear {
  friend bool operator==(const Clear&, const Clear&) = default;
};
struct Jaws {
  std::int32_t width_um = 0;
  friend bool operator==(const Jaws&, const Jaws&) = default;
};
using Request = std::variant<Hello, Ask, Move, Stop, Clear, Jaws>;

// What the device answers.

struct Identity {
  std::uint8_t version = kVersion;
  std::uint8_t joints = 0;
  std::uint16_t taken = 0;  ///< number of the last move that it took; 0 after a start
  friend bool operator==(const Identity&, const Identity&) = default;
};

enum class Phase : std::uint8_t {
  kRest,
  kMoving,
  kStopping,
  kHeld,  ///< stands, and takes no move before Clear
};
/// Why it holds.
enum class Held : std::uint8_t {
  kNo,
  kStarted,  ///< its power was away
  kSilent,   ///< the host said nothing for longer than the deadline
  kStarved,  ///< the moves ended, and the last one not at rest
  kBlocked,  ///< a joint met something
};

struct State {
  Phase phase = Phase::kRest;
  Held held = Held::kNo;
  std::uint8_t joint = 0;     ///< kBlocked: which
  std::uint16_t taken = 0;    ///< number of the last move that it took
  std::uint16_t done = 0;     ///< .. and of the last one that it carried out
  std::int32_t jaws_um = -1;  ///< between the jaws; -1 without a gripper
  Numbers q;
  Numbers qd;
  friend bool operator==(const State&, const State&) = default;
};

enum class Why : std::uint8_t {
  kBusy,    ///< eight moves are there, it stops, or it is held
  kNumber,  ///< neither the next number nor the last one again
  kLimit,   ///< a joint's range or speed; which is said
  kForm,    ///< the line's sum was right and its words were not
  kTool,    ///< no gripper, or not so wide
};
struct Refusal {
  Why why = Why::kForm;
  std::uint8_t joint = 0;  ///< kLimit
  friend bool operator==(const Refusal&, const Refusal&) = default;
};
using Reply = std::variant<Identity, State, Refusal>;

/// As they stand in a line.
std::string_view word_of(Phase phase);
std::string_view word_of(Held held);
std::string_view word_of(Why why);

/// A line's own number and what it says.
template <class What>
struct Numbered {
  std::uint16_t number = 0;
  What what;
  friend bool operator==(const Numbered&, const Numbered&) = default;
};

/// With sum and end of line.
Line encode(const Numbered<Request>& request);
Line encode(const Numbered<Reply>& reply);

/// @param words  of a line, without its sum. Nothing where they are no such message.
std::optional<Numbered<Request>> decode_request(std::string_view words);
std::optional<Numbered<Reply>> decode_reply(std::string_view words);

/// Characters to lines whose sum is right.
class LineDecoder {
 public:
  enum class Result : std::uint8_t { kMore, kLine, kDamaged };

  /// kLine: words() are valid until the next push(). kDamaged: a line has ended whose sum is wrong,
  /// or that was too long.
  Result push(std::uint8_t byte);
  std::string_view words() const { return {text_.data(), words_}; }
  bool at_boundary() const { return complete_ || (text_.empty() && !too_long_); }
  void reset() { *this = {}; }

 private:
  FixedVector<char, kLineMax> text_;
  std::size_t words_ = 0;
  bool too_long_ = false;
  bool complete_ = false;
};

}  // namespace sinew::ideal
