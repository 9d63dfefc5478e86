#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/error.h"
#include "sinew/devices/feetech/feetech_settings.h"
#include "sinew/devices/feetech/feetech_wire.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// Servos as a bit each, joints in their order and the jaws' behind them.
inline std::uint8_t servo_bit(std::size_t i) {
  return static_cast<std::uint8_t>(1U << i);
}

/// What a driver knows of one servo, from its replies.
struct FeetechServoState {
  // Of its settings, which outlive its power.
  std::uint16_t firmware = 0;  ///< 0x030A is 3.10; 0: not heard of
  std::uint16_t model = 0;
  std::uint8_t hottest = 0;               ///< deg C
  std::uint8_t volts_max = 0;             ///< tenths
  std::uint8_t volts_min = 0;             ///< tenths
  std::uint16_t lowest = 0, highest = 0;  ///< units; both 0: no limits
  std::uint8_t mode = 0;                  ///< 0: holds positions
  std::uint16_t speed_unit = 1;           ///< units/s
  bool other_order = false;               ///< its numbers have their bytes the other way round
  // As it was when it was asked last.
  bool torque = false;
  std::uint16_t goal = 0;
  std::uint16_t torque_limit = 0;  ///< thousandths
  std::int16_t units = 0;
  std::int16_t speed = 0;                    ///< units/s
  std::int16_t load = 0;                     ///< thousandths of its voltage
  std::uint8_t volts = 0;                    ///< tenths
  std::uint8_t heat = 0;                     ///< deg C
  std::uint8_t trouble = 0;                  ///< bits of feetech::Trouble
  Instant at{};                              ///< when it was asked; nothing is known at 0
  std::optional<std::int16_t> suspect = {};  ///< a position that it cannot have come to
  Instant suspect_at{};
  int off = 0;         ///< replies in a row with its motor off
  int troubled = 0;    ///< replies in a row with the same trouble
  int missed = 0;      ///< replies in a row that did not come
  bool known = false;  ///< it has reported its state since the port was opened
};

/// The servos of a robot, joints in their order and the jaws' behind them: what each has reported,
/// and what that means. @rt
class FeetechServos {
 public:
  /// Registers of one question: settings from 0 on, and state from kStateFrom on.
  static constexpr std::uint8_t kSettingsCount = feetech::Register::kSettings;
  static constexpr std::uint8_t kStateFrom = feetech::Register::kTorque;
  static constexpr std::uint8_t kStateCount = feetech::Register::kMoving + 1 - kStateFrom;

  /// @param joints  one per servo of the device, asserted.
  FeetechServos(const FeetechDevice& device, std::span<const Joint> joints,
                const std::optional<JawGripper>& gripper);

  std::size_t joints() const { return joints_.size(); }
  std::size_t size() const { return joints_.size() + (width_max_ ? 1U : 0U); }
  bool has_jaws() const { return width_max_.has_value(); }
  std::size_t jaws() const { return joints_.size(); }
  const FeetechDevice& device() const { return device_; }
  const Joint& joint(std::size_t i) const { return joints_[i]; }
  std::span<const Joint> limits() const { return {joints_.data(), joints_.size()}; }
  std::uint8_t id(std::size_t i) const;
  std::optional<std::size_t> index_of(std::uint8_t id) const;
  const FeetechServoState& operator[](std::size_t i) const { return states_[i]; }

  void forget();
  void miss(std::size_t i) { ++states_[i].missed; }
  void take_settings(std::size_t i, const feetech::Data& data);
  /// The sum has eight bits: what it cannot have come to is believed when it is said twice.
  /// @param asked  when. @return  whether it is believed
  bool take_state(std::size_t i, const feetech::Reply& reply, Instant asked);

  /// What it cannot do that the robot's file asks for: kServoSeries, kServoMode, kServoRange; with
  /// the joint's index.
  std::optional<Error> misfit() const;
  /// A servo that is beyond its one turn, where no goal says "here": kServoTurns.
  /// @param servos  a bit each
  std::optional<Error> beyond_turn(std::uint8_t servos) const;
  /// What a servo of a joint complains of: kSupplyLow, kSupplyHigh, kEncoderLost, kOverheated,
  /// kOverloaded.
  std::optional<Error> trouble(std::size_t i) const;
  /// The motors of all joints are on.
  bool held() const;
  double q(std::size_t joint) const { return device_.q_of(joint, states_[joint].units); }
  /// Of a joint as it can be sent: 0 to the most that a servo counts.
  double units_of(std::size_t joint, double q) const;
  /// m between the jaws, and back: as far as their servo's own limits let them.
  double width_of(double units) const;
  double units_of_width(double width) const;
  std::optional<double> width_max() const { return width_max_; }
  double torque_limit(std::size_t i) const;

 private:
  bool sts() const { return device_.sts(); }

  FeetechDevice device_;
  FixedVector<Joint, kMaxJoints> joints_;
  std::optional<double> width_max_;
  std::array<FeetechServoState, kMaxJoints> states_{};
};

}  // namespace sinew
