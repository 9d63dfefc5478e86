#include <algorithm>
#include <array>

#include "sinew/devices/kinds.h"
#include "sinew/program/procedures/step_list.h"

namespace sinew::program {

// One line for each, in each of the two lists.
extern const FirstDay kArmLinkDay;
extern const FirstDay kAxisLinkDay;
extern const FirstDay kAxisRegistersDay;
extern const FirstDay kBigRobotArmDay;
extern const FirstDay kIcpDay;
extern const FirstDay kLscDay;
extern const FirstDay kMaxArmDay;

const FirstDay* first_day_of(const Device& device) {
  static constexpr std::array kAll{&kArmLinkDay,     &kAxisLinkDay, &kAxisRegistersDay,
                                   &kBigRobotArmDay, &kIcpDay,      &kLscDay,
                                   &kMaxArmDay};
  const std::string_view protocol = kind_of(device).table.protocol;
  const auto found = std::ranges::find(kAll, protocol, &FirstDay::protocol);
  return found != kAll.end() ? *found : nullptr;
}

}  // namespace sinew::program
