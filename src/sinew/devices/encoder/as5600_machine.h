#pragma once

#include <cstdint>

#include "sinew/core/split_mix.h"
#include "sinew/devices/encoder/encoder_device_i2c.h"

namespace sinew::sim {

/// The magnetic angle sensor AS5600 over a magnet that turns: 12 bits a turn, noise, the lag of its
/// filter, and its registers. All from data sheet v1-06 with the settings of a new chip: slow
/// filter x16 (2.2 ms settling, 0.015 deg rms), no hysteresis, ZPOS and MPOS 0.
///
/// Left out: integral nonlinearity (1 deg with an ideal magnet), the 10 counts of hysteresis of
/// ANGLE at the end of its range, low-power modes, writing and burning of settings. @rt
class As5600 {
 public:
  static constexpr std::uint8_t kAddress = 0x36;
  static constexpr double kTurn = 4096;  ///< counts

  enum class Register : std::uint8_t {
    kStatus = 0x0B,
    kRawAngle = 0x0C,
    kAngle = 0x0E,
    kAgc = 0x1A,
    kMagnitude = 0x1B,
  };
  static constexpr std::uint8_t kMagnetDetected = 0x20;
  static constexpr std::uint8_t kMagnetTooWeak = 0x10;
  static constexpr std::uint8_t kMagnetTooStrong = 0x08;

  /// @param angle  rad, of the magnet. @param seed  of its noise
  As5600(double angle, std::uint64_t seed);

  /// The magnet has turned evenly to `angle` over `dt` (s).
  void turn_to(double angle, double dt);

  /// Field at the chip: 1 in the middle of its range, 0 the magnet fell off. Below 0.25 it is not
  /// detected, below 0.5 too weak, above 2 too strong; the limits stand in for 8, 30 and 90 mT.
  void set_field(double field) { field_ = field; }
  bool magnet_ok() const { return field_ >= 0.5 && field_ <= 2; }

  /// What RAW ANGLE holds, 0..4095. Without a magnet the angle is noise.
  std::uint16_t counts() const { return counts_; }
  /// Its STATUS register.
  std::uint8_t status() const;

  /// The I2C side. The pointer stands at 0 after power-up; it goes on by itself with every byte,
  /// apart from RAW ANGLE, ANGLE and MAGNITUDE, where it returns to the high byte.
  void power_cycle() { set_pointer(0); }
  void set_pointer(std::uint8_t address);
  std::uint8_t read_byte();
  /// False for addresses that the chip does not have; it does not acknowledge those.
  static bool has_register(std::uint8_t address);

 private:
  double noise();
  std::uint8_t register_value(std::uint8_t address) const;

  SplitMix64 random_;
  double filtered_;  ///< rad, what the slow filter has come to
  double input_;     ///< rad
  double field_ = 1;
  std::uint16_t counts_ = 0;
  std::uint8_t pointer_ = 0;
  bool latched_ = false;
  std::uint8_t low_byte_ = 0;  ///< latched with its high byte, so that the two belong together
};

/// An I2C bus with that one chip, and what happens to buses.
class As5600Bus : public I2cBus {
 public:
  explicit As5600Bus(As5600& chip) : chip_(chip) {}

  /// Data line held low, or the wire broken: nothing is acknowledged any more.
  void set_stuck(bool stuck) { stuck_ = stuck; }

  bool write(std::uint8_t address, std::span<const std::uint8_t> bytes) override;
  bool read(std::uint8_t address, std::span<std::uint8_t> out) override;

 private:
  As5600& chip_;
  bool stuck_ = false;
};

}  // namespace sinew::sim
