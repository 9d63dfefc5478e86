#include "sinew/devices/axis_registers/axis_registers_settings.h"

#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/model/device.h"

namespace sinew {

void AxisRegistersDevice::use_profile(const std::string& name, Device& /*device*/) {
  // The first firmware's DIAG_STATUS is always 0.
  reports_status = name == "document";
}

void AxisRegistersDevice::use_wire(const std::string& name, Device& device) {
  if (name != "link") return;
  AxisLinkDevice link;
  link.boards = boards;
  device.protocol = "axis_link";
  device.capability = {MotionKind::kStream, PositionFeedback::kMeasured,
                       std::chrono::milliseconds(50), 0.8};
  device.settings = link;  // the end of these
}

}  // namespace sinew
