#pragma once

#include <stdint.h>

#include "sinew/mcu/step_pulses.h"

namespace sinew {
namespace mcu {

/// Where the motors are, in memory that a restart leaves alone and power-up fills with anything.
/// Written in turns, so that a restart at any moment leaves one whole. Without a constructor: it
/// is not cleared as a program begins. @rt
struct KeptPositions {
  struct Slot {
    uint32_t mark;
    uint32_t number;  ///< of the writing
    int32_t steps[kArmAxes];
    uint16_t starts;
    uint8_t moving;
    uint8_t uncertain;  ///< the arm moved as the board restarted, and no host has said since where
                        ///< it is
    uint32_t check;
  };
  Slot slots[2];
  uint8_t last;  ///< which was written last

  /// The newest whole one; nullptr behind a power-up.
  const Slot* find();
  /// @param slot  what is kept; mark, number and check are put in here
  void keep(const Slot& slot);
};

}  // namespace mcu
}  // namespace sinew
