#pragma once

namespace sinew::io {

/// Somebody is looking: stderr is a terminal.
bool stderr_is_terminal();

}  // namespace sinew::io
