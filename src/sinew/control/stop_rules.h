#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "sinew/core/error.h"
#include "sinew/core/instant.h"

namespace sinew::control {

/// Why a machine is brought to rest.
enum class StopCause : std::uint8_t {
  kClient,        ///< somebody said stop
  kPause,         ///< somebody wants to go on later
  kTakeOver,      ///< another client takes the lease
  kLeaseEnded,    ///< its holder is silent, or gave it back in the middle
  kRefused,       ///< a piece of the motion was refused: by its maker, the governor or the driver
  kDevice,        ///< the driver says that something is wrong
  kNotRecorded,   ///< the position journal cannot be written any more
  kRecordLate,    ///< its disk is slow: the motion would reach the end of what is recorded
  kCycleOverrun,  ///< the host was late twice in a row
  kClockGap,      ///< the host was away: suspended, or starved
  kShutdown,      ///< the program ends, or nobody wants the machine any more
};
inline constexpr std::size_t kStopCauses = 11;

/// How it is brought to rest. Where a device takes whole moves, or the motion has no path that it
/// could brake on, both are the device's own stop, at the end of a piece or at once.
enum class StopManner : std::uint8_t {
  kOnPath,  ///< along the way, inside all limits; nothing is told to the device but shorter pieces
  kDevice,  ///< Driver::stop(): whatever the wire and the device do soonest
};

/// What state it is in behind a stop.
enum class StopAfter : std::uint8_t { kReady, kHeld, kFault };

/// A stop after IEC 60204-1: the cause says the category, the manner and what follows.
struct StopRule {
  StopCause cause;
  StopCategory category;  ///< kNone: that of the error's own row in the table of errors
  StopManner manner;
  StopAfter after;
  std::string_view name;      ///< stable, for machines
  std::string_view sentence;  ///< for people; empty where they said it themselves
};

/// The one table. docs/control.md shows it, and a test holds the two against each other. @rt
const StopRule& stop_rule(StopCause cause);
/// Of a stop with this cause and reason. @rt
StopCategory stop_category(StopCause cause, const std::optional<Error>& reason);

}  // namespace sinew::control
