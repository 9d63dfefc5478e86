#pragma once

#include <cstdint>
#include <optional>

namespace sinew {

/// One full step to and fro, held against what the motor's encoder sees. The step is too small for
/// the joint to leave its backlash (0.1 deg at 17:1). @rt
class StepCheck {
 public:
  StepCheck() = default;
  /// @param step  rad of the motor's shaft, one full step
  explicit StepCheck(double step) : step_(step) {}

  void start(double motor_angle);
  void cancel() { phase_ = Phase::kIdle; }
  bool running() const { return phase_ != Phase::kIdle; }
  /// What the field shall be turned by, from where it stood at start(); rad of the motor.
  double turn() const;
  /// @return  once, when it is over: did the rotor follow?
  std::optional<bool> tick(double motor_angle, double dt);

 private:
  enum class Phase : std::uint8_t { kIdle, kOut, kBack };

  double step_ = 0;
  Phase phase_ = Phase::kIdle;
  double time_ = 0;  ///< s, in the phase
  double start_angle_ = 0;
  bool followed_ = false;
};

}  // namespace sinew
