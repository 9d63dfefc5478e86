#pragma once

#include "sinew/core/instant.h"

namespace sinew::arduino {

/// The time behind millis() and delay(); one for the process.
Instant now();
void pass(Duration time);
/// A new start at `now`, with millis() at `millis_now`.
void set_clock(Instant now, std::uint32_t millis_now);

}  // namespace sinew::arduino
