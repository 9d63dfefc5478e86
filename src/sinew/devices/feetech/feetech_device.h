#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sinew/core/instant.h"
#include "sinew/devices/feetech/feetech_settings.h"
#include "sinew/devices/feetech/feetech_wire.h"

namespace sinew::sim {

/// One servo's electronics: its registers, the profile that it makes of a new goal, and how it
/// protects itself. Angles are units. Where the makers' papers say nothing (docs/wires/feetech.md)
/// it does what users have seen. @rt
class FeetechServo {
 public:
  static constexpr std::size_t kSettings = feetech::Register::kSettings;
  using Settings = std::array<std::uint8_t, kSettings>;

  /// Factory settings but its number.
  FeetechServo(FeetechSeries series, std::uint8_t id, Instant boot);

  std::uint8_t id() const { return registers_[feetech::Register::kId]; }
  std::uint8_t trouble() const { return registers_[feetech::Register::kTrouble]; }
  /// Nothing where these registers are not all there.
  std::optional<feetech::Data> read(std::uint8_t address, std::uint8_t count) const;
  void write(std::uint8_t address, const feetech::Data& data);
  /// Kept until action().
  void keep(const feetech::Write& write) { kept_ = write; }
  void action();
  /// Where it is becomes its middle (STS).
  void set_middle();

  /// What its motor is to do.
  struct Command {
    double units = 0;      ///< where its profile is, in the frame of the motor: without offset
    double torque = 0;     ///< share of what it can, 0: motor off
    double stiffness = 1;  ///< of its controller, against a factory one
  };
  Command command() const;
  void advance(Instant now);
  struct Senses {
    double units = 0;  ///< of the motor
    double speed = 0;  ///< units/s
    double duty = 0;   ///< -1 to 1
    double volts = 0;
    double heat = 0;  ///< deg C
  };
  void sense(const Senses& senses);

  /// It lost its power and has it again: what is behind kSettings begins anew, motor off.
  void power_cycle(Instant now);
  /// It holds where it is, as a program before has left it.
  void hold();
  const Settings& settings() const { return lasting_; }
  void set_settings(const Settings& settings);
  /// As a person sets it up.
  void set_word(std::uint8_t address, std::uint16_t word);

 private:
  using Register = feetech::Register;

  bool sts() const { return series_ == FeetechSeries::kSts; }
  std::endian order() const { return sts() ? std::endian::little : std::endian::big; }
  std::uint16_t word(std::uint8_t address) const;
  int offset() const;
  double units_max() const { return sts() ? 4095 : 1023; }
  void begin_goal();
  void protect(double dt);

  FeetechSeries series_;
  std::array<std::uint8_t, feetech::Register::kEnd> registers_{};
  Settings lasting_{};
  std::optional<feetech::Write> kept_;
  Instant now_;
  double profile_ = 0;  ///< present goal of its controller, units as it reports them
  double speed_ = 0;
  double position_ = 0;  ///< as its sensor has it, without offset
  double duty_ = 0;      ///< of its motor, -1 to 1
  double overload_ = 0;  ///< s
  bool protects_ = false;
};

/// Servos on one bus, which hear the same bytes and reply one after the other. @rt but for its
/// construction
class FeetechBusDevice {
 public:
  FeetechBusDevice(FeetechSeries series, std::span<const std::uint8_t> ids, Instant boot);

  void receive(std::span<const std::uint8_t> bytes, Instant now);
  std::size_t take_output(std::span<std::uint8_t> out);
  FeetechServo& servo(std::size_t i) { return servos_[i]; }
  const FeetechServo& servo(std::size_t i) const { return servos_[i]; }
  /// Its plug is out, or in again.
  void plug(std::size_t i, bool in) { plugged_[i] = in; }
  bool plugged(std::size_t i) const { return plugged_[i]; }
  std::uint64_t bytes_lost() const { return bytes_lost_; }
  void power_cycle(Instant now);

 private:
  void hear(const feetech::Request& request);
  void reply(std::size_t i, const feetech::Data& data = {});

  FeetechSeries series_;
  std::vector<FeetechServo> servos_;
  std::array<bool, feetech::kServosMax> plugged_{};
  feetech::PacketDecoder decoder_;
  FixedVector<std::uint8_t, 1024> output_;
  std::uint64_t bytes_lost_ = 0;
};

}  // namespace sinew::sim
