#pragma once

namespace sinew::io {

/// This thread, and those that it starts, get less of the processor than the others of the process
/// where there is not enough for all.
void let_others_go_first();

}  // namespace sinew::io
