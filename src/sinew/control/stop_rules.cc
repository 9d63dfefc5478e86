#include "sinew/control/stop_rules.h"

#include <array>
#include <variant>

#include "sinew/core/assert.h"

namespace sinew::control {
namespace {

using namespace std::chrono_literals;

constexpr std::array kRules = std::to_array<StopRule>({
    {StopCause::kClient, StopCategory::kStopAndHold, StopManner::kDevice, StopAfter::kReady,
     "client"},
    {StopCause::kPause, StopCategory::kStopAndHold, StopManner::kOnPath, StopAfter::kHeld, "pause"},
    {StopCause::kTakeOver, StopCategory::kStopAndHold, StopManner::kOnPath, StopAfter::kHeld,
     "take_over"},
    {StopCause::kLeaseEnded, StopCategory::kStopAndHold, StopManner::kOnPath, StopAfter::kHeld,
     "lease_ended"},
    {StopCause::kRefused, StopCategory::kStopAndHold, StopManner::kDevice, StopAfter::kReady,
     "refused"},
    {StopCause::kDevice, StopCategory::kNone, StopManner::kDevice, StopAfter::kFault, "device"},
    {StopCause::kNotRecorded, StopCategory::kStopAndHold, StopManner::kOnPath, StopAfter::kFault,
     "not_recorded"},
    {StopCause::kRecordLate, StopCategory::kStopAndHold, StopManner::kOnPath, StopAfter::kHeld,
     "record_late"},
    {StopCause::kCycleOverrun, StopCategory::kStopAndHold, StopManner::kOnPath, StopAfter::kHeld,
     "cycle_overrun"},
    {StopCause::kClockGap, StopCategory::kStopAndHold, StopManner::kDevice, StopAfter::kFault,
     "clock_gap"},
    {StopCause::kShutdown, StopCategory::kStopAndHold, StopManner::kDevice, StopAfter::kReady,
     "shutdown"},
});
static_assert(kRules.size() == kStopCauses);

struct Facts {
  StopFacts operator()(const NoDriver& /*none*/) const { return {}; }
  StopFacts operator()(const BigRobotArmDevice& /*device*/) const {
    return {false, 0ms, "none: finishes its move",
            "steppers hold; without power the arm sinks or drops"};
  }
  StopFacts operator()(const AxisRegistersDevice& /*device*/) const {
    return {true, 300ms, "0.12 s until told, then the boards stop at once",
            "steppers hold; without power the arm drops: its gears do not hold it"};
  }
  StopFacts operator()(const AxisLinkDevice& /*device*/) const {
    return {true, 4100ms, "one frame until told, then the boards brake: up to 4 s at full speed",
            "steppers hold; without power the arm drops: its gears do not hold it"};
  }
  StopFacts operator()(const LscDevice& /*device*/) const {
    return {true, 400ms, "where the servos are when the stop frame has arrived, 26 ms",
            "servos hold; without power or pulses the arm drops"};
  }
  StopFacts operator()(const MaxArmDevice& /*device*/) const {
    return {true, 900ms, "0.13 to 0.6 s until told, then 0.1 s",
            "servos hold; without power the arm drops, and the pump lets go"};
  }
  StopFacts operator()(const IcpDevice& /*device*/) const {
    return {true, 20ms, "4.2 ms: the microstep under way", "spindles hold, with and without power"};
  }
};

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

StopFacts stop_facts(const Device& device) {
  return std::visit(Facts{}, device.settings);
}

}  // namespace sinew::control
