#pragma once

#include "sinew/core/instant.h"

/// How often a session looks, whatever it runs.
namespace sinew::runtime {

/// No longer asleep than this, so that Ctrl-C and a lost port are seen.
inline constexpr Duration kSliceMax = std::chrono::milliseconds(50);
/// While a motion is streamed the driver is asked this often whether it takes the next segment.
inline constexpr Duration kFeedInterval = std::chrono::milliseconds(2);
/// A stopped driver may still have to say so to its device.
inline constexpr Duration kSettleMax = std::chrono::seconds(5);

}  // namespace sinew::runtime
