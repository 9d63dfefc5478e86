#pragma once

#include <tuple>
#include <utility>

#include "sinew/devices/arm_link/arm_link_settings.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/feetech/feetech_settings.h"
#include "sinew/devices/grbl/grbl_settings.h"
#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/model/device.h"

namespace sinew::test {

/// All kinds of devices: what only tests ask of each.
using DeviceKinds =
    std::tuple<IdealDevice, BigRobotArmDevice, AxisRegistersDevice, AxisLinkDevice, LscDevice,
               MaxArmDevice, IcpDevice, GrblDevice, FeetechDevice, ArmLinkDevice>;

/// Calls `visitor` with the settings as those of their kind, and returns what it does.
/// @param settings  const or not
template <class Visitor, class Settings, std::size_t Index = 0>
auto visit_kind(Visitor&& visitor, Settings& settings) {
  using Kind = std::tuple_element_t<Index, DeviceKinds>;
  if constexpr (Index + 1 < std::tuple_size_v<DeviceKinds>) {
    if (!settings.template is<Kind>()) {
      return visit_kind<Visitor, Settings, Index + 1>(std::forward<Visitor>(visitor), settings);
    }
  }
  return visitor(settings.template get<Kind>());
}

}  // namespace sinew::test
