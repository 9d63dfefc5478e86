#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/instant.h"
#include "sinew/core/split_mix.h"
#include "sinew/model/robot_model.h"
#include "sinew/sim/machine.h"

/// Faults of a byte link and blows to a machine, from one line of text: docs/faults.md.
namespace sinew::sim {

enum class LinkDirection : std::uint8_t { kToDevice, kToHost };

/// Chances of what may befall a byte, 0..1 each, drawn for every byte by itself.
struct ByteFaults {
  double drop = 0;
  double duplicate = 0;
  double flip = 0;  ///< one bit, any of the eight
  double delay = 0;
  Duration delay_time{};  ///< the byte and all behind it wait so long
  friend bool operator==(const ByteFaults&, const ByteFaults&) = default;
};

/// A time in which bytes vanish.
struct LinkCut {
  Duration at{};                      ///< since the link began
  std::optional<Duration> lasts;      ///< nothing: for ever
  std::optional<LinkDirection> only;  ///< nothing: both ways
  friend bool operator==(const LinkCut&, const LinkCut&) = default;
};

/// What befalls bytes from one moment on: one of them, or each with a chance.
struct TimedByteFault {
  enum class Kind : std::uint8_t { kDrop, kDuplicate, kFlip, kDelay } kind = Kind::kDrop;
  double chance = 1;
  Duration at{};                                     ///< since the link began
  bool once = false;                                 ///< the first byte from then on, no other
  std::optional<Duration> until = std::nullopt;      ///< nothing: for ever
  std::optional<LinkDirection> only = std::nullopt;  ///< nothing: both ways
  Duration delay_time{};                             ///< kDelay
  friend bool operator==(const TimedByteFault&, const TimedByteFault&) = default;
};

struct LinkFaultSpec {
  std::array<ByteFaults, 2> bytes;  ///< by LinkDirection; of every moment
  std::vector<TimedByteFault> timed;
  std::vector<LinkCut> cuts;
  std::uint64_t seed = 1;
  friend bool operator==(const LinkFaultSpec&, const LinkFaultSpec&) = default;
};

/// A disturbance and its moment since the run began.
struct TimedDisturbance {
  Duration at{};
  Disturbance what;
  /// kBlock, kProbe and kLoad: the kind of joint that the text's unit belongs to.
  std::optional<JointKind> unit = std::nullopt;
};

struct FaultPlan {
  LinkFaultSpec link;
  std::vector<TimedDisturbance> disturbances;  ///< in the order of the text
};

/// The grammar, items with commas between them, in any order, blanks allowed around them:
///
///     drop=P duplicate=P flip=P        [:to-host | :to-device]     P: 0..1 per byte
///     delay=P:TIME                     [:to-host | :to-device]
///     flip=P@TIME   flip=P@TIME..TIME  [..]   from then on, or in that span; so with drop,
///     delay=P:TIME@TIME..TIME          [..]   duplicate and delay
///     flip@TIME   delay@TIME:TIME      [..]   once: the first byte from that moment on
///     cut@TIME                         [:TIME]       both ways; without the second TIME for ever
///     half-open@TIME:to-host|to-device [:TIME]       that direction is dead
///     seed=N
///     supply=12V@TIME  payload=0.5kg@TIME  block=J2@20deg@TIME  unblock=J2@TIME
///     magnet=J3:off@TIME  magnet=J3:on@TIME  load=J1:0.5Nm@TIME
///     coupling=J3:slips@TIME  coupling=J3:holds@TIME  probe=J2@20deg@TIME
///
/// TIME is a number with ms, s or min; a block's and a probe's place has deg, rad, mm or m; a load
/// Nm or N. An error: an item that says again, or replaces, what an earlier one says of the same
/// moment; one that says nothing (a chance of 0, a cut of 0 s, a seed without a chance); a number
/// that is none, or outside the ranges of docs/faults.md; a text without an item.
/// @param joints  of the machine: J1 to as many.
/// @error  one sentence that names the item and says what would be right.
std::expected<FaultPlan, std::string> parse_faults(std::string_view text,
                                                   std::size_t joints = kMaxJoints);

/// Whether a plan's blows can befall this robot: its joints, their units, its magnets; what is
/// undone (unblock, a magnet put back) must have been done before.
/// @error  one sentence that names the item and says what would be right.
std::expected<void, std::string> check_faults(const FaultPlan& plan, const RobotModel& robot);

/// A text that parse_faults reads back as the same plan; empty, which it refuses, for a plan
/// without faults.
std::string to_text(const FaultPlan& plan);

/// What was done to the bytes of one direction. out + waiting = in - dropped - cut + duplicated.
struct LinkCounts {
  std::uint64_t in = 0;
  std::uint64_t out = 0;
  std::uint64_t dropped = 0;
  std::uint64_t duplicated = 0;
  std::uint64_t flipped = 0;
  std::uint64_t delayed = 0;
  std::uint64_t cut = 0;  ///< vanished in a cut, or found the link's buffer full
  friend bool operator==(const LinkCounts&, const LinkCounts&) = default;
};

/// Which of a plan's timed faults befall the byte (or transfer) that comes now. Draws of its own,
/// so that a plan's other chances fall as they would without it. @rt apart from its construction.
class TimedByteFaults {
 public:
  explicit TimedByteFaults(const LinkFaultSpec& spec);

  /// Whether one of that kind strikes what goes this way.
  /// @param direction  nothing: it goes both ways at once.
  /// @param since      since the link began; must not run back.
  /// @return  the delay of the one that struck, 0 for the other kinds; nothing where none did.
  std::optional<Duration> strikes(TimedByteFault::Kind kind, std::optional<LinkDirection> direction,
                                  Duration since);

 private:
  struct Entry {
    TimedByteFault fault;
    bool spent = false;
  };
  std::vector<Entry> entries_;
  std::array<SplitMix64, 2> random_;
};

/// A byte link with faults, in virtual time. Bytes of one direction keep their order. What befalls
/// a byte depends on the seed and on how many bytes went that way before, not on how they were
/// grouped, nor on the other direction. Without faults it is a wire without delay.
/// @rt apart from its construction.
class LinkFaults {
 public:
  static constexpr std::size_t kCapacity = 1U << 16U;  ///< bytes under way, each direction

  /// @param start  the moment from which the moments of the spec count.
  LinkFaults(const LinkFaultSpec& spec, Instant start);

  void push(LinkDirection direction, std::span<const std::uint8_t> bytes, Instant now);
  /// Moves what has arrived by `now` out; how many bytes.
  std::size_t take(LinkDirection direction, Instant now, std::span<std::uint8_t> out);
  /// When the next byte that is under way arrives.
  std::optional<Instant> next_event() const;
  const LinkCounts& counts(LinkDirection direction) const;

 private:
  struct Waiting {
    Instant arrives{};
    std::uint8_t byte = 0;
  };
  struct Lane {
    explicit Lane(std::uint64_t seed) : random(seed), ring(kCapacity) {}
    SplitMix64 random;
    std::vector<Waiting> ring;
    std::size_t first = 0;
    std::size_t size = 0;
    Instant last_arrival{};
    LinkCounts counts;
  };

  bool is_cut(LinkDirection direction, Instant now) const;
  static void enqueue(Lane& lane, std::uint8_t byte, Instant arrives);

  LinkFaultSpec spec_;
  TimedByteFaults timed_;
  Instant start_;
  std::array<Lane, 2> lanes_;
};

}  // namespace sinew::sim
