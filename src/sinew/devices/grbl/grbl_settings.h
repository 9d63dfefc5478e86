#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/units.h"
#include "sinew/model/device_settings.h"

namespace sinew {

/// Which firmware a simulated board has; a driver hears it from the board.
enum class GrblFirmware : std::uint8_t { kGrbl, kGrblHal, kFluidNc };
/// Their names, in that order.
inline constexpr std::array<std::string_view, 3> kGrblFirmwares{"grbl", "grblhal", "fluidnc"};

/// A board that speaks GRBL and moves the joints of an arm, axis X the first one. Its units are
/// degrees, or mm of a prismatic joint.
struct GrblDevice final : SettingsOf<GrblDevice> {
  static constexpr std::size_t kAxesMax = 6;
  /// What a line has room for: three decimals.
  static constexpr double kDigit = 1e-3;  // units

  struct Axis {
    double unit = from_deg(1);  ///< of the board, rad or m of the joint
    double steps_per_unit = 0;  ///< negative where the board counts the other way round
    double zero = 0;            ///< rad, m: the joint where a board that is homed counts 0
    bool homes_down = true;     ///< its switch is at the joint's lower end, for the simulated one
  };
  FixedVector<Axis, kAxesMax> axes;
  bool homes = false;  ///< it has switches for all of them
  GrblFirmware firmware = GrblFirmware::kGrbl;

  void identify(IdentityText& out) const override {
    for (const Axis& axis : axes) out.add(axis.steps_per_unit / axis.unit), out.add(axis.zero);
  }
  bool shows_power_loss() const override { return true; }
  bool counts_from_power_up() const override { return !homes; }
  bool searches_zeros() const override { return homes; }
  StopFacts stop_facts() const override {
    return {true, "a character until told, then as its axes brake",
            "held while its motors are on; without power what has weight falls"};
  }
  /// How far one joint may be moved at a time while its place is not known, rad; m where it slides.
  static constexpr double kNudgeMax = from_deg(5);
  static constexpr double kNudgeMaxSliding = from_mm(5);
  /// -1 where the board counts the other way round.
  double sign(std::size_t joint) const { return axes[joint].steps_per_unit < 0 ? -1 : 1; }
  /// Units of the board for so many rad or m, and back.
  double to_units(std::size_t joint, double way) const { return way / axes[joint].unit; }
  double from_units(std::size_t joint, double units) const { return units * axes[joint].unit; }
  double steps_per_unit(std::size_t joint) const { return std::abs(axes[joint].steps_per_unit); }
  /// Of a joint's motor, rad or m.
  double step(std::size_t joint) const { return from_units(joint, 1 / steps_per_unit(joint)); }
  double resolution(std::size_t joint) const override {
    return std::max(step(joint), from_units(joint, kDigit));
  }
  MotionDelay motion_delay() const override {
    return {std::chrono::milliseconds(5), std::chrono::milliseconds(35)};
  }
  std::vector<std::string> profiles() const override {
    return {kGrblFirmwares.begin(), kGrblFirmwares.end()};
  }
  void use_profile(const std::string& name, Device& device) override;
  bool use_setting(const DeviceSetting& setting, Device& device) override;
};

}  // namespace sinew
