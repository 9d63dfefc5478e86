#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace sinew::control {

/// What a robot is doing, as far as anybody may ask it to do something.
enum class MachineState : std::uint8_t {
  kOff,         ///< nothing leaves but questions; nobody has asked for more
  kEnabling,    ///< its device is being found (again), and asked where it stands
  kReady,       ///< at rest, takes commands
  kMoving,      ///< on a motion that was granted
  kStopping,    ///< coming to rest, whatever comes behind that
  kHeld,        ///< at rest in the middle of a motion, which can go on
  kFault,       ///< at rest for good, until somebody has acknowledged why
  kRecovering,  ///< on a motion that finds its position again: homing, a slow first move
};
inline constexpr std::size_t kMachineStates = 8;

/// What may change it.
enum class Signal : std::uint8_t {
  kEnable,       ///< a client wants the machine
  kEnabled,      ///< the device answers and has said where it stands
  kDoubt,        ///< at rest, and the device is being looked for again
  kBegin,        ///< a motion was granted
  kRecover,      ///< the same for one that finds the position again
  kArrived,      ///< that motion ended as it should
  kHold,         ///< pause
  kStop,         ///< by anybody, for any cause
  kRested,       ///< it has come to rest: nothing more to do
  kRestedHeld,   ///< .. with a motion to go on with
  kRestedFault,  ///< .. with a cause that is latched
  kResume,       ///< the held motion goes on
  kFault,        ///< a cause was latched while nothing moved
  kAcknowledge,  ///< its cause is gone and somebody has said so
  kDisable,      ///< nobody wants the machine any more
};
inline constexpr std::size_t kSignals = 15;

struct Transition {
  MachineState from;
  Signal signal;
  MachineState to;
};

/// All there are: a signal that stands in no row of a state changes nothing there. docs/control.md
/// draws it, and a test holds the two against each other.
inline constexpr std::array kTransitions = std::to_array<Transition>({
    {MachineState::kOff, Signal::kEnable, MachineState::kEnabling},
    {MachineState::kOff, Signal::kFault, MachineState::kFault},
    {MachineState::kEnabling, Signal::kEnabled, MachineState::kReady},
    {MachineState::kEnabling, Signal::kFault, MachineState::kFault},
    {MachineState::kEnabling, Signal::kDisable, MachineState::kOff},
    {MachineState::kReady, Signal::kBegin, MachineState::kMoving},
    {MachineState::kReady, Signal::kRecover, MachineState::kRecovering},
    {MachineState::kReady, Signal::kDoubt, MachineState::kEnabling},
    {MachineState::kReady, Signal::kFault, MachineState::kFault},
    {MachineState::kReady, Signal::kDisable, MachineState::kOff},
    {MachineState::kMoving, Signal::kArrived, MachineState::kReady},
    {MachineState::kMoving, Signal::kHold, MachineState::kStopping},
    {MachineState::kMoving, Signal::kStop, MachineState::kStopping},
    {MachineState::kRecovering, Signal::kArrived, MachineState::kReady},
    {MachineState::kRecovering, Signal::kStop, MachineState::kStopping},
    {MachineState::kStopping, Signal::kRested, MachineState::kReady},
    {MachineState::kStopping, Signal::kRestedHeld, MachineState::kHeld},
    {MachineState::kStopping, Signal::kRestedFault, MachineState::kFault},
    {MachineState::kHeld, Signal::kResume, MachineState::kMoving},
    {MachineState::kHeld, Signal::kStop, MachineState::kReady},
    {MachineState::kHeld, Signal::kDoubt, MachineState::kEnabling},
    {MachineState::kHeld, Signal::kFault, MachineState::kFault},
    {MachineState::kHeld, Signal::kDisable, MachineState::kOff},
    {MachineState::kFault, Signal::kAcknowledge, MachineState::kOff},
});

/// Nothing where the signal changes nothing. @rt
constexpr std::optional<MachineState> next_state(MachineState state, Signal signal) {
  for (const Transition& row : kTransitions) {
    if (row.from == state && row.signal == signal) return row.to;
  }
  return std::nullopt;
}

/// Whether a motion may be under way.
constexpr bool may_move(MachineState state) {
  return state == MachineState::kMoving || state == MachineState::kRecovering ||
         state == MachineState::kStopping;
}

/// Stable, for machines: "off", "enabling", ...
std::string_view name(MachineState state);
std::string_view name(Signal signal);

}  // namespace sinew::control
