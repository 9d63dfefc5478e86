#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "arm_cable.h"
#include "firmware/emulation_avr/avr_board.h"
#include "sinew/devices/maxarm/maxarm_machine.h"

namespace sinew::arduino {

using emulation::AvrBoard;
using emulation::AvrChip;

/// A sketch on an emulated board, wired to a simulated MaxArm that has been on for 20 s.
class SketchBench {
 public:
  /// @param sketch  name of its image without the ending, as "Move-uno": a Mega has the arm at
  ///                Serial1, an Uno at pins 6 and 7
  explicit SketchBench(const std::string& sketch, MaxArmVariant variant = MaxArmVariant::kArduino,
                       MaxArmChecksum checksum = MaxArmChecksum::kSpec);

  void run_for(Duration time) { board.run_until(board.now() + time); }
  /// Runs until the sketch has printed `text`; false where it has not within `limit`.
  bool run_until_printed(const std::string& text, Duration limit);
  std::vector<std::string> lines() const;
  /// Numbers of the first line that begins with `name`.
  std::vector<double> numbers_behind(const std::string& name) const;

  /// Servo pulse and nozzle by the actual position; mm.
  double pulse(std::size_t servo) const;
  std::array<double, 3> point_mm() const;
  PinCable* pins() { return dynamic_cast<PinCable*>(cable.get()); }

  AvrBoard board;
  sim::MaxArmMachine machine;
  std::unique_ptr<ArmCable> cable;
  bool connected = true;
  std::vector<std::uint8_t> sent;  ///< by the board

 private:
  Instant arm_now() const;
  std::optional<std::uint64_t> tick();
};

}  // namespace sinew::arduino
