#pragma once

#include <expected>
#include <string>

#include "sinew/program/language/program_file.h"

namespace sinew::program {

/// The program from the row in this line of its own file on, for a run that is resumed there.
/// @error  a sentence: no row there, or it is inside a loop or an if, which cannot be entered
std::expected<Program, std::string> from_line(const Program& program, int line);

/// The program with every motion at this share (0, 1] of what its rows say: of the joints' speed,
/// and of the tool's where a row says one.
Program slowed(const Program& program, double share);

}  // namespace sinew::program
