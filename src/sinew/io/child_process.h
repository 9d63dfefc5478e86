#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/instant.h"
#include "sinew/io/io_error.h"

namespace sinew::io {

/// How another program has ended.
struct ProgramEnd {
  int exit = 0;        ///< 128 and more: killed by a signal, or it took too long
  std::string output;  ///< the last 64 KiB of what it wrote, to stdout and stderr
};

/// Whether a program of that name can be run.
bool has_program(const std::string& name);

/// Runs another program to its end. Its stdin is empty, and Ctrl-C does not reach it: what writes
/// into a board's flash is not ended half way.
/// @param arguments  its name first, which is looked for as a shell does
/// @param on_output  called for each piece of its output, as it comes
/// @param limit  it is killed then
/// @error  it cannot be run
IoResult<ProgramEnd> run_program(const std::vector<std::string>& arguments, Duration limit,
                                 const std::function<void(std::string_view)>& on_output = {});

}  // namespace sinew::io
