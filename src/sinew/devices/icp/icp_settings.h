#pragma once

#include <array>
#include <chrono>
#include <cstdint>

#include "sinew/model/device_settings.h"

namespace sinew {

/// One leg's motor.
struct IcpLeg {
  bool invert = false;       ///< direction bit 0 shortens the leg
  std::uint8_t address = 0;  ///< 7-bit I2C address of its TMC222, for the simulated device
};

/// What the simulated controller's firmware makes of what the document leaves open or says twice;
/// the host never reads it. The defaults are what a host expects.
struct IcpFirmware {
  bool knows_wake = true;             ///< C0 is a command; else it fails the check of its ones
  bool checks_selector = false;       ///< a status selector must be a whole positioning byte
  bool bit_one_is_plus = false;       ///< direction bit 1 is sent to the motor as +1
  bool minus_one_is_fffe = false;     ///< a -1 is sent as its ones' complement
  bool silent_without_motor = false;  ///< motor 0 or 7: no reply at all instead of 11
  bool ack_without_module = false;    ///< 00 although the module did not acknowledge; else silence
  Duration processing{};              ///< from a byte that needs the modules to its reply
  Duration boot = std::chrono::milliseconds(20);  ///< deaf after power-up
  /// Without a byte for so long it is dead until its power is cut; 0: never.
  Duration idle_shutdown{};
  friend bool operator==(const IcpFirmware&, const IcpFirmware&) = default;
};

struct IcpDevice final : SettingsOf<IcpDevice> {
  double units_per_m = 0;     ///< position units (microsteps) per metre of leg
  double units_per_down = 1;  ///< units that a "-1" really moves: 2 where it is sent as FFFE
  std::array<IcpLeg, 6> legs;
  Duration reply_timeout = std::chrono::milliseconds(50);  ///< beyond the time on the wire
  int tries = 3;
  IcpFirmware firmware;

  /// Units by which two cuts of the supply may move a leg: how it was found stands at
  /// IcpLegClaim.
  static constexpr std::int64_t kPowerCutUnits = 23 * 64;

  void identify(IdentityText& out) const override {
    out.add(units_per_m), out.add(units_per_down);
    for (const IcpLeg& leg : legs) out.add(leg.invert);
  }
  bool shows_power_loss() const override { return true; }
  bool counts_from_power_up() const override { return true; }
  StopFacts stop_facts() const override {
    return {true, "4.2 ms: the microstep under way", "spindles hold, with and without power"};
  }
  /// Noise on the wire may be a step that nobody sent.
  std::optional<CountGrain> count_grain() const override {
    return CountGrain{64 / units_per_m, 16 / units_per_m, 1 / units_per_m,
                      kPowerCutUnits / units_per_m};
  }
  double resolution(std::size_t /*joint*/) const override { return 1 / units_per_m; }
  MotionDelay motion_delay() const override {
    return {std::chrono::milliseconds(4), std::chrono::milliseconds(113)};
  }
  bool watches_leads() const override { return true; }
  std::vector<std::string> profiles() const override {
    return {"table1", "section4", "fffe", "slow", "idle-shutdown"};
  }
  void use_profile(const std::string& name, Device& device) override;
  bool use_setting(const DeviceSetting& setting, Device& device) override;
};

}  // namespace sinew
