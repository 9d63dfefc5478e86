#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "sinew/model/device_settings.h"

namespace sinew {

/// How long one move may take, ms; the longest is the servos' own bound.
inline constexpr std::int32_t kMaxArmTimeMin = 20;
inline constexpr std::int32_t kMaxArmTimeMax = 30000;

enum class MaxArmChecksum : std::uint8_t { kSpec, kWithHeader };
enum class MaxArmVariant : std::uint8_t { kArduino, kMicroPython };

/// What the wire calls servo angles: pulse = offset + pulses_per_rad * q, 0..1000.
struct MaxArmServo {
  double offset = 0;
  double pulses_per_rad = 0;
};

/// Of the MicroPython program, at its port; and either side: its loop's own time, and a USB port's.
inline constexpr Duration kMaxArmLookPeriod = std::chrono::milliseconds(100);
inline constexpr Duration kMaxArmLookDoubt = std::chrono::milliseconds(20);
/// 13 bytes at 9600 baud.
inline constexpr Duration kMaxArmSetTime = 13 * std::chrono::microseconds(1042);

/// What a board's program makes of time. The answers' times are those measured on it, 99 in 100.
struct MaxArmPace {
  Duration begins;        ///< from the order of a move until its servos begin
  Duration one_reading;   ///< from the question's first bit
  Duration two_readings;  ///< one behind the other
  Duration idle;          ///< a resting arm is looked at so often, question to question

  /// From a move's own end, by its order and its duration, until it is told as done.
  Duration told() const { return begins + settles + two_readings; }
  /// From the end of the servos' ramps until the arm is looked at.
  static constexpr Duration settles = std::chrono::milliseconds(50);
};
/// docs/wires/maxarm.md, "Timing": answers of 98..275 and 18..424 ms, all equally likely, and 17 ms
/// on the wire; the MicroPython program takes what was sent when it looks at its port.
inline MaxArmPace pace_of(MaxArmVariant variant) {
  using namespace std::chrono_literals;
  if (variant == MaxArmVariant::kArduino) return {kMaxArmSetTime, 290ms, 565ms, 500ms};
  return {kMaxArmSetTime + kMaxArmLookDoubt + kMaxArmLookPeriod, 515ms, 1s, 1s};
}

struct MaxArmDevice final : SettingsOf<MaxArmDevice> {
  std::array<MaxArmServo, 3> servos;  ///< base, shoulder, forearm
  /// What a simulated device answers like; a host accepts both.
  MaxArmChecksum checksum = MaxArmChecksum::kSpec;
  MaxArmVariant variant = MaxArmVariant::kArduino;

  void identify(IdentityText& out) const override {
    for (const MaxArmServo& servo : servos) {
      out.add(servo.offset), out.add(servo.pulses_per_rad);
    }
  }
  StopFacts stop_facts() const override {
    return {true, "0.13 to 0.6 s until told, then 0.1 s",
            "servos hold; without power the arm drops, and the pump lets go"};
  }
  /// The MicroPython program sleeps 10 s and homes 3.5 s.
  Opening opening() const override {
    if (variant == MaxArmVariant::kArduino) return kBoots;
    return {std::chrono::seconds(16),
            ", which may be asleep or homing: 14 s after it was switched on"};
  }
  double resolution(std::size_t joint) const override {
    return 1 / std::abs(servos[joint].pulses_per_rad);
  }
  /// The loops of its servos are that far behind their ramps.
  MotionDelay motion_delay() const override {
    const MaxArmPace pace = pace_of(variant);
    return {pace.begins + std::chrono::milliseconds(12), pace.told()};
  }
  std::pair<Duration, Duration> move_times() const override {
    return {std::chrono::milliseconds(kMaxArmTimeMin), std::chrono::milliseconds(kMaxArmTimeMax)};
  }
  bool has_magnets() const override { return true; }  // a servo that answers -1
  std::optional<Error> target_refusal(const RobotModel& robot, std::span<const double> q,
                                      std::span<const double> from) const override;
  Duration tool_time(const RobotModel& robot, const ToolAction& action,
                     std::optional<double> jaws) const override;
  std::vector<std::string> profiles() const override {
    return {"arduino", "micropython", "arduino-with-header", "micropython-spec"};
  }
  void use_profile(const std::string& name, Device& device) override;
  bool use_setting(const DeviceSetting& setting, Device& device) override;
};

}  // namespace sinew
