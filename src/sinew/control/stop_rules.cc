#include "sinew/control/stop_rules.h"

#include <array>

#include "sinew/core/assert.h"

namespace sinew::control {
namespace {

constexpr std::array kRules = std::to_array<StopRule>({
    {StopCause::kClient, StopCategory::kStopAndHold, StopManner::kDevice, StopAfter::kReady,
     "client", ""},
    {StopCause::kPause, StopCategory::kStopAndHold, StopManner::kOnPath, StopAfter::kHeld, "pause",
     "paused"},
    {StopCause::kTakeOver, StopCategory::kStopAndHold, StopManner::kOnPath, StopAfter::kHeld,
     "take_over", "another client took control"},
    {StopCause::kLeaseEnded, StopCategory::kStopAndHold, StopManner::kOnPath, StopAfter::kHeld,
     "lease_ended", "the client that had control is gone"},
    {StopCause::kRefused, StopCategory::kStopAndHold, StopManner::kDevice, StopAfter::kReady,
     "refused", "a part of the motion was refused"},
    {StopCause::kDevice, StopCategory::kNone, StopManner::kDevice, StopAfter::kFault, "device",
     "the device reported a fault"},
    {StopCause::kNotRecorded, StopCategory::kStopAndHold, StopManner::kOnPath, StopAfter::kFault,
     "not_recorded", "the position journal cannot be written"},
    {StopCause::kRecordLate, StopCategory::kStopAndHold, StopManner::kOnPath, StopAfter::kHeld,
     "record_late", "the disk of the position journal is too slow"},
    {StopCause::kCycleOverrun, StopCategory::kStopAndHold, StopManner::kOnPath, StopAfter::kHeld,
     "cycle_overrun",
     "this computer is too busy to control a motion; end other work on it and try again"},
    {StopCause::kClockGap, StopCategory::kStopAndHold, StopManner::kDevice, StopAfter::kFault,
     "clock_gap", "this computer was suspended, or too busy, in the middle of a motion"},
    {StopCause::kShutdown, StopCategory::kStopAndHold, StopManner::kDevice, StopAfter::kReady,
     "shutdown", "the controller ends"},
});
static_assert(kRules.size() == kStopCauses);

}  // namespace

const StopRule& stop_rule(StopCause cause) {
  const StopRule& rule = kRules[static_cast<std::size_t>(cause)];
  SINEW_ASSERT(rule.cause == cause);
  return rule;
}

StopCategory stop_category(StopCause cause, const std::optional<Error>& reason) {
  const StopCategory own = stop_rule(cause).category;
  return own == StopCategory::kNone && reason ? info(reason->code).stop : own;
}

}  // namespace sinew::control
