#pragma once

#include <cstdint>
#include <optional>

#include "sinew/core/fixed_vector.h"
#include "sinew/devices/grbl/grbl_wire.h"
#include "sinew/driver/device_facts.h"

namespace sinew {

/// What a board has told last.
struct GrblFacts {
  struct Touch {
    std::uint8_t joint = 0;
    std::optional<double> q;  ///< of it where the probe input closed, rad or m; nothing: lost
  };
  struct Board {
    grbl::State state = grbl::State::kIdle;
    grbl::Pins pins;  ///< by its axes
  };
  grbl::Firmware firmware = grbl::Firmware::kGrbl;
  LastHeard<Board> board;
  LastHeard<Touch> touched;  ///< by the last probe; nothing: it did not
};

}  // namespace sinew
