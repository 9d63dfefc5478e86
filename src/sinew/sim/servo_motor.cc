#include "sinew/sim/servo_motor.h"

#include <algorithm>
#include <cmath>

namespace sinew::sim {
namespace {

constexpr double kStepMax = 1e-3;     // s; the motor's own time constant is some 10 ms
constexpr double kWakingRatio = 0.5;  // of the supply
constexpr double kRestSpeed = 1e-4;   // rad/s

}  // namespace

void ServoMotor::unblock() {
  block_lower_ = -1e9;
  block_upper_ = 1e9;
}

void ServoMotor::advance(double target, bool driven, double load, double dt) {
  if (dt <= 0) return;
  // Long rests are common and change nothing.
  const bool quiet = !driven || std::abs(target - angle_) < drive_.deadband;
  if (quiet && std::abs(speed_) < kRestSpeed && std::abs(load) <= drive_.friction) {
    speed_ = 0;
    effort_ = 0;
    return;
  }
  const double steps = std::ceil(dt / kStepMax);
  for (int i = 0; i < static_cast<int>(steps); ++i) step(target, driven, load, dt / steps);
}

void ServoMotor::step(double target, bool driven, double load, double h) {
  const bool awake = driven && supply_ratio_ >= kWakingRatio;
  const double error = target - angle_;
  double drive = 0;
  if (awake && std::abs(error) > drive_.deadband) {
    const double wanted = error / drive_.full_drive_error * stiffness_;
    drive = supply_ratio_ * std::clamp(wanted, -torque_, torque_);
  }
  effort_ = std::abs(drive - speed_ / drive_.no_load_speed);
  // Back-EMF as a damper, taken implicitly: it is stiff against the small inertia.
  const double damping = awake ? drive_.stall_torque / drive_.no_load_speed : 0;
  const double push = drive_.stall_torque * drive + load;
  double speed = (speed_ + h * push / drive_.inertia) / (1 + h * damping / drive_.inertia);
  const double grip = h * drive_.friction / drive_.inertia;
  speed = std::abs(speed) <= grip ? 0 : speed - std::copysign(grip, speed);
  speed_ = speed;
  angle_ += h * speed_;
  const double lower = std::max(drive_.end_lower, block_lower_);
  const double upper = std::min(drive_.end_upper, block_upper_);
  at_end_ = angle_ <= lower || angle_ >= upper;
  if (at_end_) {
    angle_ = std::clamp(angle_, lower, upper);
    speed_ = 0;
  }
}

}  // namespace sinew::sim
