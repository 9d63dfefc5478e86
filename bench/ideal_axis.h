#pragma once

#include "sinew/devices/axis/axis_device.h"
#include "sinew/model/robot_model.h"

namespace sinew::bench {

/// An axis that is at once where it is told to be, so that only the wire is measured.
class IdealAxis final : public Axis {
 public:
  AxisStatus status() const override {
    AxisStatus status;
    status.q = status.q_target = q_;
    status.position_ok = status.homed = true;
    return status;
  }
  AxisVerdict home() override { return AxisVerdict::kAccepted; }
  void cancel_homing() override {}
  AxisVerdict move_to(double q) override { return track(q, 0); }
  AxisVerdict track(double q, double) override {
    q_ = q;
    return AxisVerdict::kAccepted;
  }
  void stop(AxisFault) override {}
  void emergency_stop() override {}
  void release_emergency_stop() override {}
  void clear_faults() override {}
  void self_test() override {}

 private:
  double q_ = 0;
};

/// A joint that may do whatever a benchmark asks for.
inline Joint free_joint() {
  Joint joint;
  joint.lower = -6;
  joint.upper = 6;
  joint.velocity_max = 10;
  joint.acceleration_max = 100;
  joint.jerk_max = 1000;
  return joint;
}

}  // namespace sinew::bench
