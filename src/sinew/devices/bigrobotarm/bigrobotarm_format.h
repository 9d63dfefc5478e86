#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_sequence.h"
#include "sinew/program/language/program_file.h"
#include "sinew/program/language/program_rows.h"

namespace sinew::program {

/// A BigRobotArm sequence as the rows of a program. Its counts begin at the model's zero, where the
/// document has the arm switched on; behind a G92 they begin where the arm is then.
/// Blocks with a G92, M203 or M201 are unrolled, since their rounds differ.
/// Notes: joints that arrive together here and do not there (without S1); an M203 or M201 beyond
/// the limits of the robot's file, which is limited to them.
/// @param robot  whose device is a BigRobotArm
Rows rows_of_sequence(const sequence::Program& sequence, const RobotModel& robot);

/// A program as a sequence, from home: joint rows at full speed, gripper, loops that are not nested
/// and fit the firmware.
/// @error  each row that no command says
std::expected<sequence::Program, std::vector<Complaint>> sequence_of_rows(const Program& program,
                                                                          const RobotModel& robot);

}  // namespace sinew::program
