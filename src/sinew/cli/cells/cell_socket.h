#pragma once

#include <optional>
#include <string>

#include "sinew/io/io_error.h"

namespace sinew::cli {

/// Where a running cell answers: `given`, or this user's own place.
/// @error  that place cannot be had
io::IoResult<std::string> cell_socket(const std::optional<std::string>& given);

}  // namespace sinew::cli
