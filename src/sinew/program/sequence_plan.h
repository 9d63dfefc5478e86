#pragma once

#include <expected>
#include <string>
#include <variant>
#include <vector>

#include "sinew/core/error.h"
#include "sinew/core/instant.h"
#include "sinew/driver/bigrobotarm.h"
#include "sinew/driver/bigrobotarm_multipliers.h"
#include "sinew/model/robot_model.h"
#include "sinew/motion/trapezoid.h"
#include "sinew/program/sequence_file.h"

namespace sinew::sequence {

/// What the device is known to be set to when a plan begins, in its own units.
struct DeviceState {
  Words positions{};
  Words speeds{};
  Words accelerations{};
};

/// The state after power-up.
DeviceState boot_state(const BigRobotArmDevice& device);

// What the driver is asked to do, one after the other.

struct MoveOrder {
  BigRobotArmAngles q_start{};  ///< rad
  BigRobotArmAngles q{};        ///< rad, as it is sent
  /// rad, as the program asks; a step off where the wire cannot carry what it asks.
  BigRobotArmAngles q_asked{};
  bool home = false;
  /// The device's own profile of each joint, rad from q_start.
  std::array<motion::Trapezoid, kBigRobotArmJoints> profiles;
  double duration = 0;  ///< s, predicted
};
struct SpeedsOrder {
  Words multipliers{};
};
struct AccelerationsOrder {
  Words multipliers{};
};
struct GripperOrder {
  bool enabled = false;
  std::int32_t position = 0;
};
struct ResetOrder {};

struct Order {
  int line = 0;   ///< of the file, from 1
  int round = 1;  ///< of its block
  int rounds = 1;
  std::variant<MoveOrder, SpeedsOrder, AccelerationsOrder, GripperOrder, ResetOrder> what;
  /// Speeds and accelerations that the program has asked for by now, and those that the device has
  /// after this order: others, where they are scaled so that joints arrive together.
  BigRobotArmMultipliers wanted;
  BigRobotArmMultipliers set;
};

/// More would be days of motion; a file of this many repeats is a slip or an attack.
inline constexpr std::size_t kOrdersMax = 100'000;

struct Plan {
  std::vector<Order> orders;
  double duration = 0;  ///< s of motion, predicted
  std::size_t moves = 0;
};

/// Why a program cannot run: the first line whose order breaks a limit.
struct PlanRefusal {
  int line = 0;
  Error error;
};

/// Unrolls a program and predicts each move as the device will make it. Where the program asks for
/// synchronised joints, speeds and accelerations are scaled per move and put back afterwards.
///
/// On the byte wire a target that would be cut goes one step to the side, as the driver would do
/// with it; the plan goes on from there.
///
/// @param robot  a robot whose device is a BigRobotArm.
/// @error  kProgramTooLong, kJointLimit, kUnsendable, kMultiplierRange, kGripperRange, with the
/// line; nothing of the
///         program may run then.
std::expected<Plan, PlanRefusal> make_plan(const Program& program, const RobotModel& robot,
                                           const DeviceState& start);

}  // namespace sinew::sequence
