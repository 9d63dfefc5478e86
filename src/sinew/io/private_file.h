#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sinew/io/io_error.h"

namespace sinew::io {

/// Fills it with what nobody can guess, from the kernel.
IoResult<void> fill_unguessable(std::span<std::uint8_t> bytes);

/// A secret that a file keeps for this user alone (mode 0600), at most 4 KiB. Where the file is not
/// there yet it is made, with its folder, and holds `fresh` from then on; of two processes that do
/// so at the same time one wins, and both read the same.
/// @error  others may read it, it is somebody else's, a link, or no plain file; the disk's
IoResult<std::string> keep_private(const std::string& path, const std::string& fresh);

}  // namespace sinew::io
