#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/instant.h"
#include "sinew/devices/icp/tmc222_wire.h"

namespace sinew {

/// A TMC222 stepper module as its I2C master and its motor see it. Source: data sheet V1.12,
/// 5.1.14 (states) and 5.2 (registers).
///
///   state     | left by                          | next
///   ----------+----------------------------------+-------------------------------------------
///   kShutdown | GetFullStatus1, faults gone      | kStopped; the bridge drives the coils again
///   kStopped  | target != actual                 | kGotoPos
///   kGotoPos  | the target is reached            | kStopped
///   kGotoPos  | SoftStop                         | kSoftStop: down to the lowest speed
///   kSoftStop | the lowest speed is reached      | kStopped, target := actual
///   moving    | HardStop, or an electrical fault | kStopped or kShutdown, target := actual,
///             |                                  | StepLoss
///   any       | Vdd falls away                   | kShutdown, RAM := OTP, VddReset
///
/// Positioning is ignored while StepLoss or VddReset is set, in kShutdown, and until SetMotorParam
/// was seen since the last reset. GetFullStatus1 tells the flags and clears them, so that motion is
/// possible again. Each microstep is an event of its own; the ramps hold v^2 linear in the way:
/// v'^2 = v^2 +- 2 Acc / microsteps. No clock; Instants never run back. @rt
class Tmc222 {
 public:
  enum class State : std::uint8_t { kShutdown, kStopped, kGotoPos, kSoftStop };

  static constexpr double kVddReset = 5.0;          ///< V at VBB below which the RAM is lost
  static constexpr double kThermalWarning = 145.0;  ///< deg C
  static constexpr double kThermalShutdown = 155.0;

  /// @param otp              what ResetToDefault and every power-up load
  /// @param under_voltage_v  UV2 below this; 7 to 8 V from chip to chip
  Tmc222(std::uint8_t address, const tmc222::Parameters& otp, double under_voltage_v, Instant boot);

  /// A write to its address. False: not acknowledged, it has no supply. What it does not know, and
  /// SetOTPParam above all, it acknowledges and ignores.
  bool write(std::span<const std::uint8_t> bytes, Instant now);
  /// A read of 8 bytes: the answer to the last Get command. @return false: not acknowledged.
  bool read(tmc222::Answer& answer, Instant now);

  /// Makes the microsteps that are due up to `now`.
  void advance(Instant now);
  /// When its next microstep is due.
  std::optional<Instant> next_event() const { return next_step_; }

  void set_supply(double volts, Instant now);
  void set_temperature(double celsius, Instant now);
  /// A coil that is open or shorted; latched in ElDef until it is mended and the status read.
  void set_coil_fault(bool broken, Instant now);

  State state() const { return state_; }
  bool moving() const { return state_ == State::kGotoPos || state_ == State::kSoftStop; }
  /// The bridge drives the coils.
  bool powered() const { return state_ != State::kShutdown; }
  /// Peak current in the coils, mA.
  double current() const;
  /// Sixteenths of a full step since the start of time: what the field has turned. ResetPosition
  /// does not touch it.
  std::int64_t field() const { return field_; }
  const tmc222::Flags& flags() const { return flags_; }
  std::int32_t actual() const { return actual_; }
  std::int32_t target() const { return target_; }
  const tmc222::Parameters& parameters() const { return parameters_; }

 private:
  void execute(const tmc222::Command& command, Instant now);
  void set_parameters(const tmc222::Parameters& parameters);
  void go_to(std::int64_t target, Instant now);
  void begin_leg(Instant now);
  void make_step();
  void arrive(Instant at);
  void schedule(Instant from);
  void stop_hard(bool shutdown);
  void check_faults();
  void reset_ram();
  bool faulty() const;
  tmc222::Status1 status1() const;

  std::uint8_t address_;
  tmc222::Parameters otp_;
  double under_voltage_;
  double volts_ = 12;
  double celsius_ = 25;
  bool coil_broken_ = false;

  State state_ = State::kShutdown;
  tmc222::Parameters parameters_;
  bool parameters_set_ = false;
  tmc222::Flags flags_;
  std::int32_t actual_ = 0;
  std::int32_t target_ = 0;
  std::int64_t field_ = 0;

  double speed_ = 0;   ///< full steps per s along direction_
  int direction_ = 1;  ///< of the motion
  int ramp_ = 0;       ///< 1 speeds up, -1 slows down, 0 level
  std::optional<Instant> next_step_;
  std::optional<tmc222::RunInit> init_;  ///< under way
  bool second_way_ = false;              ///< of init_
  double velocity_top_ = 0;              ///< of the motion under way
  double velocity_low_ = 0;
  tmc222::Answer answer_{};
};

}  // namespace sinew
