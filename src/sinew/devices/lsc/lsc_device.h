#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/lsc/lsc_device_bus_limits.h"
#include "sinew/devices/lsc/lsc_device_groups.h"
#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/lsc/lsc_wire.h"
#include "sinew/model/device.h"

namespace sinew {

/// A servo board behind the LSC wire, in the three kinds that the LeArm is sold with
/// (docs/wires/lsc.md). A move takes each servo evenly from where its pulses are to the target; a
/// new one takes over from wherever the last one has come to, and nothing on this wire ends one.
///
///   kind   | replies                     | units      | a move out of range | its time
///   kLsc6  | battery, groups             | 500..2500  | refused with beeps  | as sent
///   kBus   | battery, groups, positions  | 0..1000    | refused with beeps  | as sent
///   kEsp32 | version, offsets, commanded | 500..2500  | clamped             | 20..30000 ms
///
/// A bus servo in motor mode (command 26) turns on and on and follows no move until it is a servo
/// again, goes limp or loses its power. Command 27 writes what a servo keeps in itself into all
/// that are attached, 28 reads it from the one with the lowest number (assumed: with several
/// attached nobody has written down who answers).
///
/// A PWM servo gets no pulses before its first move. That one starts at 1500, the board's idea of
/// it, so the servo first jumps there as fast as it can; a bus servo starts where it is.
/// Time comes from outside and must not run back; nothing allocates. @rt
class LscBoard {
 public:
  static constexpr std::size_t kServos = lsc::kBoardServos;  ///< ids 1..6
  static constexpr std::uint8_t kButtonGroup = 100;          ///< what the Run button starts
  static constexpr double kBeepVolts = 5.0;                  ///< below, it beeps once a second

  LscBoard(LscProfile profile, Instant boot);

  /// Bytes that arrive at `now`.
  void receive(std::span<const std::uint8_t> bytes, Instant now);
  /// Lets time pass up to `now`.
  void advance(Instant now);
  /// Moves replies out; how many bytes. What finds no room in the board's buffer is lost.
  std::size_t take_output(std::span<std::uint8_t> out);
  /// When a group goes on or ends by itself. Nothing: it waits for bytes.
  std::optional<Instant> next_event() const { return groups_.due(); }

  /// The Run button: pressed once, or held for 3 s, which runs the group for ever.
  void press_run(bool held, Instant now);
  /// Power was away and is back: groups and saved offsets stay, all else is as at boot.
  void power_cycle(Instant now);

  /// What a servo is told at this moment; units. `driven` is false where it gets nothing.
  struct Command {
    bool driven = false;
    double units = 0;
  };
  Command command(std::uint8_t id) const;
  /// The same without its offset, as the board reports it.
  double commanded(std::uint8_t id) const;

  /// What the board senses: its supply, and on the bus where a servo says that it is.
  void sense_supply(double volts) { supply_volts_ = volts; }
  void sense_position(std::uint8_t id, double units);

  /// What a bus servo keeps in itself.
  const BusServoLimits& limits(std::uint8_t id) const { return servo(id).limits; }

  /// What it and its servos keep without power: of each servo saved offset and limits (as command
  /// 27 writes them), then the groups.
  static constexpr std::size_t kServoBytes = 1 + 13;
  using Memory = FixedVector<std::uint8_t, kServos * kServoBytes + LscGroups::kMemoryBytes>;
  Memory memory() const;
  /// False, and nothing has changed but groups, where these bytes are no such memory.
  bool set_memory(std::span<const std::uint8_t> bytes);

  bool moving() const;
  std::uint64_t beeps() const { return beeps_; }
  std::uint64_t bytes_lost() const { return bytes_lost_; }
  const LscGroups& groups() const { return groups_; }

 private:
  struct Servo {
    bool driven = false;
    double from = 0;
    double to = 0;
    Instant start{};
    Duration duration{};
    double measured = 0;
    std::int8_t offset = 0;
    std::int8_t saved_offset = 0;
    double motor_units_s = 0;  ///< in motor mode: how fast the shaft is to turn
    bool motor = false;
    BusServoLimits limits;
  };

  Servo& servo(std::uint8_t id) { return servos_[id - 1U]; }
  const Servo& servo(std::uint8_t id) const { return servos_[id - 1U]; }
  lsc::Dialect dialect() const;
  double at(const Servo& servo) const;
  bool acceptable(const lsc::Move& move) const;
  void start(const lsc::Move& move);
  void run_group(std::uint8_t group, std::uint16_t times);
  void take(const lsc::Request& request);
  bool take_offset(const lsc::ServoOffset& offset);
  bool take_group_step(const lsc::GroupStep& step);
  bool take_bus(const lsc::Request& request);
  bool take_mode(const lsc::SetMode& mode);
  bool take_info(const lsc::Parameters& info);
  lsc::BusInfo info() const;
  bool jog(const lsc::Jog& by);
  bool take_esp32(const lsc::Request& request);
  bool for_each(const lsc::ServoIds& ids, auto&& action);
  void say(const lsc::Reply& reply);

  LscProfile profile_;
  Instant now_;
  lsc::FrameDecoder decoder_;
  std::array<Servo, kServos> servos_;
  LscGroups groups_;
  std::uint8_t download_group_ = 0;
  std::size_t download_place_ = 0;
  double supply_volts_ = 7.4;
  std::optional<Instant> beeped_;
  std::uint64_t beeps_ = 0;
  std::uint64_t bytes_lost_ = 0;
  FixedVector<std::uint8_t, 512> output_;
};

}  // namespace sinew
