#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/lsc/lsc_wire.h"

namespace sinew {

/// The action groups of an LSC board: lists of timed moves in its memory, and the one that runs.
/// Groups survive a loss of power; speeds and what was running do not.
///
///   state    | run              | stop   | action over          | last action over
///   resting  | running          | stays  |                      |
///   running  | from its start   | resting| running, next action | next round, or resting
///
/// Nothing allocates. @rt
class LscGroups {
 public:
  static constexpr std::size_t kGroups = 16;      ///< that are held at once; real boards hold 230
  static constexpr std::size_t kActions = 64;     ///< in one group
  static constexpr std::uint8_t kGroupMax = 230;  ///< highest number

  /// Takes one action of a group; the first one (index 0) empties the group before.
  /// False where it does not fit.
  bool store(std::uint8_t group, std::size_t index, const lsc::Move& action);
  void erase(std::uint8_t group);
  void erase_all();
  /// False where no such group is held.
  bool has(std::uint8_t group) const { return find(group) != nullptr; }

  /// Of one group or all; 100 is as stored.
  void set_speed(std::uint8_t group, std::uint16_t percent);
  void forget_speeds();

  /// Starts it at `now`, instead of what runs. False where there is none to run.
  bool run(std::uint8_t group, std::uint16_t times, Instant now);
  /// False where none was running.
  bool stop();
  bool running() const { return running_; }
  std::uint8_t group() const { return group_; }
  std::uint16_t times() const { return times_; }

  /// What they are in the board's memory: for each group its number and its count of actions, for
  /// each action time_ms, its count of servos, and of those id and value; words low byte first.
  static constexpr std::size_t kActionBytes = 3 + 3 * lsc::kServosMax;
  static constexpr std::size_t kMemoryBytes = 1 + kGroups * (2 + kActions * kActionBytes);
  using Memory = FixedVector<std::uint8_t, kMemoryBytes>;
  Memory memory() const;
  /// False where that is no such memory; all groups are gone then.
  bool set_memory(std::span<const std::uint8_t> bytes);

  /// When the next action (or the end) is due.
  std::optional<Instant> due() const;
  /// The action that is due at due(), with its time at the present speed; nothing: the group is
  /// over, and rests.
  std::optional<lsc::Move> next();

 private:
  struct Group {
    std::uint8_t number = 0;
    std::uint16_t percent = 100;
    FixedVector<lsc::Move, kActions> actions;
  };

  const Group* find(std::uint8_t number) const;
  Group* find(std::uint8_t number);

  FixedVector<Group, kGroups> groups_;
  bool running_ = false;
  std::uint8_t group_ = 0;
  std::uint16_t times_ = 0;  ///< as asked; 0 for ever
  std::uint16_t rounds_left_ = 0;
  std::size_t place_ = 0;
  Instant due_{};
};

}  // namespace sinew
