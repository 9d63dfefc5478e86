#pragma once

#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/complaint.h"
#include "sinew/model/robot_model.h"
#include "sinew/program/language/program_rows.h"

namespace sinew::program {

/// Plain G-code as the rows of a program; docs/programs.md has the words that are read. Zero is the
/// robot's base; nothing is skipped: what has no row is a complaint, a drawing's arc as well as an
/// axis that no arm has.
/// @return the text of a program, laid out; remarks are kept
/// @error  all complaints with line and column, up to a hundred
std::expected<Rows, std::vector<Complaint>> rows_of_gcode(std::string_view text,
                                                          std::string_view file_name,
                                                          const RobotModel& robot);

}  // namespace sinew::program
