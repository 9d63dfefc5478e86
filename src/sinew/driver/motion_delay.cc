#include "sinew/driver/motion_delay.h"

#include <variant>

namespace sinew {
namespace {

using namespace std::chrono_literals;

struct Delays {
  MotionDelay operator()(const NoDriver& /*none*/) const { return {}; }
  MotionDelay operator()(const BigRobotArmDevice& /*device*/) const { return {3ms, 17ms, 0ms}; }
  // One register frame takes 82 ms on the wire, whichever way it goes.
  MotionDelay operator()(const AxisRegistersDevice& /*device*/) const {
    return {74ms, 234ms, 82ms};
  }
  // The loop is that far behind its setpoint; the driver knows when the setpoint has arrived.
  MotionDelay operator()(const AxisLinkDevice& /*device*/) const { return {34ms, 2ms, 0ms}; }
  MotionDelay operator()(const LscDevice& device) const {
    // Boards that can be asked are asked when their servos have settled.
    return {36ms, device.profile == LscProfile::kLsc6 ? 109ms : 480ms, 0ms};
  }
  // Its MicroPython program looks at its port every 100 ms. Readings until two agree take a second.
  MotionDelay operator()(const MaxArmDevice& device) const {
    const bool polls = device.variant == MaxArmVariant::kMicroPython;
    return polls ? MotionDelay{98ms, 1300ms, 0ms} : MotionDelay{26ms, 1000ms, 0ms};
  }
  MotionDelay operator()(const IcpDevice& /*device*/) const { return {4ms, 113ms, 0ms}; }
};

}  // namespace

MotionDelay motion_delay(const Device& device) {
  return std::visit(Delays{}, device.settings);
}

}  // namespace sinew
