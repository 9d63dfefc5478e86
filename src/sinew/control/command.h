#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "sinew/control/lease.h"
#include "sinew/control/machine_state.h"
#include "sinew/control/motion_source.h"
#include "sinew/control/stop_rules.h"
#include "sinew/driver/driver.h"
#include "sinew/planning/jog/jog.h"

namespace sinew::control {

// What a client asks of a machine. All but those marked need the lease.

struct TakeLease {  ///< needs none
  bool take_over = false;
};
struct RenewLease {};
struct ReturnLease {};
struct Enable {};
struct Disable {};      ///< not while anything moves
struct Acknowledge {};  ///< the latched cause; needs it to be gone
/// A motion that was planned from where the machine stands. The controller uses it until the
/// command has ended.
struct Begin {
  MotionSource* motion = nullptr;
  /// A slow first move of a machine that does not know where it is.
  bool recovers = false;
};
/// Finds the zeros of all joints.
struct Home {
  /// Goes on with a search that was stopped: joints that it had found and that are known still are
  /// not searched again.
  bool resumes = false;
};
/// One joint a little and slowly, from wherever it is: what was known of the position moves along,
/// what was not known stays so.
struct Nudge {
  std::uint8_t joint = 0;
  double way = 0;  ///< rad or m, at most the device's nudge_max
  /// It ends where the device's probe input closes, and goes slower.
  bool probes = false;
};
/// A velocity, from now on; the first one begins a jog, which ends where none follows.
struct JogAt {
  planning::JogCommand velocity;
};
struct Hold {};  ///< needs none: who may stop may also hold
struct Resume {};
struct Stop {};  ///< needs none
struct SetFeed {
  double share = 1;
};
struct UseTool {
  ToolAction action;
};
/// Where the machine stands, from somebody who has looked.
struct Declare {
  FixedVector<JointPosition, kMaxJoints> positions;
  /// Somebody moved it by hand: what was known of the position does not count.
  bool moved = false;
  /// The device counts 0 there from now on, where it has such a command.
  bool zeroes_counters = false;
};
/// At rest. A self-test that fails is a fault of the machine.
struct Service {
  DeviceService what = DeviceService::kWake;
};

using CommandWhat =
    std::variant<TakeLease, RenewLease, ReturnLease, Enable, Disable, Acknowledge, Begin, Home,
                 Nudge, JogAt, Hold, Resume, Stop, SetFeed, UseTool, Declare, Service>;

struct Command {
  std::uint32_t id = 0;
  LeaseToken lease;  ///< of whom asks; its client counts even where no lease is needed
  CommandWhat what;
};

/// What a command asks for needs the lease, if it is not among those marked above.
inline bool needs_lease(const CommandWhat& what) {
  return !std::holds_alternative<TakeLease>(what) && !std::holds_alternative<Hold>(what) &&
         !std::holds_alternative<Stop>(what);
}

/// A cause of a fault, until somebody has acknowledged it.
struct Latched {
  StopCause cause = StopCause::kDevice;
  Error error;
};

/// What became of things. Each command ends with one of kRefused, kDone, kFailed and kStopped.
struct ControlEvent {
  enum class Kind : std::uint8_t {
    kRefused,  ///< the command: error says why; nothing has changed
    kStarted,  ///< the command: its motion or search is under way
    kDone,     ///< the command
    kFailed,   ///< the command: error
    kStopped,  ///< the command, and why: cause
    kLease,    ///< given, to whom (lease), or ended (epoch 0)
    kState,    ///< the machine's state is another one
    kStop,     ///< it is being brought to rest: cause, and error where there is one
    kLatched,  ///< a cause of a fault, the first or a later one: error, cause
    kNotice,   ///< the driver's: error
  } kind = Kind::kNotice;
  std::uint32_t command = 0;  ///< 0: of none
  MachineState state = MachineState::kOff;
  StopCause cause = StopCause::kClient;
  Error error;
  LeaseToken lease;
};

/// Nothing more is told of the command. @rt
constexpr bool is_end(ControlEvent::Kind kind) {
  using Kind = ControlEvent::Kind;
  return kind == Kind::kRefused || kind == Kind::kDone || kind == Kind::kFailed ||
         kind == Kind::kStopped;
}

}  // namespace sinew::control
