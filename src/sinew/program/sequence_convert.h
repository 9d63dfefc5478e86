#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/program/program_file.h"
#include "sinew/program/sequence_file.h"

namespace sinew::program {

/// A BigRobotArm sequence as rows of a program. Its counts are from where the arm was switched on,
/// which is taken to be the model's zero.
/// @param robot  whose device is a BigRobotArm
/// @error  each command that no row says: M203, M201, G92; a G0 whose joints do not arrive together
///         (before S1, or behind S0): a row's always do
std::expected<std::string, std::vector<Complaint>> rows_of_sequence(
    const sequence::Program& sequence, std::string_view file_name, const RobotModel& robot);

/// A program as a sequence, from home: joint rows at full speed, gripper, loops that are not nested
/// and fit the firmware.
/// @error  each row that no command says
std::expected<sequence::Program, std::vector<Complaint>> sequence_of_rows(const Program& program,
                                                                          const RobotModel& robot);

}  // namespace sinew::program
