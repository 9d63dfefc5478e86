#pragma once

#include <string_view>

#include "sinew/io/io_error.h"

namespace sinew::io {

/// Call first of all. Where stdin, stdout or stderr was closed by the caller, nothing else (a
/// port!) may get its number, or text for people would go there; and a reader that went away (`|
/// head`) is an error of the write, not the end of a process that has an arm in motion.
void hold_standard_streams();

/// Writes to stdout and sees to it that it arrived. @error closed, full, the reader went away
IoResult<void> write_stdout(std::string_view text);

/// Somebody is looking: stderr is a terminal.
bool stderr_is_terminal();
/// Somebody can type.
bool stdin_is_terminal();

}  // namespace sinew::io
