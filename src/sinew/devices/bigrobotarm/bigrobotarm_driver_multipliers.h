#pragma once

#include "sinew/core/error.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire.h"
#include "sinew/model/device.h"

namespace sinew {

/// What a status shows of its board's past.
enum class BigRobotArmStart : std::uint8_t {
  kNone,  ///< it runs on
  kKept,  ///< it started again, with its counters kept (our firmware does that)
  kAnew,  ///< it started again, or was switched on, and counts from 0
};

/// Speeds and accelerations of one move, hundredths of a motor revolution per s and s^2.
struct BigRobotArmMultipliers {
  bigrobotarm::Words speeds{};
  bigrobotarm::Words accelerations{};
};

/// Seconds that one joint's trapezoid takes over `steps` (either sign); both multipliers >= 1. @rt
double motion_time(const BigRobotArmJoint& joint, double steps, std::int32_t speed,
                   std::int32_t acceleration);

/// Share 0..1 of the way that the same trapezoid has gone t seconds after its start. @rt
double motion_share(const BigRobotArmJoint& joint, double steps, std::int32_t speed,
                    std::int32_t acceleration, double t);

/// Multipliers with which all joints arrive together, none faster than `base`: what the device's
/// own sync mode should do, which this host never uses because it counts in a frame of its own.
/// The slowest joint keeps its base values unless `at_least` asks for more time; a joint that
/// stands still keeps them too. Values that
/// the byte wire cannot carry (13, 269, ...) are stepped over downwards.
///
/// @param deltas    microsteps to go, either sign.
/// @param at_least  s; the motion shall not take less. Where that slows it on purpose (by 5 % and
///                  more) no joint accelerates harder than its base profile slowed evenly.
/// @return  motion times as near to the slowest joint's as whole multipliers come: within 3 % for
///          ways of half a motor revolution to five and base values of 100 and more; a way of a
///          few steps is over earlier, and base values below 10 leave little choice.
/// @error kMultiplierRange (index, base value, multiplier_max)
/// @rt      no allocation, no lock.
Expected<BigRobotArmMultipliers> synchronised_multipliers(const BigRobotArmDevice& device,
                                                          const bigrobotarm::Words& deltas,
                                                          const BigRobotArmMultipliers& base,
                                                          double at_least = 0);

/// `base`, its speed and acceleration raised alike for each joint that goes its way in `time` s no
/// slower than it was asked to, up to multiplier_max: a program may ask for more than the limits
/// that `base` stands for. @param time  s; 0: nothing is raised
BigRobotArmMultipliers raised(const BigRobotArmDevice& device, const bigrobotarm::Words& deltas,
                              BigRobotArmMultipliers base, double time);

/// Every value in 1..multiplier_max, and none that the device's wire would be cut by.
/// @error kMultiplierRange, kUnsendable; index: joint
Expected<void> check_multipliers(const BigRobotArmDevice& device,
                                 const bigrobotarm::Words& multipliers);

}  // namespace sinew
