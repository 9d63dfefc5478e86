#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/core/split_mix.h"
#include "sinew/devices/maxarm/maxarm_device_ik.h"
#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/devices/maxarm/maxarm_wire.h"
#include "sinew/model/device.h"
#include "sinew/model/robot_model.h"

namespace sinew {

/// The MaxArm's board behind its wire: the maker's Arduino or MicroPython program, with what a
/// user meets of their faults (docs/wires/maxarm.md).
///
/// | state | bytes | left by |
/// |---|---|---|
/// | starting | lost | boot time over; the arm homes by itself in its last part |
/// | listening | Arduino: as they come. MicroPython: what is there, every 100 ms | a request |
/// | busy (reading servos, or Arduino's nozzle) | queue, then are lost | its time over |
/// | dead (MicroPython, a servo that reads 0, outside 0..1000 or nothing) | lost | restart() |
///
/// The servos run their own ramps: evenly in pulses, from where they are told to where they shall
/// be, in the given time. Time comes from outside and must not run back. @rt
class MaxArmFirmware {
 public:
  static constexpr std::size_t kRingArduino = 89;  ///< a ring of 90 holds one less
  static constexpr std::size_t kRingMicroPython = 256;

  /// What a servo's own sensor says, pulses; nothing where the servo does not answer.
  using Readings = std::array<std::optional<std::int16_t>, 3>;

  /// @param seed  of the time that its answers take; @param boot  power comes on
  MaxArmFirmware(const MaxArmDevice& settings, const PalletizerGeometry& geometry,
                 std::uint64_t seed, Instant boot);

  void receive(std::span<const std::uint8_t> bytes, Instant now);
  void advance(Instant now);
  std::size_t take_output(std::span<std::uint8_t> out);
  /// When something happens by itself next. Nothing: it waits for bytes.
  std::optional<Instant> next_event() const;

  /// The servos' sensors as they are now; the next question is answered with them.
  void sense(const Readings& readings) { readings_ = readings; }
  /// The program crashed, and the chip starts again; the servos keep what they were told.
  void restart(Instant now);
  /// Power came back: the servos know nothing until the board homes.
  void power_up(Instant now);

  bool starting() const { return now_ < boot_end_; }
  bool dead() const { return dead_; }
  /// Whether a servo was ever told a place since power came on, and where it is told to be.
  bool driven() const { return driven_; }
  std::array<double, 3> servo_targets(Instant now) const;
  bool ramping(Instant now) const;
  /// us of its PWM; 1500 is the middle.
  double nozzle_us(Instant now) const;
  std::uint8_t suction() const { return suction_; }
  std::uint64_t bytes_lost() const { return bytes_lost_; }
  std::uint64_t restarts() const { return restarts_; }
  /// Requests that were carried out, and the last of them.
  std::uint64_t requests_taken() const { return requests_taken_; }
  const maxarm::Request& last_taken() const { return last_taken_; }

 private:
  struct Ramp {
    double from = 0;
    double to = 0;
    Instant start{};
    Duration time{};
    double at(Instant now) const;
  };

  bool arduino() const { return settings_.variant == MaxArmVariant::kArduino; }
  void process();
  void poll_port();
  void execute(const maxarm::Request& request);
  void move_servos(const maxarm::ServoPulses& pulses, std::uint16_t time_ms);
  void turn_nozzle(const maxarm::SetPwmServo& request);
  void read_servos(bool as_xyz);
  void finish_boot_step();

  MaxArmDevice settings_;
  PalletizerGeometry geometry_;
  SplitMix64 random_;
  Instant now_;

  FixedVector<std::uint8_t, kRingMicroPython> ring_;
  std::size_t poll_left_ = 0;  ///< MicroPython: bytes of this look at the port still to go
  Instant next_poll_{};
  maxarm::RequestDecoder decoder_;
  FixedVector<std::uint8_t, 1024> output_;
  std::uint64_t bytes_lost_ = 0;
  std::uint64_t restarts_ = 0;
  std::uint64_t requests_taken_ = 0;
  maxarm::Request last_taken_;

  Instant boot_home_{};  ///< when it homes
  Instant boot_end_{};
  bool homed_ = false;
  bool dead_ = false;
  Instant busy_until_{};
  std::optional<maxarm::FrameBytes> reply_;  ///< leaves when busy is over

  Readings readings_{};
  bool driven_ = false;
  std::array<Ramp, 3> ramps_{};
  Ramp nozzle_{1500, 1500, {}, {}};
  std::uint8_t suction_ = 3;
};

}  // namespace sinew
