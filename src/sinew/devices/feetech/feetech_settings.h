#pragma once

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/units.h"
#include "sinew/model/device_settings.h"

namespace sinew {

/// Series whose numbers have other orders of bytes and other scales.
enum class FeetechSeries : std::uint8_t { kSts, kScs };

/// Servos on one of Feetech's buses, one a joint, and one for the jaws. Units are the steps that a
/// servo counts: 4096 a turn (STS), 1024 over 300 degrees (SCS).
struct FeetechDevice final : SettingsOf<FeetechDevice> {
  struct Servo {
    std::uint8_t id = 1;
    double centre = 2048;     ///< units at q = 0
    double sign = 1;          ///< -1: it counts against the model
    double torque_limit = 1;  ///< share of what it can; STS only
  };
  struct Gripper {
    std::uint8_t id = 6;
    double open = 3072;    ///< units with the jaws at width_max
    double closed = 2048;  ///< units with the jaws closed
    double torque_limit = 0.5;
  };

  FeetechSeries series = FeetechSeries::kSts;
  FixedVector<Servo, kMaxJoints> servos;  ///< one per joint
  Gripper gripper;                        ///< of a robot that has jaws

  /// How long jaws take from open to closed.
  static constexpr Duration kJawsStroke = std::chrono::milliseconds(1000);
  /// .. and then until it is plain that something is between them.
  static constexpr Duration kJawsStand = std::chrono::milliseconds(200);

  static constexpr std::uint8_t kIdMax = 253;
  static constexpr std::size_t kServosMax = 8;

  bool sts() const { return series == FeetechSeries::kSts; }
  std::endian byte_order() const { return sts() ? std::endian::little : std::endian::big; }
  double units_per_rad() const { return sts() ? 4096 / (2 * kPi) : 1024 / from_deg(300); }
  /// The largest that a position can be; the smallest is 0.
  double units_max() const { return sts() ? 4095 : 1023; }
  double units_of(std::size_t joint, double q) const {
    return servos[joint].centre + servos[joint].sign * units_per_rad() * q;
  }
  double q_of(std::size_t joint, double units) const {
    return servos[joint].sign * (units - servos[joint].centre) / units_per_rad();
  }

  /// Share of the jaws' stroke, 0 closed.
  double opening(double units) const {
    const double share = (units - gripper.closed) / (gripper.open - gripper.closed);
    return std::min(1.0, std::max(0.0, share));
  }

  void identify(IdentityText& out) const override {
    for (const Servo& servo : servos) {
      out.add(static_cast<double>(servo.id)), out.add(servo.centre), out.add(servo.sign);
    }
  }
  /// A servo's horn sits anywhere.
  double trim_max() const override { return kPi; }
  StopFacts stop_facts() const override {
    return {true, "as its joints brake, and 10 ms until the servos hear of it",
            "servos hold; without power, and in free drive, the arm drops"};
  }
  Opening opening() const override {
    return {std::chrono::seconds(3), ", each of whose servos has three tries to reply"};
  }
  double resolution(std::size_t /*joint*/) const override { return 1 / units_per_rad(); }
  MotionDelay motion_delay() const override {
    return {std::chrono::milliseconds(60), std::chrono::milliseconds(220)};
  }
  Duration tool_time(const RobotModel& robot, const ToolAction& action,
                     std::optional<double> jaws) const override;
  std::vector<std::string> profiles() const override {
    return sts() ? std::vector<std::string>{"sts", "scs"} : std::vector<std::string>{"scs", "sts"};
  }
  void use_profile(const std::string& name, Device& device) override;
  bool use_setting(const DeviceSetting& setting, Device& device) override;
  /// Two servos of one number, or a joint whose range its servo cannot count.
  std::string contradiction(const RobotModel& robot) const override;
};

}  // namespace sinew
