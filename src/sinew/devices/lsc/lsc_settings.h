#pragma once

#include <cmath>
#include <cstdint>

#include "sinew/core/units.h"
#include "sinew/model/device_settings.h"

namespace sinew {

enum class LscProfile : std::uint8_t {
  kLsc6,   ///< six PWM servos, open loop: the classic board
  kBus,    ///< bus servos, positions can be read
  kEsp32,  ///< PWM servos, commanded positions can be read; some commands mean other things
};

/// One servo: device units at the joint's zero and per rad, signed. On PWM boards a unit is a
/// microsecond of pulse, on bus boards a thousandth of 240 degrees.
struct LscServo {
  std::uint8_t id = 0;
  double centre = 1500;      ///< units at q = 0
  double units_per_rad = 0;  ///< signed: the servo may turn against the model
  double trim = 0;           ///< units, added to the centre
  std::int32_t lower = 500;  ///< units that may be sent
  std::int32_t upper = 2500;
};

/// The gripper's servo: jaw width is linear in its units.
struct LscGripper {
  std::uint8_t id = 1;
  double open = 1500;    ///< units with the jaws at width_max
  double closed = 2500;  ///< units with the jaws closed
};

/// us, where the ranges of both kits meet: one goes up from there to close, the other to open.
inline constexpr double kJawsMiddle = 1500;
/// A servo that hangs farther off its middle is on the wrong tooth of its shaft.
inline constexpr double kTrimMax = from_deg(15);

struct LscDevice final : SettingsOf<LscDevice> {
  LscProfile profile = LscProfile::kLsc6;
  FixedVector<LscServo, kMaxJoints> servos;  ///< one per joint
  LscGripper gripper;

  void identify(IdentityText& out) const override {
    for (const LscServo& servo : servos) {
      out.add(static_cast<double>(servo.id)), out.add(servo.centre), out.add(servo.units_per_rad),
          out.add(servo.trim);
    }
  }
  double trim_max() const override { return kTrimMax; }
  StopFacts stop_facts() const override {
    return {true, "where the servos are when the stop frame has arrived, 26 ms",
            "servos hold; without power or pulses the arm drops"};
  }
  Opening opening() const override {
    if (profile == LscProfile::kEsp32) return kBoots;
    return {std::chrono::seconds(3), ", which has three tries to answer"};
  }
  double resolution(std::size_t joint) const override {
    return 1 / std::abs(servos[joint].units_per_rad);
  }
  /// Boards that can be asked are asked when their servos have settled.
  MotionDelay motion_delay() const override {
    return {std::chrono::milliseconds(36),
            std::chrono::milliseconds(profile == LscProfile::kLsc6 ? 109 : 480)};
  }
  std::optional<Error> target_refusal(const RobotModel& robot, std::span<const double> q,
                                      std::span<const double> from) const override;
  Duration tool_time(const RobotModel& robot, const ToolAction& action,
                     std::optional<double> jaws) const override;
  std::vector<std::string> profiles() const override;
  void use_profile(const std::string& name, Device& device) override;
  bool use_setting(const DeviceSetting& setting, Device& device) override;
  /// Two servos of one number would both go where one of them is sent.
  std::string contradiction(const RobotModel& robot) const override;
};

}  // namespace sinew
