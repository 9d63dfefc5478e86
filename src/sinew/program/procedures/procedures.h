#pragma once

#include <functional>
#include <map>
#include <string>

#include "sinew/core/units.h"
#include "sinew/program/plans/program_plan.h"
#include "sinew/program/procedures/procedure.h"

/// The procedures of the robots: which steps, in which order, with which words.
namespace sinew::program {

/// What a device tells beside positions, for those who are in one process with its driver.
/// @return  a word or a number as text; nothing where this device, or this place, does not tell
using DeviceFact = std::function<std::optional<std::string>(std::string_view what, std::size_t)>;

/// Finds the zeros twice, with the time that each joint's search took, and says what of it this
/// wire can show. Without end stops: moves to the home pose from a known position.
ProcedurePlan homing_procedure(const RobotModel& robot, const Homing& homing,
                               const DeviceFact& fact = {});

/// The way back to a position that may be planned with: homing where there are end stops, a slow
/// first move on servos, else joint by joint by hand to a place that somebody knows.
ProcedurePlan recovery_procedure(const RobotModel& robot, const Homing& homing);

/// The guided checklist for a robot's first day.
/// @error  a sentence: this robot has the ideal device
std::expected<ProcedurePlan, std::string> commissioning_procedure(const RobotModel& robot,
                                                                  const Homing& homing,
                                                                  const DeviceFact& fact);

/// The width that the jaws are sent to so that a person can say which way they count, m.
double jaws_tried(const RobotModel& robot);

/// What commissioning has found, by name: "joint.leg1.invert" = "yes".
using FoundSettings = std::map<std::string, std::string>;

/// What a procedure's results say of the device, where that is another than in the robot's file.
FoundSettings found_settings(const Procedure& procedure);

/// Puts them into the model's device.
/// @error  a sentence: a name or a value that does not belong to this robot
std::expected<void, std::string> use_settings(RobotModel& robot, const FoundSettings& settings);

}  // namespace sinew::program
