#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "sinew/sim/machine.h"

namespace sinew::sim {

/// A part of a joint that fails and is mended again: NAME=J3:BAD@2s, NAME=J3:GOOD@4s. Its
/// disturbance's value is 0 from where it fails, 1 from where it is mended.
struct FaultSwitch {
  Disturbance::Kind kind;
  std::string_view name;
  std::string_view bad;
  std::string_view good;
  std::string_view either;   ///< to who wrote neither
  std::string_view is_good;  ///< to who mends what has not failed
};

inline constexpr std::array<FaultSwitch, 3> kFaultSwitches{{
    {Disturbance::Kind::kMagnet, "magnet", "off", "on", "a magnet is on or off", "it is on"},
    {Disturbance::Kind::kCoupling, "coupling", "slips", "holds", "a coupling slips or holds",
     "it holds"},
    {Disturbance::Kind::kLead, "lead", "loose", "fast", "a lead is loose or fast", "it is fast"},
}};

/// @return  null where `kind` is none of them
constexpr const FaultSwitch* switch_of(Disturbance::Kind kind) {
  const auto* found = std::ranges::find(kFaultSwitches, kind, &FaultSwitch::kind);
  return found == kFaultSwitches.end() ? nullptr : found;
}

/// The item of a disturbance at a place of a joint (kBlock, kProbe).
constexpr std::string_view place_item(Disturbance::Kind kind) {
  return kind == Disturbance::Kind::kBlock ? "block" : "probe";
}

}  // namespace sinew::sim
