#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/instant.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire.h"

namespace sinew {

/// The BigRobotArm's board, whichever firmware it runs. Time comes from outside and must not run
/// back. @rt
class BigRobotArmBoard {
 public:
  virtual ~BigRobotArmBoard() = default;

  /// It starts again, and a motion ends where it is.
  /// @param deaf  what its boot loader waits  @param power  its supply was away: memory is lost
  virtual void restart(Instant now, Duration deaf, bool power) = 0;
  /// Bytes that arrive at `now`.
  virtual void receive(std::span<const std::uint8_t> bytes, Instant now) = 0;
  virtual void advance(Instant now) = 0;
  /// Moves replies out; how many bytes.
  virtual std::size_t take_output(std::span<std::uint8_t> out) = 0;
  /// When something happens by itself next. Nothing: it waits for bytes.
  virtual std::optional<Instant> next_event() const = 0;

  virtual bool moving() const = 0;
  /// It hears nothing, since it moves.
  virtual bool deaf() const = 0;
  /// Motor microsteps since the beginning, whatever they are called. `now` is not before the last
  /// call's.
  virtual std::array<double, bigrobotarm::kJoints> rotor_steps(Instant now) const = 0;
  /// Where its counters say that it is at `now`.
  virtual std::array<double, bigrobotarm::kJoints> counted_steps(Instant now) const = 0;
  virtual bigrobotarm::Gripper gripper() const = 0;
  virtual std::uint64_t bytes_lost() const = 0;
};

}  // namespace sinew
