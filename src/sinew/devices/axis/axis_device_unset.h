#pragma once

#include "sinew/devices/axis/axis_device.h"

namespace sinew {

/// The axis of a board that was never set up: it knows nothing and moves nothing. @rt
class UnsetAxis final : public Axis {
 public:
  AxisStatus status() const override { return {.motor_ok = false, .sensor_ok = false}; }
  AxisVerdict home() override { return AxisVerdict::kFaulted; }
  void cancel_homing() override {}
  AxisVerdict move_to(double /*q*/) override { return AxisVerdict::kFaulted; }
  AxisVerdict track(double /*q*/, double /*qd*/) override { return AxisVerdict::kFaulted; }
  void stop(AxisFault /*why*/) override {}
  void emergency_stop() override {}
  void release_emergency_stop() override {}
  void clear_faults() override {}
  void self_test() override {}
};

}  // namespace sinew
