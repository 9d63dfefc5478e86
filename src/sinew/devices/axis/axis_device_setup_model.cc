#include "sinew/devices/axis/axis_device_setup_model.h"

#include "sinew/core/assert.h"

namespace sinew {

AxisSetup axis_setup(const RobotModel& model, std::size_t joint) {
  SINEW_ASSERT(joint < model.joints.size());
  AxisSetup setup{.axis_number = static_cast<std::uint8_t>(joint),
                  .axis = axis_settings(model, joint),
                  .registers = {}};
  setup.registers.zero = model.joints[joint].lower;
  if (const auto* device = model.device.settings.as<AxisRegistersDevice>()) {
    setup.registers = axis_register_slave_settings(*device, joint);
  }
  return setup;
}

}  // namespace sinew
