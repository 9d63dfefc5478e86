#pragma once

#include "sinew/driver/driver.h"
#include "sinew/model/robot_model.h"
#include "sinew/program/procedures/procedures.h"

namespace sinew::runtime {

/// What a driver can tell of its device beside positions: "supply" (V), "minus_one" (FFFF, FFFE),
/// "wire", "checksum", "axis" (fine, or why not), "servo", "zero_shift_steps" and "zero_shift_deg"
/// (of two searches, where the wire shows it).
program::DeviceFact facts_of(const Driver& driver, const RobotModel& robot);

}  // namespace sinew::runtime
