#include "sinew/devices/axis/axis_device_step_check.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

constexpr double kRampTime = 0.1;    // s: so slow that the joint is not thrown through its play
constexpr double kSettleTime = 0.1;  // s: some periods of the rotor's oscillation
constexpr double kTolerance = 0.5;   // of a full step: load, microstepping and the encoder's own

}  // namespace

void StepCheck::start(double motor_angle) {
  phase_ = Phase::kOut;
  time_ = 0;
  start_angle_ = motor_angle;
}

double StepCheck::turn() const {
  const double share = std::min(1.0, time_ / kRampTime);
  switch (phase_) {
    case Phase::kOut:
      return step_ * share;
    case Phase::kBack:
      return step_ * (1 - share);
    case Phase::kIdle:
      break;
  }
  return 0;
}

std::optional<bool> StepCheck::tick(double motor_angle, double dt) {
  if (phase_ == Phase::kIdle) return std::nullopt;
  time_ += dt;
  if (time_ < kRampTime + kSettleTime) return std::nullopt;
  const double turned = motor_angle - start_angle_;
  time_ = 0;
  if (phase_ == Phase::kOut) {
    followed_ = std::abs(turned - step_) <= kTolerance * step_;
    phase_ = Phase::kBack;
    return std::nullopt;
  }
  phase_ = Phase::kIdle;
  return followed_ && std::abs(turned) <= kTolerance * step_;
}

}  // namespace sinew
