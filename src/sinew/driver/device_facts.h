#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <variant>

#include "sinew/core/error.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/model/device.h"
#include "sinew/model/robot_model.h"
#include "sinew/wire/axis_link.h"
#include "sinew/wire/axis_registers.h"
#include "sinew/wire/bigrobotarm.h"
#include "sinew/wire/icp.h"
#include "sinew/wire/lsc.h"
#include "sinew/wire/maxarm.h"

/// What each device has told of itself last: plain data, as its wire has it.
namespace sinew {

/// Something that was said, and when.
template <class What>
struct Heard {
  What what{};
  Instant at{};
};
template <class What>
using LastHeard = std::optional<Heard<What>>;

/// The hexapod's motor modules.
struct IcpFacts {
  struct Leg {
    LastHeard<icp::Status> status;
    /// The last one that told of trouble: a module forgets its flags as it tells them.
    LastHeard<icp::Status> troubled;
  };
  std::array<Leg, kLegs> legs;
};

/// The LeArm's servo board.
struct LscFacts {
  LastHeard<lsc::Move> told;  ///< the host's last frame of targets
  LastHeard<lsc::Battery> battery;
  LastHeard<lsc::Version> version;
  LastHeard<lsc::ServoValues> positions;  ///< bus: measured; ESP32: where its pulses are
  LastHeard<lsc::GroupStarted> group_started;
  LastHeard<lsc::GroupFinished> group_finished;
  LastHeard<lsc::GroupStopped> group_stopped;
};

struct MaxArmFacts {
  LastHeard<maxarm::Angles> angles;
  LastHeard<maxarm::Position> position;
  LastHeard<maxarm::SetAngle> set;           ///< what the servos were sent to
  std::optional<maxarm::Checksum> checksum;  ///< once two answers agree
};

struct BigRobotArmFacts {
  BigRobotArmWire wire{};
  BigRobotArmDialect dialect{};
  LastHeard<bigrobotarm::Status> status{};
  bool looks_like_boot = false;    ///< it holds what a board holds that was switched on
  bool wants_declaration = false;  ///< no move before somebody says where the arm stands
};

/// What a register holds.
struct AxisRegisterValue {
  axis_registers::Data data;
  bool written = false;  ///< by the host, and taken; else it was read
};

/// The boards of the register wire.
struct AxisRegistersFacts {
  /// By place in axis_registers::kDocumentRegisters.
  static constexpr std::size_t kRegisters = axis_registers::kDocumentRegisters.size();
  struct Axis {
    bool answers = false;
    std::optional<Error> fault;
    std::array<LastHeard<AxisRegisterValue>, kRegisters> registers;
  };
  FixedVector<Axis, kMaxJoints> axes;
};

/// The axes of Sinew's own link.
struct AxisLinkFacts {
  struct Axis {
    bool up = false;
    std::optional<Error> fault;  ///< why it is out
    LastHeard<axis_link::State> state;
    LastHeard<axis_link::Identity> identity;
    LastHeard<axis_link::Health> health;
    std::optional<double> setpoint;    ///< rad, what its last frame asked for
    std::optional<double> zero_shift;  ///< rad
    std::uint64_t failed_frames = 0;
  };
  FixedVector<Axis, kMaxJoints> axes;
  Duration round{};  ///< from one frame of an axis to its next
};

using DeviceFacts = std::variant<std::monostate, IcpFacts, LscFacts, MaxArmFacts, BigRobotArmFacts,
                                 AxisRegistersFacts, AxisLinkFacts>;

}  // namespace sinew
